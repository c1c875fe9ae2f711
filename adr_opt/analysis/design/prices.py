"""Prices of launches, kits and kilograms in euros, and what a plan costs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ...common.errors import InputError
from ...common.records import LARGEST_EXPENSE
from ...plan.cargo import kits_of
from ...plan.expense import expense_of
from ...plan.plan import Plan
from ...plan.routes import routes_of
from ...problem.chasers import Chaser, Expense, TankByMass
from ...problem.instance import Instance

Legs = Sequence[tuple[str, float]]
"""Destination and ΔV [m/s] of each leg of a route."""


@dataclass(frozen=True)
class CampaignPrices:
    """Prices of what a campaign uses; there are no defaults but those of the instance.

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
        """Whether any is."""
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
        """The instance whose cost these prices are, kits aside, which depend on targets alone.

        Raises
        ------
        InputError
            There is no price at all, or one of a kilogram and a tank without masses.
        """
        if not self.are_given:
            if all(chaser.expense is None for chaser in instance.chasers):
                raise InputError(
                    f"what the designs of {instance.name!r} cost is not known; give --launch-cost, "
                    "--kit-cost or --kg-cost, or an expense of its chasers"
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
        """Euros of a chaser that flies some legs, on an instance with these prices applied."""
        kits = kits_of(instance, (body for body, _ in legs))
        return expense_of(instance, chaser, legs) + self.per_kit * kits

    def of_plan(self, instance: Instance, plan: Plan) -> float:
        """Euros of a plan, on an instance with these prices applied."""
        return math.fsum(
            self.of_route(instance, flown.chaser, flown.spent)
            for flown in routes_of(instance, plan)
        )


def _minimising(instance: Instance) -> Instance:
    """The instance with the expense as its cost, whose days are not priced then."""
    objective = instance.objective.replace(cost="expense", time_m_s_per_day=None)
    return instance.replace(objective=objective)
