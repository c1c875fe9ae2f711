"""Time limits: every method asks often whether it is over, and trims by work, not by the clock."""

from __future__ import annotations

import itertools
import math
import sys
import threading
import time
from types import FrameType

import pytest
from fields import on_rows

import adr_opt
from adr_opt.common import clock
from adr_opt.common.stop import MaxRuntime
from adr_opt.legs import timetable_size
from adr_opt.mission.problem import Problem
from adr_opt.problem.instance import Instance
from adr_opt.problem.support import follows_all
from adr_opt.run.methods import PLANNERS, names, spec

MOST_CALLS = 60_000
"""Most calls of functions between two questions whether the time is over."""

TARGETS = 40


class Asked:
    """Never ends, and notes the most calls of functions between two questions.

    Calls are the measure of work, whatever they take; a kernel is one call.
    """

    def __init__(self) -> None:
        self._made, self._last, self.most = itertools.count(), 0, 0

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self.remaining_s() <= 0.0

    def count(self, frame: FrameType, event: str, of: object) -> None:
        """Count a call, as a profiler of Python."""
        if event == "call":
            next(self._made)

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        made = next(self._made)
        self.most, self._last = max(self.most, made - self._last), made
        return math.inf


FIELDS = {
    "rows": lambda targets: on_rows(targets, near=39),
    "orbits": lambda targets: adr_opt.generate("nominal", 0, targets=targets),
}


@pytest.mark.parametrize(
    "method",
    [
        pytest.param(name, marks=() if name in ("auto", "greedy") else pytest.mark.slow)
        for name in names(PLANNERS)
    ],
)
@pytest.mark.parametrize("kind", FIELDS)
def test_every_method_asks_often(kind, method):
    """No phase of any method, nor what comes before and after it, runs long without asking."""
    field = FIELDS[kind]
    if not follows_all(field(4), spec(method).follows):
        pytest.skip("the method does not follow its rules")
    for asked in (Asked(), Asked()):  # the first time kernels are loaded
        threading.setprofile(asked.count)
        sys.setprofile(asked.count)
        try:
            adr_opt.solve(field(TARGETS), method, time_limit=60.0, iterations=1, stop=asked)
        finally:
            sys.setprofile(None)
            threading.setprofile(None)
        asked.remaining_s()
    assert asked.most < MOST_CALLS


def _trimmed(instance: Instance, limit_s: float) -> tuple[int, tuple[str, ...]]:
    """Number of pairs and order of a plan on a trimmed table."""
    problem = Problem(instance)
    result = adr_opt.solve(problem, "greedy", time_limit=limit_s)
    timetable = problem.missions[0].timetable
    assert not timetable.is_whole
    return timetable.built, result.destinations


def test_a_trimmed_table_depends_on_no_clock(monkeypatch):
    """A plan on a part of the timetable is the same where the clock runs three times as fast."""
    instance = adr_opt.generate("nominal", 0, targets=40)
    # As if each event were so much work that a third of the limit were not enough for all.
    monkeypatch.setattr(timetable_size.Size, "pair_s", property(lambda size: 0.05))
    usual = _trimmed(instance, 30.0)
    monkeypatch.setattr(clock, "_seconds", lambda: 3.0 * time.perf_counter())
    assert _trimmed(instance, 30.0) == usual
    assert usual[1]
    assert MaxRuntime(1.0).remaining_s() <= 1.0
