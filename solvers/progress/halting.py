"""Tell parts of a search that the time is over: kernels under way, and those that get a share."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt

from adr_opt.common.stop import Stop

POLL_S = 0.02
"""How often a search under way asks whether the time is over."""


@contextmanager
def halted_by(stop: Stop | None) -> Iterator[npt.NDArray[np.bool_]]:
    """A flag that is set, from a thread beside the kernel, when ``stop`` has no time left."""
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
    """A share of the time that a criterion has left now; the criterion itself is not asked."""

    def __init__(self, stop: Stop, share: float) -> None:
        remaining_s = stop.remaining_s()
        self._stop = stop
        self._left_s = remaining_s - share * remaining_s if math.isfinite(remaining_s) else 0.0

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether it is enough."""
        return self.remaining_s() <= 0.0

    def remaining_s(self) -> float:
        """Seconds that may still be used."""
        return self._stop.remaining_s() - self._left_s
