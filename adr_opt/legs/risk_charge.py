"""What legs are charged for costing more than planned, so that tanks keep a reserve for it.

A tank of ΔV B keeps a plan at a normal score z if the legs between two fillings, of mean cost a_k
and variance v_k, leave

    Σ a_k + z √(Σ v_k) ≤ B                                                              (13.1)

A single leg does not know the others. It is charged as if the whole tank were flown in legs of its
kind: with ρ the reserve of such a tank, ρ² = z² (v / a) (B − ρ), it takes the share a / (B − ρ) of
the tank. Legs that keep (13.1) are charged no more than the tank, whatever their sizes, and legs of
one size exactly what (13.1) says: for every ρ > 0

    z √V ≤ z² V / (2 ρ) + ρ / 2 ,   with equality at ρ = z √V ,

so (13.1) says that Σ (a_k + z² v_k / 2ρ) / (B − ρ / 2) ≤ 1 for some ρ, and the charge is the least
of such a term over all ρ. What is proven with charges is therefore proven of (13.1). See
docs/model.md section 13.4.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np


class Moments(NamedTuple):
    """Mean and standard deviation of a factor."""

    mean: float
    sigma: float


CERTAIN = Moments(1.0, 0.0)


@dataclass(frozen=True)
class RiskCharge:
    """Charges on legs for what they may cost more.

    Attributes
    ----------
    score : float
        Standard deviations that a tank keeps in reserve, z; not negative.
    tank_m_s : float
        ΔV of the largest tank [m/s]. A charge by a larger tank is smaller, so that what is proven
        holds for smaller ones, too.
    usable : Moments
        Of the share of a full tank that can be used.
    factors : mapping of (destination, kind of leg) to Moments
        Of the factors on the ΔV of legs; certain by default.
    """

    score: float
    tank_m_s: float
    usable: Moments = CERTAIN
    factors: Mapping[tuple[str, str], Moments] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """Whether any leg is charged other than what it is planned to take."""
        return bool(self.factors) or self.usable != CERTAIN

    def charged(self, destination: str, kind: str, delta_v_m_s: Any) -> Any:
        """ΔV that legs are charged, from what they are planned to take [m/s]."""
        mean, sigma = self.factors.get((destination, kind), CERTAIN)
        full, least = self._usable_m_s, self._square_of_reserve
        legs = (self.score * sigma) ** 2 / mean * delta_v_m_s
        half = 0.5 * legs
        square = least + legs * full
        reserve = square / (half + np.sqrt(half * half + square) + _NOTHING)
        return self.tank_m_s * mean * delta_v_m_s / (full - reserve)

    def planned(self, destination: str, kind: str, charged_m_s: Any) -> Any:
        """ΔV that legs are planned to take, from what they are charged [m/s]."""
        mean, sigma = self.factors.get((destination, kind), CERTAIN)
        full, least = self._usable_m_s, self._square_of_reserve
        share = charged_m_s / self.tank_m_s
        legs = (self.score * sigma / mean) ** 2 * share
        along, square = legs * full, least + legs * full * full
        # (1 − g) ρ² + 2 g B ρ = u + g B²: ρ² = u + g (B − ρ)²
        reserve = square / (along + np.sqrt(along * along + (1.0 - legs) * square) + _NOTHING)
        return share * (full - reserve) / mean

    @property
    def _usable_m_s(self) -> float:
        """Mean ΔV of a full tank [m/s]."""
        return self.usable.mean * self.tank_m_s

    @property
    def _square_of_reserve(self) -> float:
        """Square of the reserve of a full tank that flies no leg."""
        return (self.score * self.usable.sigma * self.tank_m_s) ** 2


_NOTHING = 1e-300
"""Added to a denominator that is 0 where nothing is uncertain."""
