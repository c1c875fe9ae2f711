"""Stopping criteria and their clock: each says enough when it should, and not before."""

from __future__ import annotations

import math
import threading
import time

import pytest

from adr_opt.common import clock
from adr_opt.common.errors import InputError
from adr_opt.common.stop import AnyOf, Interrupted, MaxIterations, MaxRuntime, NoImprovement, Proven

NOTHING = (-math.inf, math.inf)


def test_max_iterations() -> None:
    """As many iterations as allowed, then enough for ever."""
    stop = MaxIterations(3)
    assert [stop(*NOTHING) for _ in range(5)] == [False, False, False, True, True]
    assert stop.remaining_s() == math.inf


@pytest.mark.parametrize("limit", [0, -1])
@pytest.mark.parametrize(
    ("stop", "said"), [(MaxIterations, "iterations"), (NoImprovement, "without improvement")]
)
def test_numbers_must_be_positive(stop: type, said: str, limit: int) -> None:
    """No iterations and no patience at all are refused, and the sentence says the number."""
    with pytest.raises(InputError, match=f"{said} = {limit}: must be positive"):
        stop(limit)


def test_max_runtime(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not enough before the limit, enough after it, counted from the making of the criterion."""
    now = 1000.0
    monkeypatch.setattr("adr_opt.common.stop.now_s", lambda: now)
    stop = MaxRuntime(0.25)
    assert not stop(*NOTHING)
    assert stop.remaining_s() == 0.25
    now += 0.25
    assert stop(*NOTHING)
    assert stop.remaining_s() == 0.0


def test_max_runtime_without_end() -> None:
    """An infinite limit never ends anything."""
    stop = MaxRuntime(math.inf)
    assert not stop(*NOTHING)
    assert stop.remaining_s() == math.inf


@pytest.mark.parametrize("limit", [0.0, -1.0, math.nan, -math.inf])
def test_max_runtime_must_be_positive(limit: float) -> None:
    """A limit that is not a positive time is refused."""
    with pytest.raises(InputError, match=r"time limit = .*: must be positive, in seconds"):
        MaxRuntime(limit)


def test_no_improvement() -> None:
    """Enough after so many questions in a row without a better incumbent; a better one resets."""
    stop = NoImprovement(2)
    incumbents = [-math.inf, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0]
    said = [stop(incumbent, math.inf) for incumbent in incumbents]
    assert said == [False, False, False, False, False, True, False]


def test_no_improvement_looks_at_the_incumbent_alone() -> None:
    """A better bound is no improvement."""
    stop = NoImprovement(2)
    assert [stop(1.0, bound) for bound in (9.0, 8.0, 7.0)] == [False, False, True]
    assert stop.remaining_s() == math.inf


@pytest.mark.parametrize(
    ("incumbent", "bound", "enough"),
    [
        (-math.inf, math.inf, False),
        (-math.inf, 5.0, False),
        (4.0, math.inf, False),
        (4.0, 5.0, False),
        (5.0, 5.0, True),
        (5.0 - 1e-15, 5.0, True),
        (5.0 - 1e-12, 5.0, False),
        (4.999, 5.0, False),
        (1e12 - 1.0, 1e12, False),
        (0.0, 0.0, True),
    ],
)
def test_proven(incumbent: float, bound: float, enough: bool) -> None:
    """Enough exactly when the incumbent meets the bound up to the rounding of sums."""
    assert Proven()(incumbent, bound) is enough
    assert Proven().remaining_s() == math.inf


def test_interrupted() -> None:
    """Not enough until someone says so, from any thread; no time is left then."""
    stop = Interrupted()
    assert not stop(*NOTHING)
    assert stop.remaining_s() == math.inf
    other = threading.Thread(target=stop.interrupt)
    other.start()
    other.join()
    assert stop(*NOTHING)
    assert stop.remaining_s() == 0.0


def test_any_of_is_the_first_of_all() -> None:
    """Enough as soon as one criterion says so, and the least time of all remains."""
    stop = AnyOf(MaxIterations(5), NoImprovement(2), MaxRuntime(100.0))
    assert [stop(1.0, math.inf) for _ in range(3)] == [False, False, True]
    assert 99.0 < stop.remaining_s() <= 100.0


def test_any_of_asks_all_every_time() -> None:
    """A criterion that counts hears of every iteration, whatever the others said."""
    counting, interrupted = MaxIterations(2), Interrupted()
    interrupted.interrupt()
    stop = AnyOf(interrupted, counting)
    assert stop(*NOTHING)
    assert stop(*NOTHING)
    assert counting(*NOTHING)


def test_any_of_nothing_never_ends() -> None:
    """Without criteria there is no reason to stop."""
    assert not AnyOf()(*NOTHING)
    assert AnyOf().remaining_s() == math.inf


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
