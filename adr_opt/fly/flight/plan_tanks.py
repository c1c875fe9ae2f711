"""ΔV taken from each tank by the flown legs of a plan."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ...plan.cargo import tank_worths
from ...plan.plan import Leg, Plan
from ...plan.routes import Flown, routes_of, several
from ...problem.instance import Instance
from .result import TankFlight


def burnt_m_s(leg: Leg) -> float:
    """ΔV of a leg between circles, tows excluded: on a grid of times, the sum of its burns.

    What is set aside for eccentricity is left in.
    """
    if leg.traits.on_time_grid:
        return leg.burns_delta_v_m_s + leg.eccentricity_delta_v_m_s
    return leg.delta_v_m_s


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
