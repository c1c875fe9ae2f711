"""Tell a kernel under way that the time is over."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt

from adr_opt.stop import Stop

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
