"""The clock of planners and limits."""

from __future__ import annotations

import time

import pytest

from adr_opt.common import clock


def test_processor_time_stands_still_while_others_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that sleeps uses none, and one that works does; pauses count no more."""
    monkeypatch.setattr(clock, "_seconds", clock._seconds)
    monkeypatch.setattr(clock, "_pauses", [lambda: time.perf_counter()])
    clock.count_processor_time()
    began = clock.now_s()
    time.sleep(0.2)
    assert 0.0 <= clock.now_s() - began < 0.1
    until = time.process_time() + 0.02
    while time.process_time() < until:
        pass
    assert clock.now_s() - began >= 0.02
