"""Stop when the incumbent is proven optimal."""

from __future__ import annotations

import math

TOLERANCE = 1e-6
"""Relative difference below which an incumbent meets its bound."""


class Proven:
    """Enough once the incumbent meets the bound."""

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether it is enough."""
        return incumbent >= bound - TOLERANCE * max(1.0, abs(bound))

    def remaining_s(self) -> float:
        """Seconds that may still be used."""
        return math.inf
