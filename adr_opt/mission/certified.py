"""Results from orders of bodies: legs, prices and status."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain

from ..common.errors import InputError
from ..plan.expense import cost_of_routes
from ..plan.plan import MODEL, InstanceReference, Plan, Route, Status
from .build_legs import APPROXIMATE, FREELY, legs
from .evidence import Evidence
from .left_out import unvisited
from .mission import Mission
from .prizes import Prizes
from .problem import Problem
from .result import Result, cost_gap, cost_status, proven_of, versions
from .schedule import Schedule


def _lacks(problem: Prizes, lacking: tuple[int, ...], status: Status) -> str:
    """The note where no plan exists because required targets are missing."""
    names = ", ".join(repr(problem.names[body]) for body in lacking)
    if status == "infeasible":
        return f"no plan services all required targets; the best attempt misses {names}"
    return f"no plan found services all required targets; the best attempt misses {names}"


def _refuse_doubles(problem: Prizes, moves: Sequence[int]) -> None:
    """Refuse routes that service a target twice.

    Raises
    ------
    InputError
        One is done twice.
    """
    first = problem.instance.first_target
    twice = [body for body, times in Counter(moves).items() if times > 1 and body >= first]
    if twice:
        raise InputError(f"{problem.names[twice[0]]!r} is visited twice; visit it once")


def certify(  # noqa: PLR0913
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
    """Make the result of a sequence of bodies and a bound, as every method does at its end.

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
        Proven: no plan that collects as much costs less. None if not proven.
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
        Problem.of(mission),
        method,
        routes,
        seed=seed,
        runtime_s=runtime_s,
        upper_bound=upper_bound,
        cost_bound=cost_bound,
        evidence=evidence,
        counters=counters,
        notes=notes,
    )


def certify_routes(  # noqa: PLR0913
    problem: Problem,
    method: str,
    routes: Iterable[Iterable[int | str]] | None,
    *,
    seed: int,
    runtime_s: float,
    schedules: Sequence[Schedule | None] | None = None,
    upper_bound: float = math.inf,
    cost_bound: float | None = None,
    evidence: Evidence | None = None,
    counters: Mapping[str, float] | None = None,
    notes: Iterable[str] = (),
) -> Result:
    """Make the result of the routes of all chasers and a bound.

    Parameters
    ----------
    problem : Problem
    method : str
    routes : iterable of sequences of int or str, or None
        Bodies in order for each chaser, by number or by name; no target twice.
    schedules : sequence of Schedule or None, optional
        When each route is flown; by default at its best schedule.
    seed, runtime_s, upper_bound, cost_bound, evidence, counters, notes
        As :func:`certify` takes them.

    Raises
    ------
    InputError
        A sequence breaks the mission rules.
    """
    said = tuple(notes)
    if problem.instance.transfer.burns == "free":
        said = (*said, FREELY)
    elif problem.instance.is_approximate:
        said = (*said, APPROXIMATE)
    upper_bound = problem.shown(upper_bound)
    found = Result(
        method, counters=dict(counters or {}), seed=seed, runtime_s=runtime_s, evidence=evidence
    )
    flown = [
        (mission, mission.closed(sequence))
        for mission, sequence in zip(problem.missions, routes or (), strict=routes is not None)
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
        return replace(found, upper_bound=upper_bound, status=status, notes=said)
    priced = tuple(
        Route(chaser=mission.chaser.name, legs=legs(mission, sequence, timing))
        for (mission, sequence), timing in zip(flown, schedules or [None] * len(flown), strict=True)
    )
    legs_flown = [leg for route in priced for leg in route.legs]
    objective = problem.prizes(moves, [leg.free_s for leg in legs_flown])
    claim = proven_of(problem, objective, upper_bound)
    cost = cost_of_routes(problem.instance, priced)
    if cost_bound is not None:
        cost_bound = min(cost_bound, cost)  # they may differ by rounding
    plan = Plan(
        model=MODEL,
        instance=InstanceReference(name=problem.instance.name, sha256=problem.sha256),
        method=method,
        seed=seed,
        **claim._asdict(),
        objective=objective,
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
    return replace(
        found,
        sequence=moves,
        plan=plan,
        objective=objective,
        upper_bound=claim.bound,
        status=claim.status,
        notes=said,
        routes=tuple(sequence for _, sequence in flown),
    )
