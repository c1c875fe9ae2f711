"""Stop when the incumbent no longer improves."""

from __future__ import annotations

import math

from ..errors import InputError


class NoImprovement:
    """Stops once it has been asked ``limit`` times in a row without a better incumbent."""

    def __init__(self, limit: int) -> None:
        if limit <= 0:
            raise InputError(f"iterations without improvement = {limit}: must be positive")
        self._limit = limit
        self._best = -math.inf
        self._stale = 0

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        if incumbent > self._best:
            self._best = incumbent
            self._stale = 0
        else:
            self._stale += 1
        return self._stale >= self._limit

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return math.inf
