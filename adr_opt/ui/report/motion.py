"""Data for the motion of chasers and bodies on the page: orbits in place of positions.

Whatever time the reader asks for, the script of the page has the state of the closed form that the
plan was made with, and a mission of two years takes no more room than one of a day.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import groupby
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...kernels.orbits import elements, ephemeris
from ...kernels.orbits.ephemeris import EPOCH_S
from ...plan.palette import STATION, UNVISITED, VISITED, chaser_colours
from ...plan.phases import COLOURS, LABELS, PHASES
from ...plan.plan import Leg, Plan
from ...plan.routes import Flown, routes_of, several
from ...problem.instance import Instance
from ...problem.sun import greenwich, sun
from ..plot.strands import DrawnArc, Track
from ..plot.thrust_arcs import SpiralArc
from .text import in_chart

STEERED = "drift"
"""Phase in which the argument of latitude is turned to that of the target."""

MOST_RINGS = 200
"""Maximum number of orbits drawn; beyond it, some of those not visited are omitted."""

SAME_RAD = 1e-6
"""Difference of arguments of latitude up to which a chaser is at a body."""


def spirals(arcs: Iterable[SpiralArc], latitude: float | None) -> list[list[Any]]:
    """Arcs of a chaser, in order of time, as lists for the script of the page.

    ``latitude`` is the argument of latitude of its origin where its first arc begins [rad]; None if
    it is launched to its first target.

    Each list has the number of the leg, phase, begin and end [s], speed of the circular orbit and
    its rate [m/s, m/s²], inclination, node and argument of latitude with their rates [rad, rad/s],
    and middle and half width of the windows of thrust [rad], or None. The argument of latitude
    moves by v³/μ, and by its rate in addition.
    """
    made: list[list[Any]] = []
    for _, group in groupby(arcs, key=lambda arc: arc.leg):
        mine = list(group)
        extra = _steering(mine, latitude)
        for arc in mine:
            latitude, line = _line(arc, latitude, extra)
            made.append(line)
    return made


def turned_rad(arc: SpiralArc) -> float:
    """Change of the argument of latitude on circles along an arc: the integral of v³/μ [rad]."""
    first, last = arc.speeds_m_s
    cubes = last**3 + last**2 * first + last * first**2 + first**3
    return float(_duration_s(arc) * cubes / (4.0 * MU_M3_S2))


def _duration_s(arc: SpiralArc) -> float:
    return float(arc.times_s[-1] - arc.times_s[0])


def _line(arc: SpiralArc, latitude: float | None, extra_rad_s: float) -> tuple[float, list[Any]]:
    """The argument of latitude at the end of an arc, and its list."""
    duration_s, rate = _duration_s(arc), extra_rad_s if arc.phase == STEERED else 0.0
    begin = latitude or 0.0
    if arc.latitudes_rad is not None:
        rate = float(np.ptp(arc.latitudes_rad) - turned_rad(arc)) / duration_s
        if latitude is None or not _leaves(arc, latitude):
            begin = float(arc.latitudes_rad[0])
    changes = [
        value
        for pair in (arc.speeds_m_s, arc.inclinations_rad, np.radians(arc.nodes_deg))
        for value in (float(pair[0]), float(pair[1] - pair[0]) / duration_s)
    ]
    window = [None, None] if arc.window_rad is None else arc.window_rad.tolist()
    line = [
        arc.leg,
        arc.phase,
        float(arc.times_s[0]),
        float(arc.times_s[-1]),
        *changes,
        math.fmod(begin, 2.0 * math.pi),
        rate,
        *window,
    ]
    return begin + turned_rad(arc) + rate * duration_s, line


def _leaves(arc: SpiralArc, latitude: float) -> bool:
    """Whether a chaser waits where a tow has left it, away from any body."""
    if arc.phase != "wait" or arc.latitudes_rad is None:
        return False
    return abs(_away(float(arc.latitudes_rad[0]), latitude)) > SAME_RAD


def _steering(arcs: list[SpiralArc], latitude: float | None) -> float:
    """Rate that turns a chaser on its drift orbit so that it meets its target [rad/s]."""
    steered_s = math.fsum(_duration_s(arc) for arc in arcs if arc.phase == STEERED)
    at = next((at for at, arc in enumerate(arcs) if arc.phase == "thrust"), None)
    if at is None or not steered_s:
        return 0.0
    for arc in arcs[:at]:
        latitude, _ = _line(arc, latitude, 0.0)
    here = latitude or 0.0
    for arc in arcs[at:]:
        if arc.latitudes_rad is not None:
            return _away(float(arc.latitudes_rad[0]), here) / steered_s
        here += turned_rad(arc)
    return 0.0


def _away(to: float, since: float) -> float:
    """Angle from one direction to another, within half a turn [rad]."""
    return math.remainder(to - since, 2.0 * math.pi)


ELEMENTS = (
    ephemeris.radius_at,
    ephemeris.inclination_at,
    ephemeris.node_at,
    ephemeris.node_rate_at,
    ephemeris.latitude_at,
    ephemeris.latitude_rate_at,
)
"""Elements of a body: a circle whose node and argument of latitude advance uniformly."""

KINDS = {"station": STATION, "visited": VISITED, "not visited": UNVISITED}
"""Kinds of bodies, with their colours."""


def motion(instance: Instance, plan: Plan, drawn: tuple[DrawnArc, ...]) -> dict[str, Any]:
    """Orbits of the displayed bodies and of the chasers, arc by arc.

    Parameters
    ----------
    instance : Instance
        Not one whose connections are given.
    plan : Plan
    drawn : tuple of DrawnArc
        The plan as flown, :class:`.Track`, or with low thrust as its arcs say,
        :class:`.SpiralArc`; empty if it leads nowhere.

    Returns
    -------
    dict
        ``bodies`` have a name, a kind and a ``row`` of :data:`ELEMENTS` at the epoch [m, rad,
        rad/s]. ``chasers`` have ``arcs``: number of the leg, phase, begin and end [s], position [m]
        and velocity [m/s] at the begin, pace and rate of the node [–, rad/s], as
        :class:`adr_opt.fly.trajectory.Arc` has them; if ``spirals`` is true, they are those of
        :func:`.spirals`. ``legs`` say whose they are, where they lead,
        by number of the body, what they cost [m/s], and when the chaser leaves, is at the
        stand-off and has docked [s].
        ``keepOut`` is the radius around targets that a safety ellipse keeps out of, or None [m].
        ``sidereal`` is the angle of Greenwich at the epoch and its rate [rad, rad/s]; ``sun`` is as
        :class:`.Sun` has it.
    """
    shown = {name: kind for kind, names in kinds_shown(instance, plan) for name in names}
    at = {name: number for number, name in enumerate(shown)}
    rows = instance.orbits()
    bodies = [
        {"name": in_chart(name), "kind": kind, "row": _row(rows[instance.names.index(name)])}
        for name, kind in shown.items()
    ]
    colours = chaser_colours(instance)
    routes = routes_of(instance, plan)
    low = instance.has_low_thrust
    tracks = tuple(arc for arc in drawn if isinstance(arc, Track))
    return {
        "spirals": low,
        "mu": MU_M3_S2,
        "radius": EARTH_RADIUS_M,
        "sidereal": list(greenwich(instance)),
        "sun": list(sun(instance)),
        "kinds": KINDS,
        "phases": {phase: [LABELS[phase], COLOURS[phase]] for phase in PHASES},
        "keepOut": instance.transfer.kept_out_m,
        "bodies": bodies,
        "chasers": [
            {
                "name": in_chart(flown.chaser.name),
                "colour": colours[flown.chaser.name] if several(instance) else None,
                "arcs": _arcs(flown, tracks) if not low else _spirals(instance, flown, drawn),
                "stays": not (flown.legs and flown.legs[-1][1].removal_burns),
            }
            for flown in routes
        ],
        "legs": [
            _leg(leg, chaser, at) for chaser, flown in enumerate(routes) for _, leg in flown.legs
        ],
    }


def kinds_shown(instance: Instance, plan: Plan) -> tuple[tuple[str, list[str]], ...]:
    """Bodies whose orbits are drawn, by kind."""
    names, visited = [target.name for target in instance.targets], set(plan.destinations)
    return (
        ("station", list(instance.station_names)),
        ("visited", [name for name in names if name in visited]),
        ("not visited", [name for name in names if name not in visited][:MOST_RINGS]),
    )


def _row(body: npt.NDArray[np.float64]) -> list[float]:
    return [float(element(body, EPOCH_S)) for element in ELEMENTS]


def _arcs(flown: Flown, tracks: tuple[Track, ...]) -> list[list[Any]]:
    mine = {number for number, _ in flown.legs}
    return [
        [
            track.leg,
            track.phase,
            float(track.times_s[0]),
            float(track.times_s[-1]),
            *(float(value) for value in (*track.first_m, *track.first_m_s)),
            track.pace,
            track.node_rate_rad_s,
        ]
        for track in tracks
        if track.leg in mine
    ]


def _spirals(instance: Instance, flown: Flown, drawn: tuple[DrawnArc, ...]) -> list[list[Any]]:
    legs = dict(flown.legs)
    mine = [arc for arc in drawn if isinstance(arc, SpiralArc) and arc.leg in legs]
    if not mine:
        return []
    first = legs[mine[0].leg]
    origin = instance.orbits()[instance.names.index(first.origin)]
    begins_s = float(mine[0].times_s[0])
    at_launch = first.traits.from_nowhere
    latitude = None if at_launch else float(elements.latitudes(origin, begins_s))
    return spirals(mine, latitude)


def _leg(leg: Leg, chaser: int, at: dict[str, int]) -> dict[str, Any]:
    return {
        "chaser": chaser,
        "to": at.get(leg.destination),
        "cost_m_s": leg.delta_v_m_s,
        "leaves": leg.leaves_s,
        "standoff": leg.standoff_s,
        "docked": leg.docked_s,
        "launch": leg.traits.from_nowhere,
    }
