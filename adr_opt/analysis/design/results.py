"""The results of a study of designs, as data.

A point is a design with its plan: what it avoids at least, what it avoids, and what none can
exceed. The Pareto front is of most avoided against least euros.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from ...common.card import Shown
from ...common.tolerance import meets
from ...plan.plan import Plan
from ...problem.instance import Instance
from ..trade.axes import KINDS, Axis
from .designs import Design
from .prices import CampaignPrices
from .rating import Rating


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
        """(bound − worth) / bound; 0 if nothing can be avoided, +inf without a bound."""
        if not math.isfinite(self.bound):
            return math.inf
        return (self.bound - self.worth) / self.bound if self.bound > 0.0 else 0.0

    @property
    def proven(self) -> bool:
        """Whether it is proven that no plan avoids more."""
        return meets(self.worth, self.bound)

    @property
    def per_million(self) -> float:
        """Worth avoided per million euros; NaN if nothing is spent."""
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


def pareto_front(points: Sequence[DesignPoint]) -> tuple[int, ...]:
    """Numbers of the points that no other dominates in worth and cost, cheapest first.

    Of points with equal worth and euros the first stays; those without a plan are left out.
    """
    there = [at for at, point in enumerate(points) if point.plan is not None]
    kept: list[int] = []
    for at in sorted(there, key=lambda at: (points[at].euros, -points[at].worth, at)):
        if not kept or points[at].worth > points[kept[-1]].worth:
            kept.append(at)
    return tuple(kept)


@dataclass(frozen=True, repr=False)
class DesignStudy(Shown):
    """Plans, bounds and worths of the designs of a campaign.

    Attributes
    ----------
    instance : Instance
        That is varied.
    axes : tuple of Axis
    points : tuple of DesignPoint
        In the order of the axes; those that are finished.
    wanted : int
        Number of designs.
    rating : Rating
        What sets of targets are worth.
    prices : CampaignPrices
    total : float or None
        Worth of all pairs of the catalogue.
    runtime_s : float
    """

    instance: Instance
    axes: tuple[Axis, ...]
    points: tuple[DesignPoint, ...]
    wanted: int
    rating: Rating
    prices: CampaignPrices
    total: float | None = None
    runtime_s: float = field(default=0.0, compare=False)

    @property
    def front(self) -> tuple[int, ...]:
        """Numbers of the points on the Pareto front, cheapest first."""
        return pareto_front(self.points)

    def to_dict(self) -> dict[str, Any]:
        """The study as JSON data."""
        front = set(self.front)
        return {
            "instance": {"name": self.instance.name, "sha256": self.instance.sha256},
            "varied": {
                axis.kind: [round(value / KINDS[axis.kind].scale, 9) for value in axis.values]
                for axis in self.axes
            },
            "unit": self.rating.unit or "prize",
            "prices": str(self.prices),
            "left_out": list(self.rating.left_out),
            "total": self.total,
            "designs": self.wanted,
            "points": [
                {**point.to_dict(), "on_front": at in front} for at, point in enumerate(self.points)
            ],
            "runtime_s": self.runtime_s,
        }
