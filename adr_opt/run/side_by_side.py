"""Concurrent runs of a planner and a bound until they meet."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import replace

from ..common.clock import now_s
from ..common.progress import Progress, Relayed
from ..common.stop import Proven, Stop
from ..mission.build_legs import ON_PRICES
from ..mission.certified import certify_routes
from ..mission.problem import Problem
from ..mission.result import Result

Method = Callable[[Problem, Stop, Progress], Result]

BOUND_NOTE = "upper bound by "
"""Beginning of a plan's note that names the method of its bound."""


class InvalidBound(RuntimeError):
    """A legal plan exceeds a bound that claims to be proven: one of them is wrong."""


class Meeting:
    """Shared state of two methods: the best incumbent and the best bound.

    Parameters
    ----------
    stop : Stop
        Asked with the pair whenever one of the two asks, never by both at once. Once it says
        enough, it is enough for both.
    progress : Progress
        Called with the pair whenever it improves.
    """

    def __init__(self, stop: Stop, progress: Progress) -> None:
        self._stop = stop
        self._progress = progress
        self._proven = Proven()
        # Reentrant: a progress may ask.
        self._lock = threading.RLock()
        self._ended = False
        self.incumbent = -math.inf
        self.bound = math.inf

    def hear(self, incumbent: float, bound: float) -> None:
        """Update the incumbent and the bound if they have improved."""
        with self._lock:
            if incumbent > self.incumbent or bound < self.bound:
                self.incumbent = max(self.incumbent, incumbent)
                self.bound = min(self.bound, bound)
                self._progress(self.incumbent, self.bound)

    def enough(self, incumbent: float, bound: float, limit: Stop | None = None) -> bool:
        """Whether to stop a method; ``limit`` is its own and stops no other."""
        with self._lock:
            self.hear(incumbent, bound)
            pair = self.incumbent, self.bound
            self._ended = self._stop(*pair) or self._proven(*pair) or self._ended
            alone = limit is not None and limit(*pair)
            return self._ended or alone

    def end(self) -> None:
        """Stop both."""
        self._ended = True

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return 0.0 if self._ended else self._stop.remaining_s()


class Seat:
    """Stopping criterion of one of the two.

    Parameters
    ----------
    meeting : Meeting
    limit : Stop, optional
        A limit of its own.
    """

    def __init__(self, meeting: Meeting, limit: Stop | None = None) -> None:
        self._meeting = meeting
        self._limit = limit

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self._meeting.enough(incumbent, bound, self._limit)

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        own = math.inf if self._limit is None else self._limit.remaining_s()
        return min(own, self._meeting.remaining_s())


def together(
    problem: Problem,
    planner: Method,
    bound: Method,
    stop: Stop,
    progress: Progress,
    limits: Sequence[Stop] = (),
) -> Result:
    """Run a planner and a bound concurrently, and merge their results.

    The planner runs in the thread of the caller, the bound in a second one. Both are told to stop
    as soon as the incumbent meets the bound or ``stop`` says enough; one that ends by itself
    leaves the other running. If one fails, the other is told to stop and the failure is raised.

    Parameters
    ----------
    problem : Problem
    planner, bound : callable
        Called with mission, stop and progress, as :class:`.method_call.Prepared` is.
    stop : Stop
        Asked by both, with the best incumbent and the best bound of both.
    progress : Progress
        Told of the same pair.
    limits : sequence of Stop
        A limit of the planner alone and one of the bound alone, or nothing. Where work is limited
        in this way and no other limit is reached, objective, bound and status do not depend on
        their speed: a side is cut short only when nothing is left to gain. Which of several
        optimal plans is returned may.

    Returns
    -------
    Result
        The planner's plan, or the bound's if that one is worth more. The bound is the least of
        both and of the sum of all prizes.

    Raises
    ------
    InvalidBound
        The plan is worth more than the bound.
    """
    for each in problem.missions:
        _ = each.rules  # made once, not once in each thread
    began = now_s()
    meeting = Meeting(stop, progress)
    meeting.hear(-math.inf, problem.total_prize)
    heard = Relayed(meeting.hear, progress)
    seats = [Seat(meeting, limit) for limit in limits or (None, None)]
    results: list[Result] = []
    errors: list[BaseException] = []

    def prove() -> None:
        try:
            proven = bound(problem, seats[1], heard)
            results.append(proven)
            meeting.hear(proven.objective, proven.upper_bound)
        except BaseException as error:
            errors.append(error)
            meeting.end()

    # A daemon: a second interrupt must not wait for a bound that never asks.
    thread = threading.Thread(target=prove, name="bound", daemon=True)
    thread.start()
    try:
        planned = planner(problem, seats[0], heard)
        meeting.hear(planned.objective, planned.upper_bound)
        thread.join()
    except BaseException:
        meeting.end()
        thread.join()
        raise
    if errors:
        raise errors[0]
    return _join(problem, planned, results[0], now_s() - began)


def _join(problem: Problem, planned: Result, proven: Result, runtime_s: float) -> Result:
    """Merge two results into one."""
    best = proven if proven.objective > planned.objective else planned
    upper_bound = float(min(planned.upper_bound, proven.upper_bound, problem.total_prize))
    if best.sequence is not None:
        if best.objective > upper_bound + problem.rounding:
            raise InvalidBound(
                f"the plan by {best.method!r} of objective {best.objective!r} exceeds the bound "
                f"{upper_bound!r} by {planned.method!r} and {proven.method!r}: "
                "a method is broken, please report it with the instance"
            )
        upper_bound = max(upper_bound, best.objective)  # they may differ by rounding

    notes = [*planned.notes, *proven.notes, f"{BOUND_NOTE}{proven.method}"]
    if best is proven:
        notes.append(f"{proven.method} found a better plan than {planned.method}")
    counters = {f"planner.{name}": count for name, count in planned.counters.items()}
    counters |= {f"bound.{name}": count for name, count in proven.counters.items()}
    result = certify_routes(
        problem,
        best.method,
        None if best.plan is None else best.routes,
        seed=planned.seed,
        runtime_s=runtime_s,
        upper_bound=problem.worth(upper_bound),
        evidence=min(planned, proven, key=lambda side: side.upper_bound).evidence,
        counters=counters,
        notes=[note for note in dict.fromkeys(notes) if note not in ON_PRICES],
    )
    if result.plan is None and "infeasible" in (planned.status, proven.status):
        return replace(result, status="infeasible")
    return result
