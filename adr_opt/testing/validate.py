"""Runs of a planner on test cases, with a verdict on each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from ..common.errors import InputError
from ..common.options import read
from ..common.stop import MaxIterations, MaxRuntime, Stop
from ..judge.check.verdict import check
from ..mission.problem import Problem
from ..mission.result import Result
from ..run.method_call import FALLBACK, Prepared, prepare
from ..run.method_spec import MethodSpec
from ..run.methods import PLANNERS, adapted, options_of, spec, spec_of_function
from ..run.warm_up import PracticeStop
from .cases import BEGINNING, CASES, OVER, REPEATED, Case

MOST_QUESTIONS = 1000
"""Maximum number of queries of ``stop`` after it returned True, in all threads together."""

RELATIVE = 1e-6
"""Relative difference between sums of prizes in different orders."""

SAME_WORK = 5
"""Number of iterations after which plans are compared."""


class Fault(NamedTuple):
    """An error of a planner.

    Attributes
    ----------
    case : str
        On which of :data:`CASES`.
    reason : str
        In a sentence.
    """

    case: str
    reason: str

    def __str__(self) -> str:
        """The sentence with the name of the case."""
        return f"{self.case}: {self.reason}"


class PlannerFault(AssertionError):
    """Raised with a line for each case in which a planner fails.

    Attributes
    ----------
    faults : tuple of Fault
    """

    def __init__(self, name: str, faults: tuple[Fault, ...], cases: int) -> None:
        self.faults = faults
        lines = "\n".join(f"  {fault}" for fault in faults)
        super().__init__(f"planner {name!r} fails in {len(faults)} of {cases} cases:\n{lines}")


def validate_planner(
    planner: Callable[..., Result] | MethodSpec | str,
    *,
    cases: Iterable[str] | None = None,
    plans: bool = True,
    seed: int = 0,
    time_limit: float = 2.0,
    **options: Any,
) -> tuple[str, ...]:
    """Run a planner on the practice mission and on edge cases, and judge its plans by ``check``.

    It is called as :func:`adr_opt.solve` calls it, but need not be installed. In each case it has
    to return a Result with a plan that breaks no rule, prizes that are those of the plan, no
    incumbent better than that and no bound below it or below a greedy plan; and to stop asking when
    it is told that it is enough.

    Parameters
    ----------
    planner : callable, MethodSpec or str
        The function, what it can do, or the name of an installed planner.
    cases : iterable of str, optional
        Names of :data:`CASES`. By default all, but those of several chasers, of rows that are
        worked out on demand and of start plans for planners that do not know them.
    plans : bool
        Whether it returns plans; False for a bound.
    seed : int
    time_limit : float
        Of each case that is no practice [s].
    **options
        Of the planner.

    Returns
    -------
    tuple of str
        The names of the cases, all of which it passes.

    Raises
    ------
    PlannerFault
        It fails; a line for each case says why.
    InputError
        It cannot be called as planners are, or there is no such case or option.
    """
    name = planner if isinstance(planner, str) else getattr(planner, "__name__", "planner")
    if isinstance(planner, str):
        known = spec(planner)
    else:
        known = planner if isinstance(planner, MethodSpec) else spec_of_function(name, planner)
    function = adapted(known.name, known.load())
    arguments = {"seed": seed, "options": read(options_of(function), options)}
    # Not as a planner, for which a greedy plan would stand in.
    prepared = Prepared(known, function, arguments, plans=False)
    wanted = _wanted(prepared, cases)
    faults = tuple(
        Fault(case, reason)
        for case in wanted
        for reason in _faults(prepared, case, plans, time_limit)
    )
    if faults:
        raise PlannerFault(name, faults, len(wanted))
    return wanted


def _wanted(prepared: Prepared, cases: Iterable[str] | None) -> tuple[str, ...]:
    if cases is not None:
        wanted = (cases,) if isinstance(cases, str) else tuple(cases)
        for case in wanted:
            if case not in CASES:
                raise InputError(f"case {case!r} is unknown; use one of: {', '.join(CASES)}")
        return wanted
    knows = {
        "practice campaign": prepared.spec.several,
        "practice mission without a timetable": prepared.on_demand,
        BEGINNING: prepared.spec.starts,
    }
    return tuple(case for case in CASES if knows.get(case, True))


class _Watched:
    """A stopping criterion that checks whether a planner obeys it."""

    def __init__(self, stop: Stop) -> None:
        self._stop = stop
        self._left = MOST_QUESTIONS

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        if not self._stop(incumbent, bound):
            return False
        self._left -= 1
        if self._left < 0:
            raise AssertionError("it goes on after stop(incumbent, bound) returned True")
        return True

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return self._stop.remaining_s()


class _Over:
    """A stopping criterion that is met from the start."""

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return True

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return 0.0


class _Heard:
    """A progress callback that records the best incumbent and the least bound."""

    def __init__(self) -> None:
        self.incumbent, self.bound = -math.inf, math.inf

    def __call__(self, incumbent: float, bound: float) -> None:
        """Record a report."""
        self.incumbent, self.bound = max(self.incumbent, incumbent), min(self.bound, bound)


def _faults(prepared: Prepared, name: str, plans: bool, time_limit: float) -> Iterator[str]:
    """Errors in a case, in sentences."""
    case = CASES[name]
    problem = case.problem()
    for mission in problem.missions:
        mission.rules  # noqa: B018  builds the timetable, which is no part of the time limit
    known = _greedy(problem)
    if name == BEGINNING:
        prepared = prepared.beginning_from(problem, (known.destinations,), repair=False)

    def stop() -> Stop:
        if name == OVER:
            return _Watched(_Over())
        if name == REPEATED:
            return _Watched(MaxIterations(SAME_WORK))
        if case.practises:
            return _Watched(PracticeStop(prepared.spec.practice.rounds))
        return _Watched(MaxRuntime(time_limit))

    heard = _Heard()
    try:
        result = prepared(problem, stop(), heard)
        again = prepared(problem, stop()) if name == REPEATED else result
    except (Exception, SystemExit) as error:
        said = str(error) if isinstance(error, (InputError, AssertionError)) else repr(error)
        yield f"raised {type(error).__name__}: {said}" if said == str(error) else f"raised {said}"
        return
    yield from _judged(problem, result, case, plans)
    yield from _claimed(result, heard, known)
    if again.routes != result.routes:
        yield (
            f"gives another plan when called again with seed {prepared.arguments['seed']} and "
            f"as many iterations: {again.routes} after {result.routes}"
        )


def _greedy(problem: Problem) -> Result:
    """The plan of a trusted planner."""
    return prepare(PLANNERS, FALLBACK)(problem, MaxIterations(1_000_000))


def _judged(problem: Problem, result: Result, case: Case, plans: bool) -> Iterator[str]:
    """Errors of a missing plan, and violations found by ``check``."""
    plan = result.plan
    if plan is None:
        if plans and case.has_plan:
            said = "".join(f"; {note}" for note in result.notes)
            yield f"returned no plan, although one exists, if only without legs{said}"
        return
    violations = check(problem.instance, plan)
    if violations:
        more = f", and {len(violations) - 1} more" if len(violations) > 1 else ""
        yield f"its plan breaks the rules: {violations[0]}{more}"
    if result.objective != plan.objective:
        yield f"its objective is {result.objective!r}, but that of its plan {plan.objective!r}"


def _claimed(result: Result, heard: _Heard, known: Result) -> Iterator[str]:
    """Errors in reported incumbents and bounds."""
    best = max(result.objective, known.objective)
    bound = min(result.upper_bound, heard.bound)
    if bound < best - _rounding(best):
        yield f"its bound {bound!r} is below {best!r}, which a plan collects"
    if result.plan is not None and heard.incumbent > result.objective + _rounding(result.objective):
        yield (
            f"it reported the incumbent {heard.incumbent!r} and returned a plan that collects "
            f"{result.objective!r}"
        )


def _rounding(prizes: float) -> float:
    return RELATIVE * abs(prizes) if math.isfinite(prizes) else 0.0
