"""Plans and bounds of small campaigns against plain enumeration of all their plans."""

from __future__ import annotations

import math

import pytest
from brute_force import brute_force_campaign

import adr_opt
from adr_opt.campaign import Campaign
from adr_opt.result import Result


def compared(campaign: Campaign, result: Result, case: int) -> bool:
    """Hold a result against all plans of its campaign, with its margin; whether there is a plan.

    What is planned passes `check`, enumeration knows nothing above what is proven, and what is
    called optimal is the best.
    """
    prizes, cost = brute_force_campaign(campaign)
    assert result.upper_bound >= prizes - 1e-9, case
    if result.plan is None:
        assert math.isfinite(prizes) <= (result.status != "infeasible"), case
        return False
    assert adr_opt.check(campaign.instance, result.plan) == (), case
    assert result.objective <= prizes + 1e-9, case
    for mission, route in zip(campaign.missions, result.routes, strict=True):
        assert mission.time(route).made == len(route), case  # also with the margin
    if result.objective == pytest.approx(prizes):
        assert result.plan.cost >= cost - 1e-6, case
    if result.status == "optimal":
        assert result.objective == pytest.approx(prizes), case
    return True
