"""Stop when the incumbent is proven optimal."""

from __future__ import annotations

import math

from ..tolerance import meets


class Proven:
    """Stops once the incumbent meets the bound."""

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return meets(incumbent, bound)

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return math.inf
