"""The section on arcs of low thrust: times of thrust of each leg, and of each chaser in all."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from ...common.constants import DAY_S
from ...plan.plan import Leg, LowThrustArc, Plan
from ...plan.routes import Flown, routes_of
from ...problem.instance import Instance
from ..plot.chart import KM_M
from ..plot.strands import DrawnArc
from .tables import Column, route_cell, table_of
from .text import NOTHING, escape, fixed, number

NOTE = (
    "A leg thrusts, drifts and thrusts again. In the days of an arc thrust is on within windows "
    "about two opposite places of each revolution, and off in the shadow; in those of a tow, "
    "wherever there is sunlight. Thrust on is the time in which full thrust takes the propellant "
    "that is used; a chaser that throttles has it on for longer."
)


class ThrustTimes(NamedTuple):
    """Times of thrust of a leg and of the tow after it [s].

    Attributes
    ----------
    arcs_s, tow_s : float
        From the begin to the end of both arcs, and of the tow.
    leg_on_s, tow_on_s : float
        In which full thrust takes the propellant that they use.
    """

    arcs_s: float
    tow_s: float
    leg_on_s: float
    tow_on_s: float


NO_THRUST = ThrustTimes(0.0, 0.0, 0.0, 0.0)


def thrust_times(instance: Instance, flown: Flown) -> dict[int, ThrustTimes]:
    """Times of thrust of a chaser with low thrust, by number of the leg."""
    chaser, stages = flown.chaser, flown.aboard(instance)[1:]
    assert chaser.thrust_n is not None
    s_per_kg = chaser.tank.exhaust_m_s / chaser.thrust_n
    found = {}
    departing = flown.departing_kg(instance)
    for (at, leg), mass_kg, after in zip(flown.legs, departing, stages, strict=False):
        used_kg = -mass_kg * math.expm1(-leg.delta_v_m_s / chaser.tank.exhaust_m_s)
        found[at] = ThrustTimes(
            math.fsum(arc.end_s - arc.start_s for arc in leg.manoeuvres or ()),
            0.0 if leg.tow is None else leg.tow.end_s - leg.tow.start_s,
            used_kg * s_per_kg,
            after.removal_kg * s_per_kg,
        )
    return found


def section(instance: Instance, plan: Plan, drawn: tuple[DrawnArc, ...]) -> str:
    """The section; empty where no chaser has low thrust.

    ``drawn`` says how high drift orbits are.
    """
    if not instance.has_low_thrust:
        return ""
    heights = {arc.leg: float(arc.altitudes_m[0]) for arc in drawn if arc.phase == "drift"}
    chasers, legs = [], []
    for flown in routes_of(instance, plan):
        if flown.chaser.thrust_n is not None:
            times = thrust_times(instance, flown)
            sums = zip(NO_THRUST, *times.values(), strict=True)
            chasers.append((flown, ThrustTimes(*map(math.fsum, sums))))
            legs += [(at, flown.chaser.name, leg, times[at]) for at, leg in flown.legs]

    def _flies_s(flown: Flown) -> float:
        return flown.end_s - (flown.legs[0][1].ready_s if flown.legs else 0.0)

    def _of_arcs(leg: Leg, tell: Callable[[LowThrustArc, LowThrustArc], str]) -> str:
        arcs = leg.manoeuvres or ()
        return tell(*arcs) if len(arcs) == 2 else NOTHING

    def _arc(leg: Leg, which: int) -> str:
        return _of_arcs(leg, lambda *arcs: _days(arcs[which].end_s - arcs[which].start_s))

    def _height(at: int, leg: Leg) -> str:
        height_m = heights.get(at)
        shown = NOTHING if height_m is None else fixed(height_m / KM_M, 1)
        return _of_arcs(leg, lambda first, second: shown)

    by_chaser: list[Column] = [
        ("chaser", "", lambda flown, _: f"<b>{escape(flown.chaser.name)}</b>"),
        ("thrust N", "n", lambda flown, _: number(flown.chaser.thrust_n, 3)),
        ("arcs d", "n", lambda _, times: _days(times.arcs_s)),
        ("thrust on d", "n", lambda _, times: _days(times.leg_on_s)),
        ("tows d", "n", lambda _, times: _days(times.tow_s)),
        ("tows, thrust on d", "n", lambda _, times: _days(times.tow_on_s)),
        ("flies d", "n", lambda flown, _: _days(_flies_s(flown))),
    ]
    by_leg: list[Column] = [
        ("leg", "n", lambda at, name, leg, times: str(at)),
        ("chaser", "", lambda at, name, leg, times: escape(name)),
        ("from → to", "", lambda at, name, leg, times: route_cell(leg.origin, leg.destination)),
        ("first arc d", "n", lambda at, name, leg, times: _arc(leg, 0)),
        (
            "drift d",
            "n",
            lambda at, name, leg, times: _of_arcs(
                leg, lambda first, second: _days(second.start_s - first.end_s)
            ),
        ),
        ("at km", "n", lambda at, name, leg, times: _height(at, leg)),
        ("second arc d", "n", lambda at, name, leg, times: _arc(leg, 1)),
        (
            "windows ±°",
            "n",
            lambda at, name, leg, times: _of_arcs(leg, lambda first, _: number(first.window_deg)),
        ),
        (
            "thrust on d",
            "n",
            lambda at, name, leg, times: _of_arcs(leg, lambda *arcs: _days(times.leg_on_s)),
        ),
        ("tow d", "n", lambda at, name, leg, times: _days(times.tow_s) if leg.tow else NOTHING),
        (
            "tow, thrust on d",
            "n",
            lambda at, name, leg, times: _days(times.tow_on_s) if leg.tow else NOTHING,
        ),
    ]
    return (
        f"<section>\n<h2>Thrust</h2>\n<p>{NOTE}</p>\n"
        f"{table_of('Times of thrust of chasers', by_chaser, chasers)}\n<h3>By leg</h3>\n"
        + table_of("Times of thrust of legs", by_leg, legs, lambda at, *_: f'data-of="{at}"')
        + "\n</section>"
    )


def _days(duration_s: float) -> str:
    return fixed(duration_s / DAY_S, 1)
