"""What refined legs teach about all connections: corrections of the model."""

from __future__ import annotations

import math

from ..corrections import ADJECTIVES, Corrections, Kind
from ..plan import Plan
from .all_legs import INTERRUPTED
from .plan import RefinedPlan

Key = tuple[str, str, Kind]


class Lessons:
    """What the legs refined so far cost beyond their plans.

    All connections are multiplied by what legs of their kind cost in the mean, against what was
    planned. To those of a pair is added what its dearest leg cost beyond that; they are left out if
    no trajectory was found. Factors never fall after the first lesson, so that a plan costs at
    least what its legs were flown with from then on.

    Parameters
    ----------
    spend_savings : bool
        Whether factors may be below 1. Where flown legs save ΔV they do so by burns that the model
        does not know; a plan that counts on it may be one that ``check`` refuses.
    """

    def __init__(self, spend_savings: bool = False) -> None:
        self._least = 0.0 if spend_savings else 1.0
        self._legs: dict[Key, list[tuple[float, float]]] = {}
        self._factors: dict[Kind, float] = {}

    def learn(self, plan: Plan, refined: RefinedPlan) -> None:
        """Hear what the legs of a plan cost as they were refined."""
        for leg in refined.legs:
            key = leg.origin, leg.destination, leg.kind
            costs = leg.planned_delta_v_m_s, leg.flown_delta_v_m_s
            self._legs.setdefault(key, []).append(costs)
        for missing in refined.missing:
            if missing.reason != INTERRUPTED:
                lost = plan.legs[missing.leg - 1]
                key = lost.origin, lost.destination, lost.kind
                self._legs.setdefault(key, []).append((0.0, math.inf))
        for kind in ADJECTIVES:
            legs = [cost for key, costs in self._legs.items() if key[2] == kind for cost in costs]
            planned = math.fsum(cost[0] for cost in legs)
            flown = math.fsum(cost[1] for cost in legs if math.isfinite(cost[1]))
            if planned > 0.0 and flown > 0.0:
                least = self._factors.get(kind, self._least)
                self._factors[kind] = max(least, flown / planned)

    @property
    def corrections(self) -> Corrections:
        """What they come to."""
        excess = {
            key: max(0.0, *(flown - self._factors.get(key[2], 1.0) * p for p, flown in costs))
            for key, costs in self._legs.items()
        }
        return Corrections(excess, dict(self._factors))
