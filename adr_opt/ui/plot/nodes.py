"""Nodes against time: the drift of planes, and the chaser's way between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...common.constants import DAY_S
from ...fly.trajectory.kepler import Array
from ...kernels.orbits import elements
from ...kernels.orbits.ephemeris import EPOCH_S
from ...plan.palette import STATION, UNVISITED, VISITED
from ...plan.plan import Plan
from ...problem.instance import Instance
from .chart import DAYS, Chart, ChartAxis, Line, days
from .fields import raan_deg
from .strands import DrawnArc, joined, strands

TURN_DEG = 360.0


@dataclass(frozen=True)
class Nodes:
    """RAANs relative to the bodies' common drift, without which all lines would be steep.

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
        """A node moving uniformly between two times, with a row of NaN where it wraps around.

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
    """Display of an instance's nodes, centred on that of its first body."""
    rates = np.degrees(elements.node_rates(instance.orbits(), EPOCH_S))
    home = float(raan_deg(instance)[0]) if rates.size else 0.0
    return Nodes(float(np.median(rates)) if rates.size else 0.0, home - 0.5 * TURN_DEG)


def of_body(instance: Instance, shown: Nodes, body: int, until_s: float) -> tuple[Array, Array]:
    """Node of a body from the epoch until a time, as from :meth:`Nodes.line`."""
    row = instance.orbits()[body]
    ends = np.array([0.0, until_s])
    return shown.line(ends, np.degrees(elements.nodes(row, ends)))


def of_track(shown: Nodes, track: DrawnArc) -> tuple[Array, Array]:
    """Node of the chaser's orbit on an arc, as from :meth:`Nodes.line`."""
    return shown.line(track.times_s[[0, -1]], track.nodes_deg)


def nodes_chart(
    instance: Instance, plan: Plan | None, tracks: tuple[DrawnArc, ...], *, by_chaser: bool
) -> Chart:
    """RAAN [°] against days, relative to the common drift: bodies thin, flown arcs thick."""
    shown = nodes_of(instance)
    missed, visited = "target", set[str]()
    if plan is not None:
        missed, visited = "not visited", set(plan.destinations)
    colours = {missed: UNVISITED, "visited": VISITED, "station": STATION}
    kinds: dict[str, list[int]] = {kind: [] for kind in colours}
    for body, name in enumerate(instance.names):
        if name in instance.station_names:
            kinds["station"].append(body)
        elif body >= instance.first_target:
            kinds["visited" if name in visited else missed].append(body)

    def line(kind: str) -> Line:
        until_s = instance.mission.duration_s
        found = [(body, *of_body(instance, shown, body, until_s)) for body in kinds[kind]]
        x, y = joined([np.column_stack([days(times), angles]) for _, times, angles in found]).T
        names = [instance.names[body] for body, times, _ in found for _ in range(times.size + 1)]
        return Line(name=kind, colour=colours[kind], x=x, y=y, width=1.0, of=names)

    def course(track: DrawnArc) -> Array:
        times_s, angles = of_track(shown, track)
        return np.column_stack([days(times_s), angles])

    lines = [line(kind) for kind, found in kinds.items() if found]
    if plan is not None:
        lines += strands(instance, plan, tracks, course, 4.0, by_chaser=by_chaser)
    rate = f"{shown.common_deg_s * DAY_S:+.3f}".replace("-", "−")
    title = f"RAAN less {rate}°/day [°]" if shown.common_deg_s else "RAAN [°]"
    return Chart(tuple(lines), DAYS, ChartAxis(title, 4))
