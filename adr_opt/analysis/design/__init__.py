"""Designs of campaigns: fragment-years avoided against euros, planned, bounded and evaluated."""

from .designs import Design, designs_of
from .prices import CampaignPrices
from .results import DesignPoint, DesignStudy, pareto_front
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
