"""The result of a planner or a bound: a certificate."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from itertools import chain
from typing import Any, NamedTuple

from ..common.card import Shown
from ..common.errors import InputError
from ..common.tolerance import COST_RELATIVE
from ..plan.expense import cost_of_routes
from ..plan.plan import MODEL, InstanceReference, Plan, Route, Status, relative_gap
from .build_legs import APPROXIMATE, legs, unvisited
from .campaign import Problem
from .evidence import Evidence
from .prizes import Prizes
from .problem import Mission

PACKAGES = ("adr-opt", "numpy", "numba", "ortools")


def versions() -> dict[str, str]:
    """Versions of the packages that a plan depends on."""
    return dict(_installed())


@cache
def _installed() -> dict[str, str]:
    """Looked up once: each look-up reads files."""
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "unknown"
    return found


@dataclass(frozen=True, repr=False)
class Result(Shown):
    """What a planner or a bound has to say about a mission.

    Attributes
    ----------
    method : str
    sequence : tuple of int or None
        Bodies in order of the best plan, of several chasers one after the other; None if none was
        found (a bound looks for none).
    plan : Plan or None
        The same, priced.
    objective : float
        Sum of the prizes of the plan; −inf without one.
    upper_bound : float
        Proven: no plan has a larger objective. +inf if nothing was proven. Where all prizes are
        collected, their sum.
    status : {"optimal", "feasible", "infeasible", "unknown"}
        "optimal": the bound exceeds the objective by less than the common step of the prizes
        (:attr:`.Prizes.prize_step`), so that no plan collects more. Where prizes have none, by no
        more than :data:`adr_opt.common.tolerance.RELATIVE` of the sum of all prizes.
    counters : mapping
        What the method did: iterations, nodes, labels …
    seed : int
    runtime_s : float
    notes : tuple of str
        What a reader of the result has to know.
    routes : tuple of tuple of int
        Bodies in order for each chaser.
    versions : mapping
    evidence : Evidence or None
        What the upper bound rests on, where a method can tell.
    """

    method: str
    sequence: tuple[int, ...] | None
    plan: Plan | None
    objective: float
    upper_bound: float
    status: Status
    counters: Mapping[str, float]
    seed: int
    runtime_s: float
    notes: tuple[str, ...] = ()
    routes: tuple[tuple[int, ...], ...] = ()
    versions: Mapping[str, str] = field(default_factory=versions)
    evidence: Evidence | None = None

    @property
    def destinations(self) -> tuple[str, ...]:
        """:attr:`sequence` by names; empty without a plan."""
        return () if self.plan is None else self.plan.destinations

    @property
    def orders(self) -> dict[str, tuple[str, ...]]:
        """:attr:`routes` by names, by the name of the chaser; empty without a plan."""
        return {} if self.plan is None else self.plan.orders

    @property
    def gap(self) -> float:
        """(upper bound − objective) / upper bound; +inf if one of them is missing."""
        if not math.isfinite(self.upper_bound) or self.plan is None:
            return math.inf
        return relative_gap(self.objective, self.upper_bound)

    def to_dict(self) -> dict[str, Any]:
        """The result of a bound as plain data: what ``bound --json`` prints."""
        return {
            "method": self.method,
            "upper_bound": self.upper_bound if math.isfinite(self.upper_bound) else None,
            "objective": self.objective if math.isfinite(self.objective) else None,
            "status": self.status,
            "runtime_s": self.runtime_s,
            "seed": self.seed,
            "counters": dict(self.counters),
            "notes": list(self.notes),
            "versions": dict(self.versions),
        }


def _lacks(problem: Prizes, lacking: tuple[int, ...], status: Status) -> str:
    """What to say where there is no plan for want of required targets."""
    names = ", ".join(repr(problem.names[body]) for body in lacking)
    if status == "infeasible":
        return f"no plan services all required targets; the best one found lacks {names}"
    return f"no plan was found that services all required targets; the best one lacks {names}"


def _refuse_doubles(problem: Prizes, moves: Sequence[int]) -> None:
    """A target is done once, by one chaser.

    Raises
    ------
    InputError
        One is done twice.
    """
    first = problem.instance.first_target
    twice = [body for body, times in Counter(moves).items() if times > 1 and body >= first]
    if twice:
        raise InputError(f"{problem.names[twice[0]]!r} is visited twice; a target is done once")


def cost_gap(cost: float, bound: float) -> float:
    """(cost − bound) / cost; 0 where the plan costs nothing."""
    return (cost - bound) / cost if cost > 0.0 else 0.0


def cost_status(cost: float, bound: float) -> Status:
    """What is proven of the cost of a plan among all that collect as much.

    Costs have no steps: that is the least which exceeds its bound by no more than
    :data:`adr_opt.common.tolerance.COST_RELATIVE` of it.
    """
    return "optimal" if cost <= bound + COST_RELATIVE * abs(bound) else "feasible"


def status_of(problem: Prizes, objective: float, upper_bound: float) -> Status:
    """What is proven of a plan; all prizes collected is a proof without any bound."""
    met = problem.meets(objective, min(upper_bound, problem.total_prize))
    return "optimal" if met else "feasible"


class Proven(NamedTuple):
    """What a plan says of what is proven of it.

    Attributes
    ----------
    status : {"optimal", "feasible"}
    upper_bound, gap : float or None
        None where nothing is.
    """

    status: Status
    upper_bound: float | None
    gap: float | None


def proven_of(problem: Prizes, objective: float, upper_bound: float = math.inf) -> Proven:
    """What is proven of a plan; where all prizes are collected their sum is its bound.

    Parameters
    ----------
    problem : Mission or Campaign
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
        return Proven(status, None, None)
    return Proven(status, upper_bound, relative_gap(objective, upper_bound))


def certify(
    mission: Mission,
    method: str,
    sequence: Iterable[int | str] | None,
    *,
    seed: int,
    runtime_s: float,
    upper_bound: float = math.inf,
    cost_bound: float | None = None,
    evidence: Evidence | None = None,
    counters: Mapping[str, float] | None = None,
    notes: Iterable[str] = (),
) -> Result:
    """Make the certificate of a sequence of bodies and a bound: the way every method ends.

    Parameters
    ----------
    mission : Mission
    method : str
    sequence : iterable of int or str, or None
        The best plan found: bodies by number or by name.
    seed : int
    runtime_s : float
    upper_bound : float
        Proven bound on what plans are worth to a planner (:attr:`Prizes.bonus`), +inf for none.
    cost_bound : float, optional
        Proven: no plan that collects as much costs less. None if nobody asked.
    evidence : Evidence, optional
        What the upper bound rests on.
    counters, notes
        As in :class:`Result`.

    Raises
    ------
    InputError
        The sequence breaks the mission rules.
    """
    routes = None if sequence is None else [sequence]
    return certify_routes(
        mission, method, routes, seed=seed, runtime_s=runtime_s, upper_bound=upper_bound,
        cost_bound=cost_bound, evidence=evidence, counters=counters, notes=notes,
    )  # fmt: skip


def certify_routes(
    problem: Problem,
    method: str,
    routes: Iterable[Iterable[int | str]] | None,
    *,
    seed: int,
    runtime_s: float,
    upper_bound: float = math.inf,
    cost_bound: float | None = None,
    evidence: Evidence | None = None,
    counters: Mapping[str, float] | None = None,
    notes: Iterable[str] = (),
) -> Result:
    """Make the certificate of the routes of all chasers, likewise.

    Parameters
    ----------
    problem : Mission or Campaign
    method : str
    routes : iterable of sequences of int or str, or None
        Bodies in order for each chaser, by number or by name; no target twice.
    seed, runtime_s, upper_bound, cost_bound, evidence, counters, notes
        As :func:`certify` takes them.

    Raises
    ------
    InputError
        A sequence breaks the mission rules.
    """
    said = tuple(notes)
    if problem.instance.is_approximate:
        said = (*said, APPROXIMATE)
    upper_bound = problem.shown(upper_bound)
    found = () if routes is None else routes
    flown = [
        (mission, mission.closed(sequence))
        for mission, sequence in zip(problem.missions, found, strict=routes is not None)
    ]
    moves = tuple(chain.from_iterable(sequence for _, sequence in flown))
    _refuse_doubles(problem, moves)
    lacking = () if routes is None else problem.lacking(moves)
    may_stop = all(mission.may_stop(sequence) for mission, sequence in flown)
    if routes is None or lacking or not may_stop:
        # A bound that no plan with all required targets reaches says that there is none.
        status: Status = "infeasible" if upper_bound == -math.inf else "unknown"
        if lacking:
            said = (*said, _lacks(problem, lacking, status))
        return Result(
            method, None, None, -math.inf, upper_bound, status, dict(counters or {}), seed,
            runtime_s, said, evidence=evidence,
        )  # fmt: skip
    priced = tuple(
        Route(chaser=mission.chaser.name, legs=legs(mission, sequence))
        for mission, sequence in flown
    )
    objective = problem.prizes(moves)
    status, bound, gap = proven_of(problem, objective, upper_bound)
    cost = cost_of_routes(problem.instance, priced)
    if cost_bound is not None:
        cost_bound = min(cost_bound, cost)  # they may differ by rounding
    plan = Plan(
        model=MODEL,
        instance=InstanceReference(name=problem.instance.name, sha256=problem.sha256),
        method=method,
        seed=seed,
        status=status,
        objective=objective,
        upper_bound=bound,
        gap=gap,
        cost=cost,
        cost_bound=cost_bound,
        cost_gap=None if cost_bound is None else cost_gap(cost, cost_bound),
        cost_status=None if cost_bound is None else cost_status(cost, cost_bound),
        runtime_s=runtime_s,
        versions=versions(),
        notes=said,
        routes=priced,
        unvisited=unvisited(flown),
    )
    upper_bound = math.inf if bound is None else bound
    return Result(
        method, moves, plan, objective, upper_bound, status, dict(counters or {}), seed, runtime_s,
        said, tuple(sequence for _, sequence in flown), evidence=evidence,
    )  # fmt: skip


def noted(result: Result, notes: Sequence[str]) -> Result:
    """A result with more notes, its plan included."""
    if not notes:
        return result
    plan = result.plan
    if plan is not None:
        plan = plan.replace(notes=(*plan.notes, *notes))
    return replace(result, notes=(*result.notes, *notes), plan=plan)
