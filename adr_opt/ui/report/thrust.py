"""The section on arcs of low thrust: how long each leg thrusts, and each chaser in all."""

from __future__ import annotations

import math
from typing import NamedTuple

from ...common.constants import DAY_S
from ...plan.plan import Leg, Plan
from ...plan.routes import Flown, routes_of
from ...problem.instance import Instance
from ..plot.chart import KM_M
from ..plot.strands import DrawnArc
from .tables import route_cell, row, table
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
            chasers.append(_of_chaser(flown, times))
            legs += [_of_leg(flown, at, leg, times[at], heights.get(at)) for at, leg in flown.legs]
    by_chaser = (
        ("chaser", ""),
        ("thrust N", "n"),
        ("arcs d", "n"),
        ("thrust on d", "n"),
        ("tows d", "n"),
        ("tows, thrust on d", "n"),
        ("flies d", "n"),
    )
    by_leg = (
        ("leg", "n"),
        ("chaser", ""),
        ("from → to", ""),
        ("first arc d", "n"),
        ("drift d", "n"),
        ("at km", "n"),
        ("second arc d", "n"),
        ("windows ±°", "n"),
        ("thrust on d", "n"),
        ("tow d", "n"),
        ("tow, thrust on d", "n"),
    )
    return (
        f"<section>\n<h2>Thrust</h2>\n<p>{NOTE}</p>\n"
        f"{table('Times of thrust of chasers', by_chaser, chasers)}\n<h3>By leg</h3>\n"
        f"{table('Times of thrust of legs', by_leg, legs)}\n</section>"
    )


def _of_chaser(flown: Flown, times: dict[int, ThrustTimes]) -> str:
    arcs_s, tows_s, legs_on_s, tows_on_s = (
        math.fsum(column) for column in zip(NO_THRUST, *times.values(), strict=True)
    )
    since_s = flown.legs[0][1].ready_s if flown.legs else 0.0
    return row(
        [
            ("", f"<b>{escape(flown.chaser.name)}</b>"),
            ("n", number(flown.chaser.thrust_n or 0.0, 3)),
            *(("n", _days(each)) for each in (arcs_s, legs_on_s, tows_s, tows_on_s)),
            ("n", _days(flown.end_s - since_s)),
        ]
    )


def _of_leg(flown: Flown, at: int, leg: Leg, times: ThrustTimes, height_m: float | None) -> str:
    arcs = [NOTHING] * 4
    windows = thrust_on = NOTHING
    if leg.manoeuvres is not None and len(leg.manoeuvres) == 2:
        first, second = leg.manoeuvres
        arcs = [
            _days(first.end_s - first.start_s),
            _days(second.start_s - first.end_s),
            NOTHING if height_m is None else fixed(height_m / KM_M, 1),
            _days(second.end_s - second.start_s),
        ]
        windows, thrust_on = number(first.window_deg), _days(times.leg_on_s)
    towed = [NOTHING] * 2
    if leg.tow is not None:
        towed = [_days(times.tow_s), _days(times.tow_on_s)]
    return row(
        [
            ("n", str(at)),
            ("", escape(flown.chaser.name)),
            route_cell(leg.origin, leg.destination),
            *(("n", text) for text in (*arcs, windows, thrust_on, *towed)),
        ],
        f'data-of="{at}"',
    )


def _days(duration_s: float) -> str:
    return fixed(duration_s / DAY_S, 1)
