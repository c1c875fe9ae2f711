"""Stop when someone outside says so."""

from __future__ import annotations

import math


class Interrupted:
    """Enough once :meth:`interrupt` was called: by a signal handler, or by another thread."""

    def __init__(self) -> None:
        self.is_set = False

    def interrupt(self) -> None:
        """Ask the planner to return its best plan at the next opportunity."""
        self.is_set = True

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether it is enough."""
        return self.is_set

    def remaining_s(self) -> float:
        """Seconds that may still be used."""
        return 0.0 if self.is_set else math.inf
