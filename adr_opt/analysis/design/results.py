"""The results of a study of designs, as data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ...common.card import Shown
from ...problem.instance import Instance
from ..trade.axes import KINDS, Axis
from .front import pareto_front
from .point import DesignPoint
from .prices import CampaignPrices
from .rating import Rating


@dataclass(frozen=True, repr=False)
class DesignStudy(Shown):
    """Plans, bounds and worths of the designs of a campaign.

    Attributes
    ----------
    instance : Instance
        That is varied.
    axes : tuple of Axis
    points : tuple of DesignPoint
        In the order of the axes; those that are finished.
    wanted : int
        Number of designs.
    rating : Rating
        What sets of targets are worth.
    prices : CampaignPrices
    total : float or None
        Worth of all pairs of the catalogue.
    runtime_s : float
    """

    instance: Instance
    axes: tuple[Axis, ...]
    points: tuple[DesignPoint, ...]
    wanted: int
    rating: Rating
    prices: CampaignPrices
    total: float | None = None
    runtime_s: float = field(default=0.0, compare=False)

    @property
    def front(self) -> tuple[int, ...]:
        """Numbers of the points on the Pareto front, cheapest first."""
        return pareto_front(self.points)

    def to_dict(self) -> dict[str, Any]:
        """The study as JSON data."""
        front = set(self.front)
        return {
            "instance": {"name": self.instance.name, "sha256": self.instance.sha256},
            "varied": {
                axis.kind: [round(value / KINDS[axis.kind].scale, 9) for value in axis.values]
                for axis in self.axes
            },
            "unit": self.rating.unit or "prize",
            "prices": str(self.prices),
            "left_out": list(self.rating.left_out),
            "total": self.total,
            "designs": self.wanted,
            "points": [
                {**point.to_dict(), "on_front": at in front} for at, point in enumerate(self.points)
            ],
            "runtime_s": self.runtime_s,
        }
