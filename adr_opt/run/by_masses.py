"""Plans and bounds of missions whose transfers depend on the mass of the chaser.

A plan keeps to the legs of the heaviest chaser, which a lighter one can fly, too. A bound is one of
the legs of the lightest. So what a planner proves of the first kind is no bound, and bounds of the
second kind are worked out after it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from ..common.clock import now_s
from ..mission.problem import Problem, Routes
from ..mission.result import Result, proven_of

SHARE = 0.5
"""Share of the time limit for the plan, where a bound follows."""


def planned(
    problem: Problem,
    limit_s: float,
    plan: Callable[[float], Result],
    prove: Callable[[float, Routes], Result] | None,
) -> Result:
    """Plan with the heaviest chaser, and bound with the lightest.

    Parameters
    ----------
    problem : Problem
    limit_s : float
        Time limit of both [s].
    plan : callable
        Plans for a time [s].
    prove : callable or None
        Bounds :attr:`.Problem.relaxed` for a time [s], from the routes of a plan, if there is one.
    """
    began = now_s()
    found = plan(limit_s if prove is None else SHARE * limit_s)
    left_s = limit_s - (now_s() - began)
    proven: Result | None = None
    is_open = not problem.meets(found.objective, problem.total_prize)
    if prove is not None and left_s > 0.0 and is_open:
        proven = prove(left_s, found.routes)
    bound = math.inf if proven is None else proven.upper_bound
    return _joined(problem, found, proven, bound, now_s() - began)


def bounded(found: Result) -> Result:
    """A bound with the lightest chaser, whose plans are none of the mission."""
    return replace(
        found, sequence=None, plan=None, objective=-math.inf, routes=(),
        status="infeasible" if found.status == "infeasible" else "unknown",
    )  # fmt: skip


def _joined(
    problem: Problem, found: Result, proven: Result | None, bound: float, runtime_s: float
) -> Result:
    """A plan's result with the bound of another problem."""
    evidence = None if proven is None else proven.evidence
    if evidence is not None and evidence.cost is not None:
        evidence = replace(evidence, cost=None)
    plan = found.plan
    if plan is None:
        infeasible = proven is not None and proven.status == "infeasible"
        return replace(
            found, status="infeasible" if infeasible else "unknown", upper_bound=bound,
            evidence=evidence, runtime_s=runtime_s,
        )  # fmt: skip
    claim = proven_of(problem, plan.objective, bound)
    plan = plan.replace(
        **claim._asdict(), cost_bound=None, cost_gap=None, cost_status=None, runtime_s=runtime_s
    )
    stated = math.inf if claim.upper_bound is None else claim.upper_bound
    return replace(
        found, plan=plan, status=claim.status, upper_bound=stated, evidence=evidence,
        runtime_s=runtime_s,
    )  # fmt: skip
