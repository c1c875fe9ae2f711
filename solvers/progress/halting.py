"""Time limits for parts of a search: running kernels, and shares of time."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt

from adr_opt.common.stop import Stop

POLL_S = 0.02
"""Interval at which a running search checks the time."""


@contextmanager
def halted_by(stop: Stop | None) -> Iterator[npt.NDArray[np.bool_]]:
    """A flag, set by a thread beside the kernel once ``stop`` has no time left."""
    flag = np.zeros(1, dtype=np.bool_)
    if stop is None:
        yield flag
        return
    done = threading.Event()

    def watch() -> None:
        while not flag[0] and not done.wait(POLL_S):
            flag[0] = stop.remaining_s() <= 0.0

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield flag
    finally:
        done.set()
        thread.join()


class ShareOfTime:
    """A share of a criterion's remaining time; the criterion itself is not asked."""

    def __init__(self, stop: Stop, share: float) -> None:
        remaining_s = stop.remaining_s()
        self._stop = stop
        self._left_s = remaining_s - share * remaining_s if math.isfinite(remaining_s) else 0.0

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self.remaining_s() <= 0.0

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return self._stop.remaining_s() - self._left_s
