"""What refined legs teach about all connections: corrections of the model."""

from __future__ import annotations

import math

from ..corrections import Corrections, Kind
from ..plan import Plan
from .all_legs import INTERRUPTED
from .plan import RefinedPlan

Key = tuple[str, str, Kind]


class Lessons:
    """What the legs refined so far cost beyond their plans.

    A pair costs so much more as its dearest leg did, or is left out if no trajectory was found. All
    other connections are multiplied by what legs of their kind cost in the mean, against what was
    planned. Nothing becomes cheaper than the model says: where flown legs save ΔV, they do so by
    burns that the model does not know, at times that it did not choose, and a plan that counts on
    it would be one that ``check`` refuses.
    """

    def __init__(self) -> None:
        self._excess: dict[Key, float] = {}
        self._planned: dict[Kind, float] = {}
        self._flown: dict[Kind, float] = {}

    def learn(self, plan: Plan, refined: RefinedPlan) -> None:
        """Hear what the legs of a plan cost as they were refined."""
        for leg in refined.legs:
            over = leg.flown_delta_v_m_s - leg.planned_delta_v_m_s
            self._raise((leg.origin, leg.destination, leg.kind), over)
            for sums, cost in (
                (self._planned, leg.planned_delta_v_m_s),
                (self._flown, leg.flown_delta_v_m_s),
            ):
                sums[leg.kind] = sums.get(leg.kind, 0.0) + cost
        for missing in refined.missing:
            if missing.reason != INTERRUPTED:
                lost = plan.legs[missing.leg - 1]
                self._raise((lost.origin, lost.destination, lost.kind), math.inf)

    def _raise(self, key: Key, excess_m_s: float) -> None:
        self._excess[key] = max(self._excess.get(key, 0.0), excess_m_s)

    @property
    def corrections(self) -> Corrections:
        """What they come to."""
        factors = {
            kind: max(1.0, self._flown[kind] / planned)
            for kind, planned in self._planned.items()
            if planned > 0.0
        }
        return Corrections(dict(self._excess), factors)
