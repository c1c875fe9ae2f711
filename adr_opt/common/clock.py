"""The clock of time limits, which stands still while kernels are compiled, loaded or cached."""

from __future__ import annotations

import time
from collections.abc import Callable

_pauses: list[Callable[[], float]] = []

_seconds: Callable[[], float] = time.perf_counter


def leave_out(seconds: Callable[[], float]) -> None:
    """Exclude a part of this process's running time from the clock.

    Parameters
    ----------
    seconds : callable
        The time spent so far that does not count [s].
    """
    if _seconds is time.perf_counter:
        _pauses.append(seconds)


def count_processor_time() -> None:
    """From now on, count the processor time of all threads of this process instead of elapsed time.

    Meant for single-threaded benchmarks on a busy machine. Nothing is excluded any more, not even
    compilation; two threads use up a limit in half its time; and the switch cannot be undone.
    """
    global _seconds
    _pauses.clear()
    _seconds = time.process_time


def now_s() -> float:
    """Counted seconds since an arbitrary moment; only differences are meaningful."""
    return _seconds() - sum(seconds() for seconds in _pauses)
