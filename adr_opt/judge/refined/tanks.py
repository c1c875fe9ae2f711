"""Masses and tanks of a refined plan, followed with the ΔV of its legs as flown."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from ...plan.plan import Leg, Plan
from ...plan.refined_plan import RefinedLeg
from ...problem.chasers import Chaser
from ...problem.instance import Instance
from ..check.shared import Drawn
from ..check.tank import TankLevel
from ..check.violation import DELTA_V_TOLERANCE_M_S, Violation


class Masses(NamedTuple):
    """Masses of a chaser on a leg as planned [kg]; NaN where the tank is not one by mass.

    Attributes
    ----------
    leaving, tugging : float
        At the departure, and after the service, when a tow begins: without the object.
    """

    leaving: float
    tugging: float


def chasers_of(instance: Instance, plan: Plan) -> Iterator[tuple[Chaser, list[tuple[int, Leg]]]]:
    """Legs of each chaser, by number."""
    numbered = list(enumerate(plan.legs, start=1))
    if len(instance.chasers) == 1:
        yield instance.chasers[0], numbered
        return
    known, at = {chaser.name: chaser for chaser in instance.chasers}, 0
    for route in plan.routes:
        if route.chaser in known:
            yield known[route.chaser], numbered[at : at + len(route.legs)]
        at += len(route.legs)


def planned_masses(instance: Instance, plan: Plan) -> dict[int, Masses]:
    """Planned masses on each leg, by its number: those for which low thrust is refined."""
    found, stations = {}, set(instance.station_names)
    kits = {target.name for target in instance.targets if target.removal == "kit"}
    objects = {target.name: target.mass_kg or 0.0 for target in instance.targets}
    for chaser, legs in chasers_of(instance, plan):
        tank = TankLevel(chaser, len({leg.destination for _, leg in legs} & kits))
        for number, leg in legs:
            tank.vent(leg.vented_kg or 0.0)
            leaving = math.nan if tank.mass_kg is None else tank.mass_kg
            tank.burn(leg.delta_v_m_s)
            found[number] = Masses(leaving, math.nan if tank.mass_kg is None else tank.mass_kg)
            if leg.destination in stations:
                tank.fill()
            elif leg.destination in kits:
                tank.leave_kit()
            elif leg.tow is not None and tank.mass_kg is not None:
                tank.tow(leg.tow.delta_v_m_s, objects[leg.destination], leg.tow.back_m_s)
    return found


def check_tanks(
    instance: Instance, plan: Plan, refined: Mapping[int, RefinedLeg]
) -> Iterator[Violation]:
    """Check that each tank suffices for its legs: burns, arcs, tows and holding.

    A leg that is not refined takes what the plan says; that it is missing is said elsewhere.

    Parameters
    ----------
    refined : mapping of int to RefinedLeg
        By the number of the leg.
    """
    drawn, stations = Drawn(instance), set(instance.station_names)
    kits = {target.name for target in instance.targets if target.removal == "kit"}
    objects = {target.name: target.mass_kg or 0.0 for target in instance.targets}
    for chaser, legs in chasers_of(instance, plan):
        tank = TankLevel(chaser, len({leg.destination for _, leg in legs} & kits))
        for at, (number, leg) in enumerate(legs):
            flown = refined.get(number)
            spent = leg.delta_v_m_s if flown is None else flown.spent_m_s + flown.holding_m_s
            tank.vent(leg.vented_kg or 0.0)
            tank.burn(spent)
            lacking = -tank.left_m_s
            if leg.destination in stations:
                before = tank.mass_kg
                tank.fill()
                drawn.fill(leg.destination, before, tank.mass_kg)
            elif leg.destination in kits:
                tank.leave_kit()
            elif leg.tow is not None and tank.mass_kg is not None:
                # After a launch nothing is refined but the tow, which stands with the leg after it.
                later = refined.get(legs[at + 1][0]) if at + 1 < len(legs) else None
                made = None if later is None else later.tow_before
                made = made if flown is None else flown.tow
                towing = leg.tow if made is None else made
                tank.tow(towing.delta_v_m_s, objects[leg.destination], towing.back_m_s)
                lacking = max(lacking, -tank.left_m_s)
            if lacking > DELTA_V_TOLERANCE_M_S:
                yield Violation(
                    number,
                    "delta-v",
                    f"its tank is {lacking:.6g} m/s short for this leg and those before it, as "
                    "they are flown",
                )
                break
    yield from drawn.violations()
