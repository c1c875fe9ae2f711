"""The clock of planners and limits, which stands still while kernels are compiled, read or kept."""

from __future__ import annotations

import time
from collections.abc import Callable

_pauses: list[Callable[[], float]] = []

_seconds: Callable[[], float] = time.perf_counter


def leave_out(seconds: Callable[[], float]) -> None:
    """Exclude some time of this process.

    Parameters
    ----------
    seconds : callable
        The time spent so far that does not count [s].
    """
    if _seconds is time.perf_counter:
        _pauses.append(seconds)


def count_processor_time() -> None:
    """Count the processor time of all threads of this process from now on, whatever else runs.

    Meant for benchmarks of one thread on a busy machine. Nothing is left out any more, compiling
    of kernels neither, two threads use up a limit in half its time, and it cannot be undone.
    """
    global _seconds
    _pauses.clear()
    _seconds = time.process_time


def now_s() -> float:
    """Counted seconds since an arbitrary moment; only differences are meaningful."""
    return _seconds() - sum(seconds() for seconds in _pauses)
