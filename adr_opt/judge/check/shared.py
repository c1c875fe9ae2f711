"""Checks of what chasers share: stations, launches, separated missions, expenses."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from ...common.constants import SLACK_S
from ...plan.plan import Leg, Plan
from ...problem.chasers import Chaser, TankByMass
from ...problem.instance import Instance
from .violation import Violation

PROPELLANT_TOLERANCE, PROPELLANT_TOLERANCE_KG = 1e-9, 1e-6
"""Tolerances on propellant drawn from a station beyond its limit: relative, and absolute [kg]."""


def launch_times(instance: Instance) -> dict[str, float]:
    """Earliest launch of each launched chaser, by name [s].

    Where the mission gives an interval, in the order of the file, each so long after the one before
    it; each on its own if it gives none.
    """
    apart = instance.mission.launch_separation_s
    found: dict[str, float] = {}
    for chaser in instance.chasers:
        if chaser.start == "anywhere":
            earliest = chaser.available_s[0]
            if found and apart is not None:
                earliest = max(earliest, list(found.values())[-1] + apart)
            found[chaser.name] = earliest
    return found


def check_apart(instance: Instance, plan: Plan) -> Iterator[Violation]:
    """Check that each mission is launched long enough after the end of all launched before it."""
    apart = instance.mission.mission_separation_s
    if apart is None:
        return
    flown = sorted(
        (route.legs[0].departure_s, max(over_s(leg) for leg in route.legs), route.chaser)
        for route in plan.routes
        if route.legs
    )
    for (_, over, before), (launch, _, after) in pairwise(flown):
        if launch < over + apart - SLACK_S:
            yield Violation(
                None,
                "separation",
                f"{after!r} is launched {launch - over!r} s after the mission of {before!r} has "
                f"ended, but must be at least {apart!r} s after it",
            )


def over_s(leg: Leg) -> float:
    """End of a leg, with service and tow [s]."""
    return leg.end_s if leg.tow is None else leg.tow.end_s


class Drawn:
    """Supplies drawn from stations by all chasers, accumulated leg by leg.

    Parameters
    ----------
    instance : Instance
    """

    def __init__(self, instance: Instance) -> None:
        self._stations = instance.stations
        self._fills = {station.name: 0 for station in instance.stations}
        self._kg = {station.name: [0.0] for station in instance.stations}

    def fill(self, station: str, before_kg: float | None, after_kg: float | None) -> None:
        """Record a refuelling, by the chaser's masses before and after."""
        self._fills[station] += 1
        if before_kg is not None and after_kg is not None:
            self._kg[station].append(after_kg - before_kg)

    def violations(self) -> Iterator[Violation]:
        """Stations that are overdrawn."""
        for station in self._stations:
            fills, limit = self._fills[station.name], station.max_refuellings
            if limit is not None and fills > limit:
                yield Violation(
                    None,
                    "refuellings",
                    f"{station.name!r} refuels {fills} times, but may do so {limit} times",
                )
            taken, most = math.fsum(self._kg[station.name]), station.max_propellant_kg
            if most is not None and taken > most * (1.0 + PROPELLANT_TOLERANCE) + (
                PROPELLANT_TOLERANCE_KG
            ):
                yield Violation(
                    None,
                    "propellant",
                    f"{station.name!r} gives out {taken!r} kg of propellant, but has {most!r} kg",
                )


def expense(instance: Instance, plan: Plan) -> float:
    """Total expense of a plan's chasers."""
    chasers = {chaser.name: chaser for chaser in instance.chasers}
    return math.fsum(
        _expense_of(instance, chasers.get(route.chaser, instance.chasers[0]), route.legs)
        for route in plan.routes
        if route.legs
    )


def _expense_of(instance: Instance, chaser: Chaser, legs: Sequence[Leg]) -> float:
    """Expense of one used chaser.

    Counted forwards: ``lifted`` kilograms at the start become one after the legs so far.
    Mass that is left behind, or still there when the first tank ends, had to be lifted with it.
    """
    stated, tank = chaser.expense, chaser.tank
    if stated is None:
        return 0.0
    if not isinstance(tank, TankByMass):
        return stated.fixed
    wanted = {target.name for target in instance.targets if target.removal == "kit"}
    aboard = len(wanted & {leg.destination for leg in legs})
    stations = {station.name for station in instance.stations}
    towed = {target.name: target.mass_kg or 0.0 for target in instance.targets}
    lifted, start_kg = 1.0, 0.0
    for leg in legs:
        lifted *= math.exp(leg.delta_v_m_s / (tank.isp_s * 9.80665))
        if leg.destination in wanted:
            wanted = wanted - {leg.destination}
            start_kg += lifted * chaser.kit_mass_kg
            aboard -= 1
        if leg.tow is not None:
            back_m_s, exhaust_m_s = leg.tow.back_m_s, tank.isp_s * 9.80665
            docked = math.exp((leg.tow.delta_v_m_s - back_m_s) / exhaust_m_s)
            start_kg += lifted * (docked - 1.0) * towed[leg.destination]
            lifted *= docked * math.exp(back_m_s / exhaust_m_s)
        if leg.destination in stations:
            break
    # What is kept for its own disposal is no part of what the mission takes.
    kept_m_s = chaser.end_of_life_m_s or 0.0
    empty_kg = tank.dry_mass_kg * math.exp(kept_m_s / (tank.isp_s * 9.80665))
    start_kg += lifted * (empty_kg + aboard * chaser.kit_mass_kg)
    carried = start_kg - empty_kg
    return stated.fixed + stated.per_kg * carried + stated.per_kg_squared * carried**2
