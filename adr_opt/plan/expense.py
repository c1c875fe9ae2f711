"""Cost of using chasers: by their mass at the start, and by their days."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from ..problem.chasers import Chaser, TankByMass
from ..problem.drives import drive_of
from ..problem.instance import Instance
from .cargo import kits_of
from .plan import Leg, Route, cost_of
from .tows import removals_by_name


def carried_kg(
    instance: Instance, chaser: Chaser, legs: Sequence[tuple[str, float]]
) -> float | None:
    """Kits and least propellant that a route carries at the start; None if masses are unknown.

    Counted backwards from the end of the first tank, where nothing but kits is left aboard that
    are left behind later: the mass before a leg is the one after it times exp(ΔV / g₀ Isp), and a
    kit comes on top where it is left. Before a tow it is what both masses need, less the object's.

    Parameters
    ----------
    instance : Instance
    chaser : Chaser
    legs : sequence of (str, float)
        Destination and ΔV [m/s] of each.
    """
    tank = chaser.usable
    if not isinstance(tank, TankByMass):
        return None
    stops = [at for at, (body, _) in enumerate(legs) if body in instance.station_names]
    first = legs[: stops[0] + 1] if stops else legs
    takers = {target.name for target in instance.targets if target.service.takes_kit}
    removals = removals_by_name(instance, drive_of(chaser, instance.targets))
    every = kits_of(instance, (body for body, _ in legs))
    later = every - kits_of(instance, (body for body, _ in first))
    mass = tank.dry_mass_kg + later * chaser.kit_mass_kg
    for body, delta_v in reversed(first):
        if body in takers:
            mass += chaser.kit_mass_kg
        elif body in removals:
            mass = removals[body].needed_kg(mass, tank.exhaust_m_s)
        mass *= math.exp(delta_v / tank.exhaust_m_s)
    return mass - tank.dry_mass_kg


def expense_of(instance: Instance, chaser: Chaser, legs: Sequence[tuple[str, float]]) -> float:
    """Cost of a chaser that flies some legs; zero for none."""
    if not legs:
        return 0.0
    return chaser.priced.of(carried_kg(instance, chaser, legs) or 0.0)


def cost_of_routes(instance: Instance, routes: Iterable[Route]) -> float:
    """Total cost of routes, as the instance counts it [m/s, s, or the unit of expenses]."""
    routes = tuple(routes)
    if instance.objective.cost != "expense":
        return cost_of(instance.objective, legs_of(routes)) + time_paid_m_s(instance, routes)
    numbers = _numbers(instance, routes)
    return instance.objective.together(
        expense_of(
            instance,
            instance.chasers[numbers[route.chaser]],
            [(leg.destination, leg.delta_v_m_s) for leg in route.legs],
        )
        for route in routes
    )


def time_paid_m_s(instance: Instance, routes: Sequence[Route]) -> float:
    """Cost of the days of routes, from each chaser's availability to the end of its last stay.

    Where missions are separated, from the launch, whose time is a choice.
    """
    numbers, since_s = _numbers(instance, routes), instance.available_s
    chosen = instance.mission.mission_separation_s is not None
    flown_s = [
        route.legs[-1].done_s
        - (route.legs[0].departure_s if chosen else since_s[numbers[route.chaser]][0])
        for route in routes
        if route.legs
    ]
    return instance.time_m_s_per_s * math.fsum(flown_s)


def _numbers(instance: Instance, routes: Iterable[Route]) -> dict[str, int]:
    """Numbers of the chasers of some routes, by name."""
    if len(instance.chasers) == 1:  # a route of an only chaser is its own, whatever it is called
        return dict.fromkeys((route.chaser for route in routes), 0)
    return {chaser.name: number for number, chaser in enumerate(instance.chasers)}


def legs_of(routes: Iterable[Route]) -> tuple[Leg, ...]:
    """Legs of all routes, one route after another."""
    return tuple(leg for route in routes for leg in route.legs)
