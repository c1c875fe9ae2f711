"""The result of a planner or a bound, with a quality certificate."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any, NamedTuple

from ..common.card import Shown
from ..common.tolerance import COST_RELATIVE
from ..plan.plan import Plan, Status, relative_gap
from .evidence import Evidence
from .prizes import Prizes

PACKAGES = ("adr-opt", "numpy", "numba", "ortools")


def versions() -> dict[str, str]:
    """Versions of the packages that plans depend on."""
    return dict(_installed())


@cache
def _installed() -> dict[str, str]:
    """Versions, looked up once, as each look-up reads files."""
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "unknown"
    return found


@dataclass(frozen=True, repr=False)
class Result(Shown):
    """The result of a planner or a bound for a mission.

    Attributes
    ----------
    method : str
    sequence : tuple of int or None
        Bodies in order of the best plan, chaser after chaser; None if none was found (bounds search
        for none).
    plan : Plan or None
        The best plan with legs and costs.
    objective : float
        Sum of the prizes of the plan; −inf without one.
    upper_bound : float
        Proven: no plan has a larger objective; +inf if nothing was proven. If all prizes are
        collected, their sum.
    status : {"optimal", "feasible", "infeasible", "unknown"}
        "optimal": the bound exceeds the objective by less than the common step of the prizes
        (:attr:`.Prizes.prize_step`), so that no plan collects more. Where prizes have none, by no
        more than :data:`adr_opt.common.tolerance.RELATIVE` of the sum of all prizes.
    counters : mapping
        Work of the method: iterations, nodes, labels …
    seed : int
    runtime_s : float
    notes : tuple of str
        Notes for readers of the result.
    routes : tuple of tuple of int
        Bodies in order for each chaser.
    versions : mapping
    evidence : Evidence or None
        Evidence for the upper bound, if the method provides any.
    """

    method: str
    sequence: tuple[int, ...] | None = None
    plan: Plan | None = None
    objective: float = -math.inf
    upper_bound: float = math.inf
    status: Status = "unknown"
    counters: Mapping[str, float] = field(default_factory=dict)
    seed: int = 0
    runtime_s: float = 0.0
    notes: tuple[str, ...] = ()
    routes: tuple[tuple[int, ...], ...] = ()
    versions: Mapping[str, str] = field(default_factory=versions)
    evidence: Evidence | None = None

    @property
    def destinations(self) -> tuple[str, ...]:
        """:attr:`sequence` as names; empty without a plan."""
        return () if self.plan is None else self.plan.destinations

    @property
    def orders(self) -> dict[str, tuple[str, ...]]:
        """:attr:`routes` as names, by name of the chaser; empty without a plan."""
        return {} if self.plan is None else self.plan.orders

    @property
    def gap(self) -> float:
        """(upper bound − objective) / upper bound; +inf if either is missing."""
        if not math.isfinite(self.upper_bound) or self.plan is None:
            return math.inf
        return relative_gap(self.objective, self.upper_bound)

    def to_dict(self) -> dict[str, Any]:
        """The result of a bound as plain data: the output of ``bound --json``."""
        return {
            "method": self.method,
            "upper_bound": self.upper_bound if math.isfinite(self.upper_bound) else None,
            "objective": self.objective if math.isfinite(self.objective) else None,
            "cost_bound": None if self.plan is None else self.plan.cost_bound,
            "status": self.status,
            "runtime_s": self.runtime_s,
            "seed": self.seed,
            "counters": dict(self.counters),
            "notes": list(self.notes),
            "versions": dict(self.versions),
        }


def cost_gap(cost: float, bound: float) -> float:
    """(cost − bound) / cost; 0 if the cost is 0."""
    return (cost - bound) / cost if cost > 0.0 else 0.0


def cost_status(cost: float, bound: float) -> Status:
    """Status of a plan's cost among all plans with equal prizes.

    Costs have no steps: that is the least which exceeds its bound by no more than
    :data:`adr_opt.common.tolerance.COST_RELATIVE` of it.
    """
    return "optimal" if cost <= bound + COST_RELATIVE * abs(bound) else "feasible"


def status_of(problem: Prizes, objective: float, upper_bound: float) -> Status:
    """Status of a plan; collecting all prizes is a proof without a bound."""
    met = problem.meets(objective, min(upper_bound, problem.total_prize))
    return "optimal" if met else "feasible"


class Claim(NamedTuple):
    """A plan's claim about what is proven.

    Attributes
    ----------
    status : {"optimal", "feasible"}
    upper_bound, gap : float or None
        None where nothing is.
    """

    status: Status
    upper_bound: float | None
    gap: float | None

    @property
    def bound(self) -> float:
        """The upper bound, +inf where nothing is proven."""
        return math.inf if self.upper_bound is None else self.upper_bound

    def of(self, plan: Plan, **changes: Any) -> Plan:
        """A plan with this claim, and no claim about its cost."""
        changes |= {"cost_bound": None, "cost_gap": None, "cost_status": None}
        return plan.replace(**self._asdict(), **changes)


def proven_of(problem: Prizes, objective: float, upper_bound: float = math.inf) -> Claim:
    """Claim of a plan; if all prizes are collected, their sum is its bound.

    Parameters
    ----------
    problem : Problem
    objective : float
    upper_bound : float
        In prizes, +inf for none.
    """
    status = status_of(problem, objective, upper_bound)
    if status == "optimal":
        upper_bound = min(problem.rounded_down(upper_bound), problem.total_prize)
        # Sums of the same prizes in another order.
        upper_bound = max(upper_bound, objective)
    if not math.isfinite(upper_bound):
        return Claim(status, None, None)
    return Claim(status, upper_bound, relative_gap(objective, upper_bound))


def noted(result: Result, notes: Sequence[str]) -> Result:
    """A result with additional notes, its plan included."""
    if not notes:
        return result
    plan = result.plan
    if plan is not None:
        plan = plan.replace(notes=(*plan.notes, *notes))
    return replace(result, notes=(*result.notes, *notes), plan=plan)
