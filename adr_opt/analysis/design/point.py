"""A design with its plan: what it avoids at least, what it avoids, and what none can exceed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...common.card import Shown
from ...common.tolerance import meets
from ...plan.plan import Plan
from ...problem.instance import Instance
from .designs import Design


@dataclass(frozen=True, repr=False)
class DesignPoint(Shown):
    """Results for one design.

    Worths are in fragment-years, or in prizes of the instance where no worths of sets are given.

    Attributes
    ----------
    design : Design
    instance : Instance
        On which the plan was made, and can be checked.
    plan : Plan or None
        None where none was found, or none is within the budget.
    floor : float
        Sum of the floors of the plan's targets, as it was planned; 0 without a plan.
    worth : float
        What removing them as a set avoids: pairs within the set count once.
    bound : float
        No plan of the design avoids more.
    euros : float
        Of the plan.
    launches : int
        Chasers that it uses.
    removals : int
        Its targets.
    runtime_s, cpu_s : float
        Of planning and bounding.
    """

    design: Design
    instance: Instance
    plan: Plan | None
    floor: float
    worth: float
    bound: float
    euros: float
    launches: int
    removals: int
    runtime_s: float = 0.0
    cpu_s: float = 0.0

    @property
    def gap(self) -> float:
        """(bound − worth) / bound; 0 where nothing can be avoided, +inf without a bound."""
        if not math.isfinite(self.bound):
            return math.inf
        return (self.bound - self.worth) / self.bound if self.bound > 0.0 else 0.0

    @property
    def proven(self) -> bool:
        """Whether no plan avoids more."""
        return meets(self.worth, self.bound)

    @property
    def per_million(self) -> float:
        """What is avoided for each million euros; NaN for nothing spent."""
        return self.worth / self.euros * 1e6 if self.euros > 0.0 else math.nan

    def to_dict(self) -> dict[str, Any]:
        """The point as JSON data, without its plan's legs."""
        return {
            "design": self.design.to_dict(),
            "floor": self.floor,
            "worth": self.worth,
            "bound": self.bound,
            "gap": self.gap,
            "euros": self.euros,
            "launches_used": self.launches,
            "removals": self.removals,
            "routes": {}
            if self.plan is None
            else {chaser: list(order) for chaser, order in self.plan.orders.items()},
            "runtime_s": self.runtime_s,
            "cpu_s": self.cpu_s,
        }
