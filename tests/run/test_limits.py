"""Time limits: every method asks often whether it is over, and trims by work, not by the clock."""

from __future__ import annotations

import time

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

MOST_S = 0.8
"""Most processor time between two questions whether the time is over [s]."""

LIMIT_S = 0.25


def _spent_s() -> float:
    """Processor time of this process, without what compiling and loading of kernels takes [s]."""
    return time.process_time() - sum(seconds() for seconds in clock._pauses)


class Asked:
    """Ends after some processor time, and notes the most between two questions."""

    def __init__(self) -> None:
        self._last = _spent_s()
        self._end, self.longest_s = self._last + LIMIT_S, 0.0

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self.remaining_s() <= 0.0

    def remaining_s(self) -> float:
        """Remaining processor time [s]."""
        now = _spent_s()
        self.longest_s = max(self.longest_s, now - self._last)
        self._last = now
        return self._end - now


FIELDS = {
    "rows": lambda targets: on_rows(targets, near=20),
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
    for targets in (40, 300):  # the first loads kernels
        instance, asked = field(targets), Asked()
        adr_opt.solve(instance, method, time_limit=60.0, stop=asked)
        asked.remaining_s()
    assert asked.longest_s < MOST_S


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
