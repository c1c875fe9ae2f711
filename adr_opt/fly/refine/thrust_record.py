"""Flown thrust as refined plans have it: arcs with their laws and windows."""

from __future__ import annotations

import math

import numpy as np

from ...kernels.orbits.short_periods import Array
from ...kernels.orbits.thrusting import Push
from ...plan.refined_thrust import SteeredArc


def steered_arcs(push: Push, laws: Array, windows: Array) -> tuple[SteeredArc, ...]:
    """Arcs of thrust with the ΔV of each.

    Parameters
    ----------
    push : Push
        At the beginning of the first one.
    laws : (arcs, 5) float64
    windows : (windows, 3) float64
        Beginning [s], end [s] and arc of each window, as :func:`.thrusting.fly` writes them.
    """
    arcs, mass = [], push.mass
    for number, law in enumerate(laws):
        mine = windows[windows[:, 2] == number, :2]
        after = mass - push.force / push.exhaust * float(np.diff(mine, axis=1).sum())
        arcs.append(
            SteeredArc(
                delta_v_m_s=push.exhaust * math.log(mass / after),
                steering=tuple(law.tolist()),
                windows_s=tuple((float(start), float(end)) for start, end in mine),
            )
        )
        mass = after
    return tuple(arcs)
