"""Planning in a thread: one plan at a time, observable and stoppable, on an existing timetable."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from ...common.errors import InputError
from ...common.stop import Interrupted, MaxRuntime
from ...mission.result import Result
from ...plan.plan import Plan, relative_gap
from ...problem.instance import Instance
from ...run import front
from ...run.front import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S
from ...run.method_call import method_of, spec_of
from ...run.methods import BOUNDS, PLANNERS
from ...run.reused_timetable import Reused
from ...run.start_plan import start_destinations
from ..report.text import NOTHING, number

Phase = Literal["idle", "waiting", "compiling", "timetable", "planning", "done", "failed"]

MOST_POINTS = 400
"""Maximum number of stored changes of incumbent and bound, first and last ones."""

LONGEST_S = 7.0 * 86400.0
"""Largest time limit; beyond it, a typing error is assumed."""


@dataclass(frozen=True)
class PlanningOrder:
    """Parameters of a planning run.

    Attributes
    ----------
    method : str
    time_limit_s : float
        Wall time [s].
    bound : str or None
        Bound to run beside the planner.
    seed : int
    goes_on : bool
        Whether to begin from the plan that is there, where the method can.
    """

    method: str = DEFAULT_METHOD
    time_limit_s: float = DEFAULT_TIME_LIMIT_S
    bound: str | None = None
    seed: int = 0
    goes_on: bool = True

    def check(self) -> None:
        """Refuse invalid parameters before anything starts.

        Raises
        ------
        InputError
            An unknown method or bound, or a time limit that is none.
        """
        MaxRuntime(self.time_limit_s)
        if self.time_limit_s > LONGEST_S:
            raise InputError(f"time limit = {self.time_limit_s:g}: must be at most {LONGEST_S:g} s")
        method_of(self.method, PLANNERS)
        if self.bound is not None:
            method_of(self.bound, BOUNDS)


@dataclass(frozen=True)
class Look:
    """Progress of a run.

    Attributes
    ----------
    number : int
        Of the run, from 1; 0 before the first.
    phase : Phase
        "waiting" for the run before it to stop.
    stopping : bool
        Whether it was told to stop.
    limit_s : float
        Its time limit [s].
    elapsed_s : float
        Since its clock began, after compiling [s].
    built : float
        Share of the timetable that is built.
    incumbent, bound : float
        −inf and +inf for none yet.
    points : tuple of (float, float, float)
        When each of the two changed [s], and to what.
    said : str
        What became of it, or why it failed.
    """

    number: int = 0
    phase: Phase = "idle"
    stopping: bool = False
    limit_s: float = 0.0
    elapsed_s: float = 0.0
    built: float = 1.0
    incumbent: float = -math.inf
    bound: float = math.inf
    points: tuple[tuple[float, float, float], ...] = ()
    said: str = ""

    @property
    def runs(self) -> bool:
        """Whether it is still running."""
        return self.phase not in ("idle", "done", "failed")

    def to_dict(self) -> dict[str, Any]:
        """The progress as JSON data, with null for numbers that are not finite."""
        known = math.isfinite(self.incumbent) and math.isfinite(self.bound)
        gap = relative_gap(self.incumbent, self.bound) if known else None
        return {
            "number": self.number,
            "phase": self.phase,
            "runs": self.runs,
            "stopping": self.stopping,
            "limit_s": self.limit_s,
            "elapsed_s": round(self.elapsed_s, 3),
            "built": round(self.built, 4),
            "incumbent": _finite(self.incumbent),
            "bound": _finite(self.bound),
            "gap": gap,
            "gap_words": in_percent(gap),
            "points": [[round(at, 3), _finite(a), _finite(b)] for at, a, b in self.points],
            "said": self.said,
        }


def in_percent(gap: float | None) -> str:
    """A gap as in the report; empty if there is none."""
    return NOTHING if gap is None else f"{number(100.0 * gap)} %"


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


@dataclass
class _Run:
    """A run, shared by its thread and its observers."""

    number: int
    order: PlanningOrder
    stop: Interrupted = field(default_factory=Interrupted)
    over: threading.Event = field(default_factory=threading.Event)
    phase: Phase = "waiting"
    began: float | None = None
    ended: float | None = None
    built: float = 1.0
    points: list[tuple[float, float, float]] = field(default_factory=list)
    said: str = ""

    def building(self, share: float) -> None:
        """Receive the share of the timetable that is built; the clock has started."""
        self._begin()
        self.phase, self.built = "timetable", share

    def __call__(self, incumbent: float, bound: float) -> None:
        """Receive an incumbent and a bound."""
        self._begin()
        self.phase, self.built = "planning", 1.0
        last = self.points[-1] if self.points else (0.0, -math.inf, math.inf)
        best = max(incumbent, last[1]), min(bound, last[2])
        if best == last[1:]:
            return
        if len(self.points) >= MOST_POINTS:
            del self.points[MOST_POINTS // 2]
        self.points.append((self.elapsed_s, *best))

    def settle(self, result: Result) -> None:
        """Adopt the final result, which may be below an incumbent reported before."""
        self._begin()
        known, stated = (-math.inf, math.inf), (result.objective, result.upper_bound)
        if (self.points[-1][1:] if self.points else known) != stated:
            self.points.append((self.elapsed_s, *stated))

    @property
    def elapsed_s(self) -> float:
        """Time since the clock started [s]."""
        if self.began is None:
            return 0.0
        return (time.monotonic() if self.ended is None else self.ended) - self.began

    def look(self) -> Look:
        """Progress of the run."""
        points = tuple(self.points)
        last = points[-1] if points else (0.0, -math.inf, math.inf)
        return Look(
            self.number, self.phase, self.stop.is_set, self.order.time_limit_s, self.elapsed_s,
            self.built, last[1], last[2], points, self.said,
        )  # fmt: skip

    def _begin(self) -> None:
        if self.began is None:
            self.began = time.monotonic()


class PlannedRun(Protocol):
    """The part of a result that is kept of a run."""

    @property
    def plan(self) -> Plan | None:
        """The plan; None if there is none."""
        ...

    @property
    def status(self) -> str:
        """What is proven of it."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks of the method."""
        ...


Done = Callable[[Instance, PlannedRun], str]
"""Handles a result; returns a message about it."""


class Work:
    """Plans one instance after another.

    Parameters
    ----------
    done : callable
        Called with each instance and its result, in the thread of the run, before that is over.
    prepared : Event, optional
        Set when kernels are loaded; runs wait for it, as their clock stands still meanwhile.
    """

    def __init__(self, done: Done, prepared: threading.Event | None = None) -> None:
        self._done, self._prepared = done, prepared
        self._reused = Reused()
        self._lock = threading.Lock()
        self._run: _Run | None = None
        self._count = 0

    def look(self) -> Look:
        """Progress of the last run."""
        run = self._run
        return Look() if run is None else run.look()

    def begin(self, instance: Instance, order: PlanningOrder, known: Plan | None) -> int:
        """Plan, stopping any run in progress; returns the number of the run.

        Parameters
        ----------
        instance : Instance
        order : PlanningOrder
        known : Plan, optional
            To begin from, be it of a variant of the instance.

        Raises
        ------
        InputError
            The order is not valid; what runs goes on.
        """
        order.check()
        with self._lock:
            before = self._run
            if before is not None:
                before.stop.interrupt()
            self._count += 1
            run = self._run = _Run(self._count, order)
        threading.Thread(
            target=self._plan, args=(run, before, instance, known), name="planning", daemon=True
        ).start()
        return run.number

    def stop(self) -> None:
        """Ask the run for its best plan."""
        run = self._run
        if run is not None:
            run.stop.interrupt()

    def wait(self, seconds: float) -> bool:
        """Wait until nothing runs; returns whether that is the case."""
        run = self._run
        return run is None or run.over.wait(seconds)

    def prepare(self, *, drifts: bool) -> None:
        """Load what is needed: nothing, as the first run does so itself."""

    def close(self) -> None:
        """End what plans: nothing, as a thread that is done has ended."""

    def _plan(self, run: _Run, before: _Run | None, instance: Instance, known: Plan | None) -> None:
        try:
            if before is not None:
                before.over.wait()
            if run.stop.is_set:
                run.said = "stopped before it began"
            else:
                run.phase = "compiling"
                if self._prepared is not None:
                    self._prepared.wait()
                result = self._result(run, instance, known)
                run.settle(result)
                run.said = self._done(instance, result)
            run.phase = "done"
        except InputError as error:
            run.said, run.phase = str(error), "failed"
        except Exception as error:  # to be reported on the page
            run.said = f"{run.order.method} failed: {type(error).__name__}: {error}"
            run.phase = "failed"
        finally:
            run.ended = time.monotonic()
            run.over.set()

    def _result(self, run: _Run, instance: Instance, known: Plan | None) -> Result:
        order = run.order
        problem = self._reused.problem(instance)
        start: Any = None
        if order.goes_on and known is not None and spec_of(order.method).starts:
            names = set(instance.names)
            routes = [
                tuple(name for name in route if name in names)
                for route in start_destinations(problem, known, repair=True)
            ]
            if any(routes):
                start = routes if len(problem.missions) > 1 else routes[0]
        wanted = front.RunOptions(
            order.time_limit_s, order.seed, start, repair=start is not None, bound=order.bound
        )
        return front.run(
            PLANNERS, problem, order.method, wanted, stop=run.stop, progress=run,
            building=run.building,
        )  # fmt: skip
