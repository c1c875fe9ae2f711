"""Several chasers: planners, bounds and `check` against plain enumeration."""

from __future__ import annotations

import math

import pytest
from brute_force import brute_force_campaign
from random_rules import drifting_mission, random_campaign, random_mission

import adr_opt
from adr_opt.campaign import Campaign

CAMPAIGNS = 100
DRIFTING = 30

every_part = pytest.mark.parametrize(
    ("draw", "seeds"),
    [
        *(
            pytest.param(random_mission, range(part, CAMPAIGNS, 4), id=f"two-body-{part}")
            for part in range(4)
        ),
        *(
            pytest.param(drifting_mission, range(part, DRIFTING, 2), id=f"j2-{part}")
            for part in range(2)
        ),
    ],
)


@every_part
@pytest.mark.parametrize("method", ["auto", "exact", "greedy-guarded"])
def test_plans_pass_and_bounds_hold(method, draw, seeds):
    """What is planned passes `check`, and enumeration knows nothing above what is proven."""
    planned = proven = 0
    for seed in seeds:
        campaign = Campaign(random_campaign(seed, draw))
        prizes, cost = brute_force_campaign(campaign)
        result = adr_opt.solve(campaign, method, time_limit=30.0, iterations=8)
        assert result.upper_bound >= prizes - 1e-9, seed
        if result.plan is None:
            assert math.isfinite(prizes) <= (result.status != "infeasible"), seed
            continue
        planned += 1
        assert adr_opt.check(campaign.instance, result.plan) == (), seed
        assert result.objective <= prizes + 1e-9, seed
        if result.objective == pytest.approx(prizes):
            assert result.plan.cost >= cost - 1e-6, seed
        if result.status == "optimal":
            assert result.objective == pytest.approx(prizes), seed
            proven += 1
    if method != "greedy-guarded":
        assert proven == planned > 0.6 * len(seeds)
