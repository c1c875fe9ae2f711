"""Orbital planes: nodes against time, targets by plane, and costs between all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...common.constants import DAY_S, HOUR_S
from ...common.errors import InputError
from ...fly.trajectory.kepler import Array
from ...kernels.orbits import elements
from ...kernels.orbits.ephemeris import EPOCH_S
from ...legs.matrices import Matrices
from ...plan.palette import REASON_TITLES, STATION, UNVISITED, VISITED, chaser_colours
from ...plan.plan import Plan
from ...plan.routes import Flown, routes_of, several
from ...problem.instance import Instance
from .chart import DAYS, Chart, ChartAxis, Line, Marks, Series, days, draw, label
from .strands import DrawnArc, joined, strands


def raan_deg(instance: Instance) -> np.ndarray[Any, np.dtype[np.float64]]:
    """RAAN of the bodies, unwrapped to avoid jumps, shape (bodies,) [deg].

    Within half a turn of the first body's, so that planes near 0° and near 360° are side by side.
    """
    raan = np.array([orbit.raan_deg for orbit in instance.body_orbits])
    around: np.ndarray[Any, np.dtype[np.float64]] = np.mod(raan - raan[0] + 180.0, 360.0) - 180.0
    home = float(np.mod(raan[0] + 180.0, 360.0) - 180.0)
    return home + around


def way(instance: Instance, flown: Flown) -> tuple[list[int], list[int]]:
    """Numbers of the bodies that a chaser visits from its start, each with its leg or 0."""
    index = {name: number for number, name in enumerate(instance.names)}
    home = [] if flown.chaser.is_launched else [(0, flown.chaser.start_name)]
    there = [*home, *((number, leg.destination) for number, leg in flown.legs)]
    known = [(number, index[name]) for number, name in there if name in index]
    return [number for number, _ in known], [body for _, body in known]


_LEFT_OUT = """
circle-open x-thin-open square-open triangle-up-open triangle-down-open diamond-open pentagon-open
star-open cross-thin-open
"""
LEFT_OUT = tuple(_LEFT_OUT.split())
"""Marks of targets that are not visited: without a reason, and for each."""


def planes_chart(instance: Instance, plan: Plan | None) -> Chart:
    """RAAN across and inclination up, in degrees; a line follows each chaser."""
    raan, first = raan_deg(instance), instance.first_target
    inclination = np.array([orbit.inclination_deg for orbit in instance.body_orbits])
    colours = chaser_colours(instance)

    def at(bodies: list[int], legs: Sequence[int] | None = None) -> dict[str, Any]:
        of = list(zip(legs or [0] * len(bodies), bodies, strict=True))
        return {"x": raan[bodies], "y": inclination[bodies], "of": of, "legs": legs}

    series: list[Series] = []
    visits: list[tuple[int, int]] = []
    for flown in () if plan is None else routes_of(instance, plan):
        name, (legs, bodies) = flown.chaser.name, way(instance, flown)
        said = name if several(instance) else "chaser"
        series.append(Line(name=said, colour=colours[name], width=1.0, **at(bodies, legs)))
        visits += [
            (leg, body) for leg, body in zip(legs, bodies, strict=True) if leg and body >= first
        ]
    seen = {body for _, body in visits}
    others = [body for body in range(first, raan.size) if body not in seen]
    why = {} if plan is None else {entry.target: entry.reason for entry in plan.unvisited}
    for reason, symbol in zip((None, *REASON_TITLES), LEFT_OUT, strict=True):
        mine = [body for body in others if why.get(instance.names[body]) == reason]
        said = "target" if plan is None else "not visited"
        if reason is not None:
            said = f"left out, {REASON_TITLES[reason]}: {len(mine)}"
        if mine:
            series.append(Marks(name=said, colour=UNVISITED, symbol=symbol, **at(mine)))
    if plan is not None:
        there = at([body for _, body in visits], [leg for leg, _ in visits])
        series.append(Marks(name="visited", colour=VISITED, **there))
    stations = at(list(range(len(instance.stations))))
    series.append(Marks(name="station", colour=STATION, symbol="square", size=12, **stations))
    return Chart(tuple(series), ChartAxis("RAAN [°]", 4), ChartAxis("inclination [°]", 4))


def planes(ax: Any, instance: Instance, plan: Plan | None = None) -> Any:
    """Add the orbital planes as points, with RAAN across and inclination up [deg].

    With a plan, targets that it visits differ from the others, which are marked by the reasons why
    they are left out, and a line follows each chaser from plane to plane.
    """
    if plan is not None:
        plan.instance.refuse_other(instance)
    return draw(ax, planes_chart(instance, plan))


def matrix(ax: Any, matrices: Matrices, departure: int = 0, quantity: str = "delta_v") -> Any:
    """Add ΔV [m/s] or duration [h] of all transfers at one ready time as an image.

    Rows are origins, columns destinations, the stations first; pairs without a transfer stay empty.
    The image is ``ax.images[-1]``, for a colour bar.

    Parameters
    ----------
    matrices : Matrices
    departure : int
        Which of ``matrices.departures``.
    quantity : {"delta_v", "duration"}

    Raises
    ------
    InputError
        Another quantity, or there is no such departure.
    """
    if quantity not in ("delta_v", "duration"):
        raise InputError(f"quantity = {quantity!r}: must be 'delta_v' or 'duration'")
    if not -len(matrices.departures) <= departure < len(matrices.departures):
        raise InputError(
            f"departure = {departure}: must be less than {len(matrices.departures)}, the number "
            "of departures in the matrices"
        )
    costs = getattr(matrices, quantity)[departure]
    if quantity == "duration":
        costs = costs / HOUR_S
    shown = np.where(np.isfinite(costs), costs, np.nan)
    np.fill_diagonal(shown, np.nan)  # a body itself is no transfer
    ax.imshow(shown, interpolation="none")
    return label(ax, "destination", "origin")


TURN_DEG = 360.0


@dataclass(frozen=True)
class Nodes:
    """RAANs relative to the bodies' common drift, which would make all lines steep.

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
