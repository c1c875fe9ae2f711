"""What transfers cost beyond the model, as refined legs have shown (MODEL section 10)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from .kernels.connections import Found

Kind = Literal["short", "drift"]

ADJECTIVES: dict[Kind, str] = {"short": "short", "drift": "drifting"}


@dataclass(frozen=True)
class Corrections:
    """What the connections of a mission cost beyond the model; nothing by default.

    A connection costs the factor of its kind times the model's ΔV, and the excess of its pair.

    Attributes
    ----------
    excess_m_s : mapping of (origin, destination, kind) to float
        What connections of a pair cost more than that, by the names of the bodies [m/s]; not
        negative, and +inf for those that nobody shall fly.
    factors : mapping of kind to float
        Positive; 1 by default. Below 1, plans may break the tank that the model has.
    """

    excess_m_s: Mapping[tuple[str, str, Kind], float] = field(default_factory=dict)
    factors: Mapping[Kind, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not all(extra >= 0.0 for extra in self.excess_m_s.values()):
            raise ValueError("excess_m_s: must not be negative, or a transfer may cost nothing")
        if not all(0.0 < factor < math.inf for factor in self.factors.values()):
            raise ValueError("factors: must be positive and finite")

    def __bool__(self) -> bool:
        """Whether they change anything."""
        return any(self.excess_m_s.values()) or any(one != 1.0 for one in self.factors.values())

    def applied(self, origin: str, destination: str, found: Found) -> Found:
        """The connections of a pair at their corrected ΔV, without those nobody shall fly."""
        if not self:
            return found
        delta_v = np.empty(found.delta_v.size)
        drifts = found.revolutions < 0
        for kind in ADJECTIVES:
            mine = drifts if kind == "drift" else ~drifts
            share, extra = self._line(origin, destination, kind)
            delta_v[mine] = share * found.delta_v[mine] + extra
        if np.isfinite(delta_v).all():
            return found._replace(delta_v=delta_v)
        flyable = np.isfinite(delta_v)
        return Found(*(column[flyable] for column in found._replace(delta_v=delta_v)))

    def modelled(self, origin: str, destination: str, kind: Kind, delta_v_m_s: float) -> float:
        """What a connection of a corrected ΔV costs by the model [m/s]."""
        share, extra = self._line(origin, destination, kind)
        return (delta_v_m_s - extra) / share

    def _line(self, origin: str, destination: str, kind: Kind) -> tuple[float, float]:
        """What the model's ΔV is multiplied by, and what is added [m/s]."""
        return self.factors.get(kind, 1.0), self.excess_m_s.get((origin, destination, kind), 0.0)

    def __str__(self) -> str:
        known = [extra for extra in self.excess_m_s.values() if 0.0 < extra < math.inf]
        barred = sum(extra == math.inf for extra in self.excess_m_s.values())
        parts = [
            f"the ΔV of {ADJECTIVES[kind]} transfers times {factor:.4g}"
            for kind, factor in self.factors.items()
            if factor != 1.0
        ]
        if known:
            parts.append(f"up to {max(known):.1f} m/s more between {len(known)} pairs of bodies")
        if barred:
            parts.append(f"no transfer between {barred} pairs that no trajectory was found for")
        return ", ".join(parts) or "none"


NO_CORRECTIONS = Corrections()
