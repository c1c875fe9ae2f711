"""Prices of launches, kits and kilograms [euros], costs of plans, and limits by a budget.

A budget limits launches, and targets of plans with more launches.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import NamedTuple

from ...common.errors import InputError
from ...common.records import LARGEST_EXPENSE
from ...plan.cargo import kits_of
from ...plan.expense import expense_of
from ...plan.plan import Plan
from ...plan.routes import routes_of
from ...problem.chasers import Chaser, Expense, TankByMass
from ...problem.instance import Instance
from .rating import Rating

Legs = Sequence[tuple[str, float]]
"""Destination and ΔV [m/s] of each leg of a route."""


@dataclass(frozen=True)
class CampaignPrices:
    """Prices of a campaign's launches, kits and mass; the only defaults are the instance's.

    Where any is given, the others count 0, and the ``expense`` that chasers of the instance state
    does not count. Where none is, that expense counts.

    Attributes
    ----------
    launch : float or None
        Of each chaser that is used [euros].
    kit : float or None
        Of each kit left with a target [euros].
    kilogram : float or None
        Of each kilogram at launch: dry mass, kits and least propellant [euros/kg].
    """

    launch: float | None = None
    kit: float | None = None
    kilogram: float | None = None

    def __post_init__(self) -> None:
        for name in ("launch", "kit", "kilogram"):
            price = getattr(self, name)
            if price is not None and not 0.0 <= price <= LARGEST_EXPENSE:
                raise InputError(
                    f"price of a {name}: {price:g} euros; give a number from 0 to "
                    f"{LARGEST_EXPENSE:g}"
                )

    @property
    def are_given(self) -> bool:
        """Whether any price is given."""
        return any(price is not None for price in (self.launch, self.kit, self.kilogram))

    @property
    def per_kit(self) -> float:
        """Price of a kit; 0 where none is given [euros]."""
        return self.kit or 0.0

    def __str__(self) -> str:
        if not self.are_given:
            return "expense of the chasers"
        return ", ".join(
            f"{name} {getattr(self, name):.12g}"
            for name in ("launch", "kit", "kilogram")
            if getattr(self, name) is not None
        )

    def applied(self, instance: Instance) -> Instance:
        """The instance with these prices, those of kits excluded, as its cost.

        Raises
        ------
        InputError
            There is no price at all, or one of a kilogram and a tank without masses.
        """
        if not self.are_given:
            if all(chaser.expense is None for chaser in instance.chasers):
                raise InputError(
                    f"the costs of the designs of {instance.name!r} are unknown; give "
                    "--launch-cost, --kit-cost or --kg-cost, or an expense of its chasers"
                )
            return _minimising(instance)
        chasers = tuple(
            chaser.replace(expense=self._expense(chaser)) for chaser in instance.chasers
        )
        return _minimising(instance.replace(chasers=chasers))

    def _expense(self, chaser: Chaser) -> Expense:
        fixed, per_kg = self.launch or 0.0, self.kilogram or 0.0
        if per_kg > 0.0:
            if not isinstance(chaser.tank, TankByMass):
                raise InputError(
                    f"--kg-cost: the tank of {chaser.name!r} is given in ΔV, without masses; give "
                    "its dry_mass_kg, propellant_kg and isp_s, or leave --kg-cost out"
                )
            fixed += per_kg * chaser.tank.dry_mass_kg
        if fixed > LARGEST_EXPENSE:
            raise InputError(
                f"a launch of {chaser.name!r} costs {fixed:g} euros, more than "
                f"{LARGEST_EXPENSE:g}; lower --launch-cost or --kg-cost"
            )
        return Expense(fixed=fixed, per_kg=per_kg)

    def of_route(self, instance: Instance, chaser: Chaser, legs: Legs) -> float:
        """Cost of a chaser that flies some legs of an instance with prices applied [euros]."""
        kits = kits_of(instance, (body for body, _ in legs))
        return expense_of(instance, chaser, legs) + self.per_kit * kits

    def of_plan(self, instance: Instance, plan: Plan) -> float:
        """Cost of a plan, on an instance with these prices applied [euros]."""
        return math.fsum(
            self.of_route(instance, flown.chaser, flown.spent)
            for flown in routes_of(instance, plan)
        )


def _minimising(instance: Instance) -> Instance:
    """The instance with the expense as its cost, without a price of days."""
    objective = instance.objective.replace(cost="expense", time_m_s_per_day=None)
    return instance.replace(objective=objective)


ROUNDED = 1e-6
"""Tolerance for rounding in a number of targets."""


class Spending(NamedTuple):
    """An instance restricted by a budget.

    Attributes
    ----------
    planned : Instance
        Without chasers that no plan within the budget can use.
    bounded : Instance
        With as many chasers or fewer: those of which a bound is worked out.
    beyond : float
        No plan within the budget that uses more of them avoids more than this.
    """

    planned: Instance
    bounded: Instance
    beyond: float


def spending_of(
    instance: Instance, prices: CampaignPrices, rating: Rating, budget: float
) -> Spending | None:
    """The restrictions by a budget; None if it allows no launch.

    A chaser costs at least its fixed price. Where all are alike but for when they are available,
    those available first can fly whatever as many others can, as they may wait; so the others are
    left out. Each target costs at least its kit, so that plans with many launches have few targets:
    those are bounded by the largest worths alone, and the other plans by a proof.

    Parameters
    ----------
    instance : Instance
        With the prices applied.
    prices : CampaignPrices
    rating : Rating
    budget : float
        [euros].
    """
    chasers = instance.chasers
    spent = list(accumulate(sorted(chaser.priced.fixed for chaser in chasers)))
    count = sum(total <= budget for total in spent)
    if count == 0:
        return None
    if not _may_wait(instance) or not _alike(chasers):
        return Spending(instance, instance, 0.0)
    worths = sorted(rating.alone_of(instance), reverse=True)
    each = min(_least_of_target(instance, chaser, prices) for chaser in chasers)

    def most(targets: float) -> float:
        whole = len(worths) if targets > len(worths) else int(targets + ROUNDED)
        return math.fsum(worths[:whole])

    # Plans with exactly at + 1 launches, by their kits; plans with at most as many, by kits aboard.
    beyond = [most((budget - spent[at]) / each if each > 0.0 else math.inf) for at in range(count)]
    within = [most(_most_targets(chasers[0]) * (at + 1)) for at in range(count)]
    proven = min(
        range(count, 0, -1), key=lambda number: max(within[number - 1], *beyond[number:], 0.0)
    )
    return Spending(
        _first(instance, count), _first(instance, proven), max(beyond[proven:], default=0.0)
    )


def _may_wait(instance: Instance) -> bool:
    """Whether a chaser that is available earlier can fly all that it could later."""
    return instance.transfer.max_leg_s is None or instance.mission.mission_separation_s is not None


def _alike(chasers: Sequence[Chaser]) -> bool:
    """Whether chasers differ only in their names and in when they become available."""
    kinds = {
        chaser.replace(name="chaser", available_s=(0.0, chaser.available_s[1]))
        for chaser in chasers
    }
    return len(kinds) == 1


def _first(instance: Instance, count: int) -> Instance:
    """The instance with the chasers that are available first."""
    if count == len(instance.chasers):
        return instance
    available = instance.available_s
    first = sorted(range(len(instance.chasers)), key=lambda at: (available[at][0], at))[:count]
    return instance.replace(chasers=tuple(instance.chasers[at] for at in sorted(first)))


def _least_of_target(instance: Instance, chaser: Chaser, prices: CampaignPrices) -> float:
    """Least cost of one more target [euros]."""
    if not all(target.service.takes_kit for target in instance.targets):
        return 0.0
    return prices.per_kit + chaser.priced.per_kg * chaser.kit_mass_kg


def _most_targets(chaser: Chaser) -> float:
    """Largest number of targets that a chaser's limits allow, if all take kits."""
    limits = [limit for limit in (chaser.kits, chaser.max_targets) if limit is not None]
    return min(limits, default=math.inf)
