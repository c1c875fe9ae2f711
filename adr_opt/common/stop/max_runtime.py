"""Stop after a given time."""

from __future__ import annotations

import math

from ..clock import now_s
from ..errors import InputError


class MaxRuntime:
    """Stops after a number of seconds, counted from its construction.

    Raises
    ------
    InputError
        The limit is not positive.
    """

    def __init__(self, limit_s: float) -> None:
        if not limit_s > 0.0 or math.isnan(limit_s):
            raise InputError(f"time limit = {limit_s:g}: must be positive, in seconds")
        self._end = now_s() + limit_s

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self.remaining_s() <= 0.0

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return self._end - now_s()
