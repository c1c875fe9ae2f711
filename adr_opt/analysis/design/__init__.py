"""Designs of campaigns: fragment-years avoided against euros, planned, bounded and evaluated."""

from .designs import Design, designs_of
from .front import pareto_front
from .point import DesignPoint
from .prices import CampaignPrices
from .results import DesignStudy
from .study import design_study

__all__ = [
    "CampaignPrices",
    "Design",
    "DesignPoint",
    "DesignStudy",
    "design_study",
    "designs_of",
    "pareto_front",
]
