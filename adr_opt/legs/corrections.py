"""Corrections to the modelled costs of transfers and times of services.

Learned from refined legs (docs/model.md section 10), or drawn.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..common.constants import DAY_S
from ..common.wording import counted
from ..kernels.legs.found import ConnectionArrays
from ..plan.leg_kinds import leg_kinds
from .risk_charge import RiskCharge

Key = tuple[str, str, str]
"""Origin, destination and kind of legs."""

Span = tuple[float, float]

WITHIN_S = 1e-3
"""Tolerance of times that are barred [s]."""


@dataclass(frozen=True)
class Corrections:
    """Corrections to the costs of a mission's connections; none by default.

    A connection costs the factor of its kind times the model's ΔV, plus the addition of its kind,
    and all that times the share of its pair; and that is charged for what it may cost more.

    Attributes
    ----------
    shares : mapping of (origin, destination, kind) to float
        What connections of a pair cost against others of their kind, by the names of the bodies;
        positive, 1 by default, and +inf for connections that must not be flown.
    factors : mapping of kind to float
        Positive; 1 by default.
    additions_m_s : mapping of kind to float
        Not negative; 0 by default [m/s].
    barred_s : mapping of (origin, destination, kind) to tuple of (float, float)
        Times between which no connection of a pair may leave and arrive [s].
    stays_s : mapping of name to float
        Time by which a chaser stays longer with an object that it tows; positive [s].
    services_s : mapping of name to float
        What the service of a target takes in place of the time of the mission; not negative [s].
        Windows move with it: they limit when services begin, as without the correction.
    charge : RiskCharge or None
        On all legs, for what they may cost more.
    """

    shares: Mapping[Key, float] = field(default_factory=dict)
    factors: Mapping[str, float] = field(default_factory=dict)
    additions_m_s: Mapping[str, float] = field(default_factory=dict)
    barred_s: Mapping[Key, tuple[Span, ...]] = field(default_factory=dict)
    stays_s: Mapping[str, float] = field(default_factory=dict)
    services_s: Mapping[str, float] = field(default_factory=dict)
    charge: RiskCharge | None = None

    def __post_init__(self) -> None:
        if not all(share > 0.0 for share in self.shares.values()):
            raise ValueError("shares: must be positive, so that no transfer is free")
        if not all(0.0 < factor < math.inf for factor in self.factors.values()):
            raise ValueError("factors: must be positive and finite")
        if not all(0.0 <= addition < math.inf for addition in self.additions_m_s.values()):
            raise ValueError("additions_m_s: must be finite and not negative")
        if not all(0.0 < stay < math.inf for stay in self.stays_s.values()):
            raise ValueError("stays_s: must be positive and finite")
        if not all(0.0 <= service < math.inf for service in self.services_s.values()):
            raise ValueError("services_s: must be finite and not negative")

    def __bool__(self) -> bool:
        """Whether there are any corrections."""
        factors = (*self.shares.values(), *self.factors.values())
        changed = any(one != 1.0 for one in factors) or any(self.additions_m_s.values())
        return changed or bool(self.barred_s or self.stays_s or self.services_s or self.charge)

    def applied(self, origin: str, destination: str, found: ConnectionArrays) -> ConnectionArrays:
        """The connections of a pair at corrected ΔV, without excluded ones."""
        if not self:
            return found
        delta_v = np.empty(found.delta_v.size)
        for number, kind in enumerate(leg_kinds()):
            mine = found.family == number
            factor, addition = self._line(origin, destination, kind.name)
            delta_v[mine] = factor * found.delta_v[mine] + addition
            if self.charge and mine.any():
                delta_v[mine] = self.charge.charged(destination, kind.name, delta_v[mine])
            for begin, end in self.barred_s.get((origin, destination, kind.name), ()):
                within = (found.departure > begin - WITHIN_S) & (found.arrival < end + WITHIN_S)
                delta_v[mine & within] = math.inf
        if np.isfinite(delta_v).all():
            return found._replace(delta_v=delta_v)
        flyable = np.isfinite(delta_v)
        return ConnectionArrays(*(column[flyable] for column in found._replace(delta_v=delta_v)))

    def corrected(self, origin: str, destination: str, kind: str, delta_v_m_s: float) -> float:
        """Corrected ΔV of a connection, from its modelled ΔV [m/s]."""
        factor, addition = self._line(origin, destination, kind)
        costs = factor * delta_v_m_s + addition
        return float(self.charge.charged(destination, kind, costs)) if self.charge else costs

    def modelled(self, origin: str, destination: str, kind: str, delta_v_m_s: float) -> float:
        """Modelled ΔV of a connection, from its corrected ΔV [m/s]."""
        factor, addition = self._line(origin, destination, kind)
        if self.charge:
            delta_v_m_s = float(self.charge.planned(destination, kind, delta_v_m_s))
        return (delta_v_m_s - addition) / factor

    def of_kind(self, kind: str) -> tuple[float, float]:
        """Factor and offset [m/s] applied to the modelled ΔV of any pair, by kind of leg."""
        return self.factors.get(kind, 1.0), self.additions_m_s.get(kind, 0.0)

    def _line(self, origin: str, destination: str, kind: str) -> tuple[float, float]:
        """Factor and offset of a pair, its own if known."""
        factor, addition = self.of_kind(kind)
        share = self.shares.get((origin, destination, kind), 1.0)
        # Without an addition an infinite share would make it no number.
        return share * factor, share * addition if addition else 0.0

    def __str__(self) -> str:
        parts = []
        for kind in leg_kinds():
            factor, addition = self.of_kind(kind.name)
            if factor != 1.0:
                parts.append(f"the ΔV of {kind.adjective} transfers times {factor:.4g}")
            if addition:
                parts.append(f"{addition:.1f} m/s more for {kind.adjective} transfers")
        known = [one for one in self.shares.values() if one not in (1.0, math.inf)]
        barred = sum(one == math.inf for one in self.shares.values())
        lost = sum(map(len, self.barred_s.values()))
        if known:
            span = f"{min(known):.3g} to {max(known):.3g}"
            parts.append(f"and {span} times as much between {len(known)} pairs of bodies")
        if barred:
            parts.append(f"no transfer between {barred} pairs without a known trajectory")
        if lost:
            parts.append(
                f"no transfer within the times of {counted(lost, 'leg')} not found in them"
            )
        if self.stays_s:
            longest = max(self.stays_s.values()) / DAY_S
            parts.append(
                f"up to {longest:.3g} days more for the tows of "
                f"{counted(len(self.stays_s), 'object')}"
            )
        if self.services_s:
            parts.append(f"other times of {counted(len(self.services_s), 'service')}")
        if self.charge:
            parts.append(f"a reserve of {self.charge.score:.3g} standard deviations in each tank")
        return ", ".join(parts) or "none"


NO_CORRECTIONS = Corrections()
