"""Stop at the first of several reasons."""

from __future__ import annotations

import math

from .criterion import Stop


class AnyOf:
    """Stops as soon as one of its criteria does; every criterion is asked every time."""

    def __init__(self, *criteria: Stop) -> None:
        self._criteria = criteria

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return any([criterion(incumbent, bound) for criterion in self._criteria])

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return min((criterion.remaining_s() for criterion in self._criteria), default=math.inf)
