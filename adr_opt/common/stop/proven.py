"""Stop when the incumbent is proven optimal."""

from __future__ import annotations

import math

from ..tolerance import meets


class Proven:
    """Enough once the incumbent meets the bound."""

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether it is enough."""
        return meets(incumbent, bound)

    def remaining_s(self) -> float:
        """Seconds that may still be used."""
        return math.inf
