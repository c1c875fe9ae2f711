"""Stop after some work, the reproducible kind of limit."""

from __future__ import annotations

import math

from ..errors import InputError


class MaxIterations:
    """Enough once it has been asked more than ``limit`` times."""

    def __init__(self, limit: int) -> None:
        if limit <= 0:
            raise InputError(f"iterations = {limit}: must be positive")
        self._left = limit

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether it is enough."""
        self._left -= 1
        return self._left < 0

    def remaining_s(self) -> float:
        """Seconds that may still be used."""
        return math.inf
