"""Parts of chasers' courses for drawing: flown, thinned out, and joined to lines."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M
from ...fly.trajectory.bodies import body_states
from ...fly.trajectory.kepler import drift, revolution
from ...fly.trajectory.sampling import LONG_STEP_S, Arc, LegPath, sample
from ...kernels.orbits.ephemeris import period
from ...plan.palette import chaser_colours
from ...plan.phases import COLOURS, LABELS, PHASES
from ...plan.plan import Plan
from ...plan.routes import owners, several
from ...problem.instance import Instance
from .chart import Line

Array = npt.NDArray[np.float64]

POINTS_OF_A_RING = 91


@dataclass(frozen=True)
class DrawnArc:
    """A part of a chaser's course, ready to be drawn.

    Attributes
    ----------
    leg : int
        Number of the leg, from 1.
    phase : str
        One of :data:`.PHASES`.
    times_s : (n,) float64
        Since the epoch [s].
    altitudes_m : (n,) float64
        Distances from the centre of the Earth, less its radius [m].
    around_m : (m, 3) float64
        Positions over at most one revolution: the next would be drawn over them; NaN for gaps [m].
    nodes_deg : (2,) float64
        RAAN of the orbit at the first and the last of the times, without a jump [deg].
    """

    leg: int
    phase: str
    times_s: Array
    altitudes_m: Array
    around_m: Array
    nodes_deg: Array


def joined(parts: Iterator[Array] | list[Array]) -> Array:
    """Arrays concatenated with a row of NaN after each: lines with gaps."""
    rows = []
    for part in parts:
        rows += [part, np.full((1, *part.shape[1:]), np.nan)]
    return np.concatenate(rows) if rows else np.empty(0)


Course = Callable[[DrawnArc], Array]
"""Coordinates to draw of an arc, shape (points, 2), or (points, 3) in space."""


def strands(
    instance: Instance,
    plan: Plan,
    arcs: Iterable[DrawnArc],
    course: Course,
    width: float,
    *,
    by_chaser: bool,
) -> list[Line]:
    """A line for each phase, in its colour, ``width`` px wide.

    With ``by_chaser`` each of several chasers has lines and a colour of its own. Its entry in the
    legend is a line of no points, which stays when phases are switched off.
    """
    if not (by_chaser and several(instance)):
        return list(_by_phase(tuple(arcs), course, width))
    whose, gap = owners(instance, plan), (np.nan,)
    entries, lines = [], []
    for name, colour in chaser_colours(instance).items():
        entry = Line(name=name, colour=colour, width=3, in_legend=True, x=gap, y=gap)
        entries.append(entry)
        mine = tuple(arc for arc in arcs if whose[arc.leg] == name)
        lines += [
            replace(line, name=name, colour=colour, in_legend=False)
            for line in _by_phase(mine, course, width)
        ]
    return [*entries, *lines]


def _by_phase(found: tuple[DrawnArc, ...], course: Course, width: float) -> Iterator[Line]:
    for phase in PHASES:
        arcs = [(arc.leg, course(arc)) for arc in found if arc.phase == phase]
        if arcs:
            x, y, *z = joined([points for _, points in arcs]).T
            yield Line(
                name=LABELS[phase],
                colour=COLOURS[phase],
                phase=phase,
                width=width,
                legs=[leg for leg, points in arcs for _ in range(len(points) + 1)],
                x=x,
                y=y,
                z=z[0] if z else None,
            )


MOST_STEPS = 1e6
LEVEL_M = 1.0
"""Change of altitude below which an arc is drawn as a level line."""


@dataclass(frozen=True)
class Track(DrawnArc):
    """A flown arc.

    Attributes
    ----------
    first_m, first_m_s : (3,) float64
        Position [m] and velocity within the plane [m/s] at the first of the times.
    pace, node_rate_rad_s : float
        How the orbit goes on from there, as :class:`adr_opt.fly.trajectory.Arc` has it.
    """

    first_m: Array
    first_m_s: Array
    pace: float
    node_rate_rad_s: float


def tracks(instance: Instance, plan: Plan) -> tuple[Track, ...]:
    """Fly a plan (:func:`adr_opt.fly.trajectory.sample`) and thin out its samples.

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    total_s = sum(max(0.0, leg.done_s - leg.ready_s) for leg in plan.legs)
    step_s = total_s / MOST_STEPS
    flown = sample(instance, plan, step_s if step_s > LONG_STEP_S else None)
    return tuple(_track(instance, path, arc) for path, arc in flown.arcs())


def _track(instance: Instance, path: LegPath, arc: Arc) -> Track:
    phase = arc.phase
    if phase == "service" and path.leg.destination in instance.station_names:
        phase = "refuelling"
    altitudes = np.linalg.norm(arc.positions_m, axis=1) - EARTH_RADIUS_M
    level = np.ptp(altitudes) < LEVEL_M
    ends = [0, -1]
    first = arc.positions_m[0], arc.velocities_m_s[0]
    around, lap_s = arc.positions_m, revolution(*first) / arc.pace
    if arc.end_s - arc.start_s > lap_s:
        laps = np.linspace(0.0, lap_s, POINTS_OF_A_RING)
        around = drift(*first, laps, instance.oblateness_m2)[0]
    normal = np.cross(*first)
    node = np.degrees(np.arctan2(normal[0], -normal[1]))
    drifted = np.degrees(arc.node_rate_rad_s) * (arc.end_s - arc.start_s)
    return Track(
        path.number,
        phase,
        arc.times_s[ends] if level else arc.times_s,
        altitudes[ends] if level else altitudes,
        around,
        np.array([node, node + drifted]),
        *first,
        arc.pace,
        arc.node_rate_rad_s,
    )


def ring(instance: Instance, body: str) -> Array:
    """One revolution of a body on its planning circle, shape (points, 3) [m]."""
    lap_s = period(instance.body_orbits[instance.names.index(body)].semi_major_axis_m)
    return body_states(instance, body, np.linspace(0.0, lap_s, POINTS_OF_A_RING))[0]
