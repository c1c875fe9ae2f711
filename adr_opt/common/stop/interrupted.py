"""Stop on request."""

from __future__ import annotations

import math


class Interrupted:
    """Stops once :meth:`interrupt` has been called, by a signal handler or another thread."""

    def __init__(self) -> None:
        self.is_set = False

    def interrupt(self) -> None:
        """Ask the planner to return its best plan at the next opportunity."""
        self.is_set = True

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self.is_set

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return 0.0 if self.is_set else math.inf
