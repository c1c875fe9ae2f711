"""Stop after a given amount of work, which is reproducible."""

from __future__ import annotations

import math

from ..errors import InputError


class MaxIterations:
    """Stops once it has been asked more than ``limit`` times."""

    def __init__(self, limit: int) -> None:
        if limit <= 0:
            raise InputError(f"iterations = {limit}: must be positive")
        self._left = limit

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        self._left -= 1
        return self._left < 0

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return math.inf
