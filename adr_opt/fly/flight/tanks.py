"""ΔV taken from each tank by the flown legs of a plan, and by those of a refined one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ...common.errors import InputError
from ...plan.cargo import followed, tank_worths
from ...plan.plan import Leg, Plan
from ...plan.refined_plan import RefinedLeg, RefinedPlan
from ...plan.routes import Flown, by_tank, refused_chaser, routes_of, several
from ...problem.chasers import Chaser
from ...problem.instance import Instance
from .flights import TankFlight


def burnt_m_s(leg: Leg) -> float:
    """ΔV of a leg between circles, tows excluded: on a grid of times, the sum of its burns.

    What is set aside for eccentricity is left in; burns of one instant are one vector, unless the
    price is that of free burns, and less than the plan's.
    """
    aside = leg.eccentricity_delta_v_m_s
    if leg.traits.on_time_grid:
        return leg.burns_delta_v_m_s + aside
    return leg.delta_v_m_s - (leg.at_once_m_s if aside >= 0.0 else 0.0)


def plan_tanks(
    instance: Instance, plan: Plan, flown: Mapping[int, float | None]
) -> tuple[TankFlight, ...]:
    """Tanks of a plan by chaser; a tank ends with the leg to a station.

    Parameters
    ----------
    instance : Instance
    plan : Plan
    flown : mapping
        What each leg takes, by its number from 1, tows apart; None if that is unknown [m/s].
    """
    return tuple(
        tank for route in routes_of(instance, plan) for tank in _of_route(instance, route, flown)
    )


def _of_route(
    instance: Instance, route: Flown, flown: Mapping[int, float | None]
) -> Iterator[TankFlight]:
    chaser = route.chaser
    extras = [
        None if (taken := flown[number]) is None else taken - leg.delta_v_m_s
        for number, leg in route.legs
    ]
    spent = [
        (leg.destination, leg.delta_v_m_s + (extra or 0.0))
        for (_, leg), extra in zip(route.legs, extras, strict=True)
    ]
    worths = iter(tank_worths(instance, chaser, spent, vented_kg=route.vented_kg))
    tank, first, planned, extra, known = 1, 0, 0.0, 0.0, True
    for (number, leg), more in zip(route.legs, extras, strict=True):
        first = first or number
        planned += leg.spent_m_s
        known, extra = known and more is not None, extra + (more or 0.0)
        if leg.destination in instance.station_names or number == route.legs[-1][0]:
            yield TankFlight(
                tank=tank,
                first_leg=first,
                last_leg=number,
                budget_m_s=next(worths),
                planned_delta_v_m_s=planned,
                flown_delta_v_m_s=planned + extra if known else None,
                chaser=chaser.name if several(instance) else None,
            )
            tank, first, planned, extra, known = tank + 1, 0, 0.0, 0.0, True


@dataclass(frozen=True)
class TankLegs:
    """Refined legs flown from one tank.

    Attributes
    ----------
    chaser : Chaser
    tank : int
        Number of the tank, from 1, of its chaser.
    legs : list of RefinedLeg
    budget_m_s : float
        What it is worth over these legs as they are flown.
    full_m_s : float
        What it was worth when it was filled, with all that was aboard then.
    """

    chaser: Chaser
    tank: int
    legs: list[RefinedLeg]
    budget_m_s: float
    full_m_s: float


def refined_routes(
    instance: Instance, refined: RefinedPlan
) -> list[tuple[Chaser, list[RefinedLeg]]]:
    """Legs by chaser, in order, without chasers that fly none.

    Raises
    ------
    InputError
        There are several chasers, and a leg names none, or an unknown one.
    """
    if not several(instance):
        return [(instance.chasers[0], list(refined.legs))] if refined.legs else []
    chasers = {chaser.name: chaser for chaser in instance.chasers}
    found: dict[str, list[RefinedLeg]] = {}
    for leg in refined.legs:
        if leg.chaser is None:
            raise InputError(
                f"leg {leg.leg} names no chaser, and {instance.name!r} has {len(chasers)}; refine "
                "the plan again"
            )
        if leg.chaser not in chasers:
            raise InputError(
                f"leg {leg.leg}: chaser = {leg.chaser!r}: "
                + refused_chaser(instance, leg.chaser, "")
            )
        found.setdefault(leg.chaser, []).append(leg)
    return [(chasers[name], legs) for name, legs in found.items()]


def legs_by_tank(instance: Instance, refined: RefinedPlan) -> list[TankLegs]:
    """Legs by tank for each chaser; a tank ends with the leg to a station."""
    found = []
    for chaser, legs in refined_routes(instance, refined):
        # A launch is no refined leg, but the tank is filled with the kit aboard that stays there.
        launch = [(legs[0].origin, 0.0)] if chaser.is_launched else []
        flown = [
            *launch,
            *((leg.destination, leg.flown_delta_v_m_s + leg.holding_m_s) for leg in legs),
        ]
        towing = _towing_m_s(legs)
        first, *others = (leg.vented_kg or 0.0 for leg in legs)
        vented = [first, *(0.0 for _ in launch), *others]
        worths = tank_worths(instance, chaser, flown, towing, vented)
        stages = followed(instance, chaser, flown, towing, vented)
        filled, after = 0, len(launch)
        for number, of_tank in enumerate(by_tank(legs, instance.station_names)):
            full_m_s = stages[filled].left_m_s
            found.append(TankLegs(chaser, number + 1, of_tank, worths[number], full_m_s))
            filled = after = after + len(of_tank)
    return found


def _towing_m_s(legs: list[RefinedLeg]) -> dict[str, float]:
    """ΔV of tows by spirals or to a perigee, by name of the object; others are as planned [m/s]."""
    ends = [(leg.destination, leg.tow) for leg in legs]
    ends += [(leg.origin, leg.tow_before) for leg in legs if leg.after_launch]
    return {
        name: tow.delta_v_m_s
        for name, tow in ends
        if tow is not None and tow.planned_delta_v_m_s is not None
    }


def tanks_of(instance: Instance, refined: RefinedPlan) -> tuple[TankFlight, ...]:
    """Tanks of a refined plan, with planned and flown ΔV of each, that of holding included."""
    return tuple(
        TankFlight(
            tank=one.tank,
            first_leg=one.legs[0].leg,
            last_leg=one.legs[-1].leg,
            budget_m_s=one.budget_m_s,
            planned_delta_v_m_s=math.fsum(
                leg.planned_delta_v_m_s + leg.planned_removal_m_s for leg in one.legs
            ),
            flown_delta_v_m_s=math.fsum(
                part
                for leg in one.legs
                for part in (leg.spent_m_s, leg.removal_m_s, leg.holding_m_s)
            ),
            chaser=one.chaser.name if several(instance) else None,
        )
        for one in legs_by_tank(instance, refined)
    )
