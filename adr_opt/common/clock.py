"""The clock of planners and limits, which stands still while kernels are compiled, read or kept."""

from __future__ import annotations

import time
from collections.abc import Callable

_pauses: list[Callable[[], float]] = []


def leave_out(seconds: Callable[[], float]) -> None:
    """Exclude some time of this process.

    Parameters
    ----------
    seconds : callable
        The time spent so far that does not count [s].
    """
    _pauses.append(seconds)


def now_s() -> float:
    """Counted seconds since an arbitrary moment; only differences are meaningful."""
    return time.perf_counter() - sum(seconds() for seconds in _pauses)
