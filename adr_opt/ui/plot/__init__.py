"""Plots for notebooks: each function takes a matplotlib axis, adds one thing and returns it.

The axis is a ``matplotlib.axes.Axes``, and an ``Axes3D`` for what lies in space. It is returned, so
that calls can be put into each other. Nothing is cleared, no legend, title or figure is made: those
are the caller's. Labels of the axes are set where they are still empty.
Times are drawn in days since the epoch, altitudes in km, ΔV in m/s, angles in degrees.

Only the objects given are used: this package does not import matplotlib, and works with every
axis that has its methods (extra ``[viz]`` installs it).

>>> import adr_opt, adr_opt.ui.plot
>>> import matplotlib.pyplot as plt
>>> instance = adr_opt.generate("tiny", seed=0)
>>> plan = adr_opt.solve(instance, method="greedy-guarded").plan
>>> figure, ax = plt.subplots()
>>> ax = adr_opt.ui.plot.altitude(adr_opt.ui.plot.keep_out_zones(ax, instance), instance, plan)
"""

from __future__ import annotations

from ...plan.phases import COLOURS, LABELS, PHASES
from .budget import delta_v_left, leg_delta_v, mass
from .courses import altitude, earth, keep_out_zones, nodes, orbits, path
from .fronts import tradeoff
from .gantt import Segment, gantt, segments
from .nodes import matrix, planes
from .studies import approaches

__all__ = [
    "COLOURS",
    "LABELS",
    "PHASES",
    "Segment",
    "altitude",
    "approaches",
    "delta_v_left",
    "earth",
    "gantt",
    "keep_out_zones",
    "leg_delta_v",
    "mass",
    "matrix",
    "nodes",
    "orbits",
    "path",
    "planes",
    "segments",
    "tradeoff",
]
