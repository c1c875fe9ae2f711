"""The Lagrangian bound of a campaign: best walks of all chasers under common multipliers.

With multipliers π of "each target at most once", whoever does it,

    prizes collected ≤ Σ π + Σ over chasers of the best walk that is worth prize − π at each target,

and chasers of one kind have the same best walk.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from adr_opt.campaign import Campaign

from ..relaxation.walks import WalkBound


def walk_bounds(
    campaign: Campaign,
    delta_v_slot_m_s: float,
    *,
    jobs: int,
    over: Callable[[], bool],
    networks: Sequence[WalkBound] | None = None,
) -> tuple[WalkBound, ...]:
    """A bound of walks for each kind of chasers, on the networks of others if they are known."""
    known = [None] * len(campaign.kinds) if networks is None else [one.network for one in networks]
    return tuple(
        WalkBound(kind.mission, delta_v_slot_m_s, jobs=jobs, over=over, network=network)
        for kind, network in zip(campaign.kinds, known, strict=True)
    )


class CampaignBound:
    """Best walks of all kinds of chasers for given multipliers, as a descent asks for them.

    Parameters
    ----------
    campaign : Campaign
    bounds : sequence of WalkBound
        One of each kind.
    """

    def __init__(self, campaign: Campaign, bounds: Sequence[WalkBound]) -> None:
        self._bounds = bounds
        self._counts = [len(kind.chasers) for kind in campaign.kinds]
        # Multipliers that are exact in the coarsest unit are exact in all.
        self._coarsest_first = sorted(range(len(bounds)), key=lambda number: -bounds[number].unit)
        first = bounds[0]
        self.prize, self.is_target = first.prize, first.is_target
        self.dimensions, self.total, self.radius = first.dimensions, first.total, first.radius
        self.first_point, self.allowed = first.first_point, first.allowed

    def at(self, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """The bound near a point, the multipliers for which it holds, and its slope there."""
        slope, values = np.ones(self.dimensions), np.zeros(len(self._bounds))
        for number in self._coarsest_first:
            bound = self._bounds[number]
            value, point = bound.evaluate(point)
            values[number] = value - math.fsum(point)
            slope -= self._counts[number] * np.bincount(bound.walk, minlength=slope.size)
        slope[~self.is_target] = 0.0
        if np.isneginf(values).any():
            return -math.inf, point, slope
        return math.fsum([*point, *(self._counts * values)]), point, slope
