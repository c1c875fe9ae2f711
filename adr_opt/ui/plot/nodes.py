"""Nodes against time: how the planes drift, and how the chaser goes from one to the next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...common.constants import DAY_S
from ...fly.flight.flyable import refuse_foreign
from ...fly.trajectory.kepler import Array
from ...kernels.orbits import elements
from ...kernels.orbits.ephemeris import EPOCH_S
from ...plan.palette import COLOURS, LABELS, PHASES, STATION, UNVISITED, VISITED
from ...plan.plan import Plan
from ...problem.instance import Instance
from .axes import label
from .fields import raan_deg
from .tracks import Track, joined, tracks

TURN_DEG = 360.0


@dataclass(frozen=True)
class Nodes:
    """RAANs less the drift that the bodies have in common, without which all lines are steep.

    Attributes
    ----------
    common_deg_s : float
        That drift: the median of the bodies' rates [deg/s].
    low_deg : float
        Angles are shown from here on, for a turn [deg].
    """

    common_deg_s: float
    low_deg: float

    def line(self, times_s: Array, raans_deg: Array) -> tuple[Array, Array]:
        """A node that moves evenly between two times, with a row of NaN where it goes around.

        Parameters
        ----------
        times_s, raans_deg : (2,) float64
            The RAAN without a jump.

        Returns
        -------
        times_s, shown_deg : (n,) float64
        """
        first, last = np.asarray(raans_deg) - self.common_deg_s * np.asarray(times_s)
        begin, end = (float(time) for time in times_s)
        laps = np.floor((np.array([first, last]) - self.low_deg) / TURN_DEG)
        edges = self.low_deg + TURN_DEG * np.arange(laps.min() + 1, laps.max() + 1)
        cuts = np.sort(begin + (edges - first) / (last - first or 1.0) * (end - begin))
        cuts = np.clip(cuts, begin, end)  # what is off by rounding alone is no other time
        ends = np.array([begin, *cuts, end])
        angles = np.interp(ends, [begin, end], [first, last]) if end > begin else np.full(2, first)
        pieces = []
        for at in range(ends.size - 1):
            piece = slice(at, at + 2)
            lap = np.floor((angles[piece].mean() - self.low_deg) / TURN_DEG)
            pieces.append(np.column_stack([ends[piece], angles[piece] - TURN_DEG * lap]))
        rows = joined(pieces)[:-1]
        return rows[:, 0], rows[:, 1]


def nodes_of(instance: Instance) -> Nodes:
    """How the nodes of an instance are shown: about that of its first body."""
    rates = np.degrees(elements.node_rates(instance.orbits(), EPOCH_S))
    home = float(raan_deg(instance)[0]) if rates.size else 0.0
    return Nodes(float(np.median(rates)) if rates.size else 0.0, home - 0.5 * TURN_DEG)


def of_body(instance: Instance, shown: Nodes, body: int, until_s: float) -> tuple[Array, Array]:
    """The node of a body from the epoch until a time, as :meth:`Nodes.line` gives it."""
    row = instance.orbits()[body]
    ends = np.array([0.0, until_s])
    return shown.line(ends, np.degrees(elements.nodes(row, ends)))


def of_track(shown: Nodes, track: Track) -> tuple[Array, Array]:
    """The node of the chaser's orbit on an arc, as :meth:`Nodes.line` gives it."""
    return shown.line(track.times_s[[0, -1]], track.nodes_deg)


def nodes(ax: Any, instance: Instance, plan: Plan | None = None) -> Any:
    """Add RAAN [deg] against time [days], less the drift that the bodies have in common.

    Targets are thin lines. With a plan, those that it visits differ from the others, and thick
    lines, one colour per phase, follow the chaser: on a drift orbit its node crosses to the next.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    instance : Instance
    plan : Plan, optional

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    if plan is not None:
        refuse_foreign(instance, plan)
    visited = set() if plan is None else set(plan.destinations)
    shown, until_s = nodes_of(instance), instance.mission.duration_s
    titles = set()
    for body, name in enumerate(instance.names):
        colour, title = UNVISITED, "target" if plan is None else "not visited"
        if name in instance.station_names:
            colour, title = STATION, "station"
        elif name in visited:
            colour, title = VISITED, "visited"
        elif body < instance.first_target:
            continue
        times, angles = of_body(instance, shown, body, until_s)
        ax.plot(
            times / DAY_S, angles, color=colour, linewidth=0.6,
            label=None if title in titles else title,
        )  # fmt: skip
        titles.add(title)
    flown = tracks(instance, plan) if plan is not None else ()
    for phase in PHASES:
        lines = [of_track(shown, track) for track in flown if track.phase == phase]
        if lines:
            ax.plot(
                joined([times for times, _ in lines]) / DAY_S,
                joined([angles for _, angles in lines]),
                color=COLOURS[phase], linewidth=2.4, label=LABELS[phase],
            )  # fmt: skip
    label(ax, "days since the epoch", axis_title(shown))
    return ax


def axis_title(shown: Nodes, unit: str = "deg") -> str:
    """What stands beside the axis of the angles."""
    if shown.common_deg_s == 0.0:
        return f"RAAN [{unit}]"
    rate = f"{shown.common_deg_s * DAY_S:+.3f}".replace("-", "−")
    return f"RAAN less {rate}°/day [{unit}]"
