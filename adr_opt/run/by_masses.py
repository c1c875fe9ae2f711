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
from ..common.progress import Progress
from ..mission.problem import Problem, Routes
from ..mission.result import Result, proven_of

SHARE = 0.5
"""Share of the time limit for the plan, where a bound follows."""


def planned(
    problem: Problem,
    limit_s: float,
    plan: Callable[[float], Result],
    prove: Callable[[float, float, Routes], Result] | None,
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
        Bounds :attr:`.Problem.relaxed` for a time [s], from the objective and routes of a plan.
    """
    began = now_s()
    found = plan(limit_s if prove is None else SHARE * limit_s)
    left_s = limit_s - (now_s() - began)
    proven: Result | None = None
    is_open = not problem.meets(found.objective, problem.total_prize)
    if prove is not None and left_s > 0.0 and is_open:
        proven = prove(left_s, found.objective, found.routes)
    runtime_s = now_s() - began
    if proven is None:
        return replace(found, runtime_s=runtime_s)
    return _joined(problem, found, proven, runtime_s)


def bounded(found: Result) -> Result:
    """A bound with the lightest chaser; its plans are not plans of the mission."""
    return replace(
        found,
        sequence=None,
        plan=None,
        objective=-math.inf,
        routes=(),
        status="infeasible" if found.status == "infeasible" else "unknown",
    )


def bounds_only(progress: Progress, objective: float = -math.inf) -> Progress:
    """A listener that passes bounds on, with the objective of a known plan."""
    return lambda _, bound: progress(objective, bound)


def unproven(problem: Problem, found: Result) -> Result:
    """A planner's result without its bounds; collecting all prizes is a proof without one."""
    if found.plan is None:
        return replace(found, status="unknown", upper_bound=math.inf, evidence=None)
    claim = proven_of(problem, found.plan.objective)
    plan, stated = claim.of(found.plan), claim.bound
    return replace(found, plan=plan, status=claim.status, upper_bound=stated, evidence=None)


def _joined(problem: Problem, found: Result, proven: Result, runtime_s: float) -> Result:
    """A plan's result with the bound of another problem."""
    bound, evidence, plan = proven.upper_bound, proven.evidence, found.plan
    if evidence is not None and evidence.cost is not None:
        evidence = replace(evidence, cost=None)
    notes = tuple(dict.fromkeys((*found.notes, *proven.notes)))
    found = replace(found, evidence=evidence, runtime_s=runtime_s, notes=notes)
    if plan is None:
        infeasible = proven.status == "infeasible"
        return replace(found, status="infeasible" if infeasible else "unknown", upper_bound=bound)
    claim = proven_of(problem, plan.objective, bound)
    plan = plan.replace(notes=notes, runtime_s=runtime_s)
    if not (problem.margin or problem.connecting.corrections):  # else it is not of all plans
        plan = plan.replace(**claim._asdict())
    return replace(found, plan=plan, status=claim.status, upper_bound=claim.bound)
