"""The course of a run: its best plan and bound over time."""

from __future__ import annotations

import math
import threading
from dataclasses import replace

from ..common.clock import now_s
from ..common.progress import Progress, Relayed, silent
from ..mission.result import Result

Point = tuple[float, float, float]
"""Time since the run began [s], incumbent and bound."""

MOST_HEARD = 400
"""Maximum number of points kept while a method runs, first and last ones."""

MOST_WRITTEN = 40
"""Maximum number of points in a plan file."""


class RunCourse(Relayed):
    """A progress callback that keeps when incumbent and bound improved, and passes reports on.

    Parameters
    ----------
    to : Progress, optional
    """

    def __init__(self, to: Progress = silent) -> None:
        super().__init__(to, to)
        self._began, self._lock = now_s(), threading.Lock()
        self.points: list[Point] = []

    def __call__(self, incumbent: float, bound: float) -> None:
        """Receive a report; two methods side by side report from a thread each."""
        self.hear(incumbent, bound)
        super().__call__(incumbent, bound)

    def hear(self, incumbent: float, bound: float) -> None:
        """Keep a report, if it improves on those before it."""
        with self._lock:
            best = max(incumbent, self.last[1]), min(bound, self.last[2])
            if best != self.last[1:]:
                self._add(*best)

    def settle(self, objective: float, bound: float) -> None:
        """Keep the final values, which may be below an earlier incumbent."""
        with self._lock:
            if (objective, bound) != self.last[1:]:
                self._add(objective, bound)

    @property
    def last(self) -> Point:
        """The last point; without incumbent and bound if there is none."""
        return self.points[-1] if self.points else (0.0, -math.inf, math.inf)

    def kept(self, result: Result) -> Result:
        """A result whose plan keeps the course, unless the method reported nothing before its end.

        Where the plan states no bound, as with a margin, its course states none either.
        """
        plan = result.plan
        if plan is None:
            return result
        bounds = plan.upper_bound is not None
        self.settle(plan.objective, math.inf if plan.upper_bound is None else plan.upper_bound)
        course: list[tuple[float, float | None, float | None]] = []
        for at, incumbent, bound in self.points:
            best = incumbent if math.isfinite(incumbent) else None
            known = bound if bounds and math.isfinite(bound) else None
            if (best, known) != (course[-1][1:] if course else (None, None)):
                course.append((round(at, 3), best, known))
        if len(course) < 2:
            return result
        last, most = len(course) - 1, min(len(course), MOST_WRITTEN)
        few = tuple(course[at * last // (most - 1)] for at in range(most))
        return replace(result, plan=plan.replace(course=few))

    def _add(self, incumbent: float, bound: float) -> None:
        if len(self.points) >= MOST_HEARD:
            del self.points[MOST_HEARD // 2]
        self.points.append((now_s() - self._began, incumbent, bound))
