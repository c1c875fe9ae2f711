"""Plans and bounds of small campaigns against plain enumeration of all their plans."""

from __future__ import annotations

import math

import pytest
from brute_force import brute_force_campaign

import adr_opt
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result


def compared(campaign: Problem, result: Result, case: int) -> bool:
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


def compared_cost(campaign: Problem, result: Result, case: int) -> bool | None:
    """Hold what is proven of the least cost against all plans; whether it is that of the plan.

    None where nothing was asked: the prizes are not proven.
    """
    if result.status != "optimal" or result.plan is None:
        assert result.plan is None or result.plan.cost_bound is None, case
        return None
    prizes, cost = brute_force_campaign(campaign)
    plan = result.plan
    assert adr_opt.check(campaign.instance, plan) == (), case
    assert plan.objective == pytest.approx(prizes), case
    assert plan.cost_bound <= cost * (1.0 + 1e-9) + 1e-6, case
    assert plan.cost >= cost * (1.0 - 1e-9) - 1e-6, case
    if plan.cost_status != "optimal":
        return False
    assert plan.cost == pytest.approx(cost, rel=2e-6, abs=1e-5), case
    return True
