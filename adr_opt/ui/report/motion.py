"""Data that move chasers and bodies on the page: their orbits in place of positions.

Whatever time the reader asks for, the script of the page has the state of the closed form that the
plan was made with, and a mission of two years takes no more room than one of a day.
"""

from __future__ import annotations

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
from ..plot.strands import DrawnArc
from ..plot.thrust_arcs import SpiralArc
from ..plot.tracks import Track
from .figures.orbits import kinds_shown
from .greenwich import greenwich
from .spirals import spirals
from .sun import sun
from .text import in_chart

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
        by number of the body, and when the chaser leaves, is at the stand-off and has docked [s].
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
    standoff = next((burn.time_s for burn in leg.burns if burn.phase == "approach"), None)
    return {
        "chaser": chaser,
        "to": at.get(leg.destination),
        "leaves": leg.leaves_s,
        "standoff": standoff,
        "docked": leg.docked_s,
        "launch": leg.traits.from_nowhere,
    }
