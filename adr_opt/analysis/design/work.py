"""Common data of a study's designs, the point of a design's plan, and its row.

Plans of a file are checked when they are read, and what they avoid and cost is worked out anew; of
a row only its plan and its bound count.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

from ...common.errors import InputError
from ...common.files import parse_model
from ...judge.admit import admit
from ...plan.plan import Plan
from ...plan.routes import routes_of
from ...problem.instance import Instance
from .designs import Design, designed
from .prices import CampaignPrices, Spending, spending_of
from .rating import Rating
from .results import DesignPoint

ROUNDED = 1e-9
"""Relative excess of a worth over its bound that rounding may cause."""


class BrokenBound(RuntimeError):
    """A plan avoids more than a bound that claims to be proven: a method is wrong."""


@dataclass(frozen=True)
class DesignWork:
    """Data from which each design is run, in this process or elsewhere.

    Attributes
    ----------
    instance : Instance
        That designs vary, with targets of known worth alone.
    rating : Rating
    prices : CampaignPrices
    method : str
    time_limit_s : float
        Of the plan, and again of the bound [s].
    seed : int
    """

    instance: Instance
    rating: Rating
    prices: CampaignPrices
    method: str
    time_limit_s: float
    seed: int

    def priced(self, design: Design) -> Instance:
        """The instance of a design with its prices, before its budget.

        Raises
        ------
        InputError
            A value is not valid, or a price is missing.
        """
        return self.prices.applied(designed(self.instance, design))

    def spending(self, design: Design) -> Spending | None:
        """The restrictions by a design's budget; None if it allows no launch."""
        made = self.priced(design)
        budget = design.value("budget")
        if budget is None:
            return Spending(made, made, 0.0)
        return spending_of(made, self.prices, self.rating, budget)

    def instance_of(self, design: Design) -> Instance:
        """The instance of a design's plans: with floors as prizes, and without useless launches."""
        allowed = self.spending(design)
        return self.rating.planned(self.priced(design) if allowed is None else allowed.planned)

    def point(
        self,
        design: Design,
        instance: Instance,
        plan: Plan | None,
        bound: float,
        runtime_s: float = 0.0,
        cpu_s: float = 0.0,
    ) -> DesignPoint:
        """A design with a plan, evaluated.

        Raises
        ------
        BrokenBound
            The plan avoids more than the bound.
        """
        chosen = () if plan is None else targets_of(instance, plan)
        worth = self.rating.worth_of(instance, chosen)
        floor = min(self.rating.floor_of(instance, chosen), worth)
        if self.rating.worths is None and plan is not None:
            floor = worth = plan.objective  # prizes may fall with time
        if worth > bound * (1.0 + ROUNDED):
            raise BrokenBound(
                f"at {design.title} a plan avoids {worth!r}, more than the bound {bound!r}: a "
                "method is broken, please report it"
            )
        flown = () if plan is None else routes_of(instance, plan)
        return DesignPoint(
            design,
            instance,
            plan,
            floor=floor,
            worth=worth,
            bound=max(bound, worth),
            euros=0.0 if plan is None else self.prices.of_plan(instance, plan),
            launches=sum(bool(each.legs) for each in flown),
            removals=len(chosen),
            runtime_s=runtime_s,
            cpu_s=cpu_s,
        )

    @property
    def of(self) -> dict[str, Any]:
        """Everything besides the design on which rows depend, as JSON data."""
        worths = self.rating.worths
        return {
            "instance": self.instance.sha256,
            "worths": None if worths is None else worths.digest,
            "prices": str(self.prices),
            "settings": f"method {self.method}, {self.time_limit_s:g} s, seed {self.seed}",
        }

    def from_json(self, design: Design, row: dict[str, Any]) -> DesignPoint:
        """The point of a row from a file.

        Raises
        ------
        InputError
            Its plan has violations, or says more than can be.
        ValueError, TypeError, KeyError
            It is no such row.
        """
        instance, plan = self.instance_of(design), None
        if row["plan"] is not None:
            plan = admit(instance, parse_model(json.dumps(row["plan"]), Plan, "plan")).plan
        bound = math.inf if row["bound"] is None else row["bound"]
        times = row["runtime_s"], row["cpu_s"]
        for number in (bound, *times):
            if not isinstance(number, (int, float)) or not float(number) >= 0.0:
                raise ValueError("a field of the row is not a number")
        try:
            point = self.point(design, instance, plan, bound, *times)
        except BrokenBound:
            raise InputError("its plan avoids more than its bound") from None
        if point.euros > design.budget:
            raise InputError("its plan is beyond the budget")
        return point


def to_json(point: DesignPoint) -> dict[str, Any]:
    """A row of a file."""
    return {
        "plan": None if point.plan is None else point.plan.to_dict(),
        "bound": point.bound if math.isfinite(point.bound) else None,
        "runtime_s": round(point.runtime_s, 3),
        "cpu_s": round(point.cpu_s, 3),
    }


def targets_of(instance: Instance, plan: Plan) -> tuple[str, ...]:
    """Targets of a plan, in order."""
    return tuple(body for body in plan.destinations if body not in instance.station_names)
