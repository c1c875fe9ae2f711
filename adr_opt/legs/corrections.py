"""Corrections to the modelled costs of transfers and times of services.

Learned from refined legs (docs/model.md section 10), or drawn; or a charge for costing more than
planned, so that tanks keep a reserve for it:

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

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ..common.constants import DAY_S
from ..common.wording import counted
from ..kernels.legs.found import ConnectionArrays
from ..plan.leg_kinds import leg_kinds


class Moments(NamedTuple):
    """Mean and standard deviation of a factor."""

    mean: float
    sigma: float


CERTAIN = Moments(1.0, 0.0)


@dataclass(frozen=True)
class RiskCharge:
    """Charges on legs for the risk that they cost more than planned.

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
        """Whether the charge of any leg differs from its planned ΔV."""
        return bool(self.factors) or self.usable != CERTAIN

    def charged(self, destination: str, kind: str, delta_v_m_s: Any) -> Any:
        """ΔV charged for legs, from their planned ΔV [m/s]."""
        mean, sigma = self.factors.get((destination, kind), CERTAIN)
        full, least = self._usable_m_s, self._square_of_reserve
        legs = (self.score * sigma) ** 2 / mean * delta_v_m_s
        half = 0.5 * legs
        square = least + legs * full
        reserve = square / (half + np.sqrt(half * half + square) + _NOTHING)
        return self.tank_m_s * mean * delta_v_m_s / (full - reserve)

    def planned(self, destination: str, kind: str, charged_m_s: Any) -> Any:
        """Planned ΔV of legs, from the ΔV that they are charged [m/s]."""
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
"""Guard of a denominator that is 0 where nothing is uncertain."""


Key = tuple[str, str, str]
"""Origin, destination and kind of legs."""

Span = tuple[float, float]

WITHIN_S = 1e-3
"""Tolerance on barred times [s]."""


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
            parts.append(f"no transfer within {counted(lost, 'time')} when none can be flown")
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
