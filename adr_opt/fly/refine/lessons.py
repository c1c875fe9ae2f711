"""Corrections of the model learned from refined legs and spirals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from statistics import linear_regression
from typing import NamedTuple

from ...legs.corrections import Corrections, Key, Span
from ...plan.leg_kinds import leg_kinds
from ...plan.plan import Leg, Plan
from ...plan.refined_plan import RefinedLeg, RefinedPlan, RefinedTow
from ...plan.routes import routes_of
from ...problem.instance import Instance
from .all_legs import INTERRUPTED
from .troubles import strayed


def spirals_excess_m_s(leg: RefinedLeg, masses_kg: Mapping[str, float]) -> float:
    """Extra ΔV of a leg that would account for the excess propellant of its spirals [m/s].

    A spiral is flown with the mass of chaser and object, m + D. With the planned ΔV x the chaser is
    left with (m + D) A − D, A = exp(−x / g₀ Isp), and in flight with less. A leg before the spiral
    is charged with what leaves as little after the planned one; a leg that follows a launch with
    the difference after it.

    Parameters
    ----------
    leg : RefinedLeg
    masses_kg : mapping of name to float
        Of objects [kg].

    Returns
    -------
    float
        Not positive where spirals took less than planned [m/s].
    """
    found = 0.0
    if leg.tow is not None and leg.tow.thrust is not None:
        object_kg = masses_kg[leg.destination]
        thrust = leg.tow.thrust
        end_kg = thrust.mass_kg - thrust.propellant_kg
        wanted = end_kg / _kept(leg.tow) - object_kg
        found += thrust.exhaust_m_s * math.log((thrust.mass_kg - object_kg) / wanted)
    before = leg.tow_before if leg.after_launch else None
    if before is not None and before.thrust is not None:
        object_kg = masses_kg[leg.origin]
        thrust = before.thrust
        planned = thrust.mass_kg * _kept(before) - object_kg
        flown = thrust.mass_kg - thrust.propellant_kg - object_kg
        found += thrust.exhaust_m_s * math.log(planned / flown)
    return found


def _kept(tow: RefinedTow) -> float:
    """Share of the mass that the planned spiral leaves."""
    assert tow.thrust is not None
    return math.exp(-tow.planned_m_s / tow.thrust.exhaust_m_s)


class Unsafe(NamedTuple):
    """A time at which a refined plan must not be flown as it is.

    Attributes
    ----------
    leg : int
        By its number in the plan.
    time_s : float
        [s].
    said : str
        Why, as a part of a sentence.
    """

    leg: int
    time_s: float
    said: str


Cost = tuple[float, float]
"""Planned and flown ΔV [m/s]."""

LEAST_FACTOR = 0.1
"""Lower limit of cost factors, so that no transfer becomes free."""

MOST_OF_A_LINE = 4
"""Number of drift legs from which a line is fitted to their costs; below it, the mean excess."""


LONGER = 1.5
"""Factor on the time of a spiral that was too short."""


class Lessons:
    """Costs of the legs refined so far, against their plans.

    All connections of a kind are corrected by what its legs cost in the mean. For short ones that
    is a factor. For those that drift it is an addition as well: the model does not know their
    phase, and to close that within a day or two costs what it costs, however small the rest is.
    Those of a pair that has been flown cost what the dearest of its legs did, against the mean;
    they are left out if no trajectory was found, of low thrust those within the times of the leg:
    it lacked time. So a plan costs from then on at least what its legs were flown with.

    A spiral takes more than planned, and its leg is charged with it. One that was not found, or
    left the orbit eccentric, gets more time. Holding beside bodies with ephemerides is charged to
    its leg, too.

    Parameters
    ----------
    instance : Instance
    spend_savings : bool
        Whether connections may become cheaper than the model says. Where flown legs save ΔV they
        do so by burns that the model does not know; a plan that counts on it may be one that
        ``check`` refuses.
    """

    def __init__(self, instance: Instance, spend_savings: bool = False) -> None:
        self._instance = instance
        self._masses = {target.name: float(target.mass_kg or 0.0) for target in instance.targets}
        self._savings = spend_savings
        self._legs: dict[Key, set[Cost]] = {}
        self._barred: dict[Key, tuple[Span, ...]] = {}
        self._stays: dict[str, float] = {}

    @staticmethod
    def _key(leg: Leg | RefinedLeg) -> Key:
        return leg.origin, leg.destination, leg.kind

    def learn(self, plan: Plan, refined: RefinedPlan) -> None:
        """Record the refined costs of a plan's legs."""
        for leg in refined.legs:
            flown = leg.flown_delta_v_m_s + leg.holding_m_s
            flown += spirals_excess_m_s(leg, self._masses)
            costs = leg.planned_delta_v_m_s, flown
            self._legs.setdefault(self._key(leg), set()).add(costs)
        hurried = {one.name for one in strayed(self._instance, refined)}
        for missing in refined.missing:
            if missing.tow is not None:
                hurried.add(missing.tow)
            elif missing.reason != INTERRUPTED:
                self._lose(plan.legs[missing.leg - 1])
        for one in plan.legs:
            if one.tow is not None and one.destination in hurried:
                had, takes = one.tow.end_s - one.end_s, one.tow.end_s - one.tow.start_s
                stay = LONGER * had - takes
                self._stays[one.destination] = max(stay, self._stays.get(one.destination, 0.0))

    def avoid(self, plan: Plan, conflicts: Iterable[Unsafe]) -> bool:
        """Bar connections that lead to conflicts; returns whether any was barred.

        In a transfer it is the connection: another phasing, or a later departure, is none. Beside a
        body it is whatever leaves for it later and arrives there before the conflict.
        """
        before = dict(self._barred)
        for one in conflicts:
            (route,) = (
                [leg for _, leg in flown.legs]
                for flown in routes_of(self._instance, plan)
                if one.leg in [number for number, _ in flown.legs]
            )
            begun = [leg for leg in route if leg.departure_s <= one.time_s]
            if begun:
                until_s = max(begun[-1].arrival_s, one.time_s)
                self._bar(begun[-1], until_s)
        return self._barred != before

    def _bar(self, leg: Leg, until_s: float) -> None:
        """Bar connections that leave no sooner than a leg and arrive by a time."""
        key, span = self._key(leg), (leg.departure_s, until_s)
        if span not in self._barred.get(key, ()):
            self._barred[key] = (*self._barred.get(key, ()), span)

    def _lose(self, leg: Leg) -> None:
        """Record that no trajectory was found for a leg."""
        key = self._key(leg)
        if leg.traits.has_arcs:
            self._bar(leg, leg.arrival_s)
        else:
            self._legs.setdefault(key, set()).add((leg.delta_v_m_s, math.inf))

    @property
    def corrections(self) -> Corrections:
        """Corrections derived from the recorded costs."""
        least = LEAST_FACTOR if self._savings else 1.0
        factors: dict[str, float] = {}
        additions: dict[str, float] = {}
        for kind in leg_kinds():
            own = [costs for key, costs in self._legs.items() if key[2] == kind.name]
            legs = [cost for costs in own for cost in costs]
            legs = sorted(cost for cost in legs if math.isfinite(cost[1]))
            if legs:
                factors[kind.name], additions[kind.name] = _line(
                    legs, least, drifts=kind.on_time_grid
                )
        means = Corrections({}, factors, additions)
        shares = {
            key: max(
                0.0 if self._savings else 1.0 / means.of_kind(key[2])[0],
                max(flown / means.corrected(*key, planned) for planned, flown in costs),
            )
            for key, costs in self._legs.items()
        }
        return Corrections(shares, factors, additions, dict(self._barred), dict(self._stays))


def _line(legs: list[Cost], least: float, *, drifts: bool) -> tuple[float, float]:
    """Factor, not below the least, and non-negative offset of the legs' mean cost."""
    planned, flown = zip(*legs, strict=True)
    factor = max(least, math.fsum(flown) / math.fsum(planned))
    if not drifts:
        return factor, 0.0
    line = linear_regression(planned, flown) if len(set(planned)) >= MOST_OF_A_LINE else None
    if line is not None and line.slope >= least and line.intercept >= 0.0:
        return line.slope, line.intercept
    excess = (math.fsum(flown) - math.fsum(planned)) / len(legs)
    return (1.0, excess) if excess > 0.0 else (factor, 0.0)
