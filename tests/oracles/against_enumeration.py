"""Plans and bounds of small campaigns against plain enumeration of all their plans."""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import closing
from typing import Any

import pytest
from brute_force import brute_force, brute_force_campaign

import adr_opt
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result
from adr_opt.problem.instance import Instance
from solvers.proof.cost import CostProof


def compared(campaign: Problem, result: Result, case: object) -> bool:
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
    if result.plan.cost_bound is not None:
        compared_cost(campaign, result, case)
    return True


def compared_cost(campaign: Problem, result: Result, case: object) -> bool | None:
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


def bound_of_cost(
    mission: Mission, dear: float, *, slot_m_s: float = 100.0, jobs: int = 1
) -> tuple[float, float] | None:
    """Hold a proof of the least cost against all plans, round by round; its bound and that cost.

    None where there is no plan.

    Parameters
    ----------
    mission : Mission
    dear : float
        Cost of the plan that the proof knows, over the least. It hears of no better one, so that
        walks are asked for that there are.
    slot_m_s : float
        Of ΔV, as the walks count it.
    jobs : int
    """
    prizes, cost, _ = brute_force(mission)
    if not math.isfinite(prizes):
        return None
    found: list[Any] = []
    proof = CostProof(
        mission,
        mission.worth(prizes),
        found.append,
        lambda: dear * cost + 1.0,
        lambda: False,
        jobs=jobs,
        delta_v_slot_m_s=slot_m_s,
        most_labels=10**6,
    )
    with closing(proof):
        for _ in range(12):
            if not proof.done:
                proof.advance()
            assert proof.bound <= cost * (1.0 + 1e-9) + 1e-6
    for sequence in found:
        schedule = mission.time(tuple(int(j) for j in sequence))
        assert schedule.made == len(sequence)
        assert schedule.objective >= mission.worth(prizes) - 1e-6
        assert schedule.cost >= cost - 1e-6
    return float(proof.bound), cost


Held = list[tuple[Instance, Result]]


def held(campaigns: Iterable[Problem], method: str, **options: Any) -> Held:
    """The plans of campaigns after little work, each :func:`compared` with enumeration."""
    found = []
    for campaign in campaigns:
        limits = {"time_limit": 30.0, "iterations": 8} | options
        result = adr_opt.solve(campaign, method, **limits)
        if compared(campaign, result, campaign.instance.name):
            found.append((campaign.instance, result))
    return found


def optimal(found: Held) -> int:
    """How many are proven."""
    return sum(result.status == "optimal" for _, result in found)


def held_costs(campaigns: Iterable[Problem]) -> Held:
    """The plans whose least cost is proven, which are most of those whose prizes are."""
    closed, asked, all_of_them = [], 0, list(campaigns)
    for campaign in all_of_them:
        result = adr_opt.solve(campaign, "exact", time_limit=30.0, iterations=8, cost=True)
        is_least = compared_cost(campaign, result, campaign.instance.name)
        asked += is_least is not None
        if is_least:
            closed.append((campaign.instance, result))
    assert len(closed) >= 0.8 * asked > 0.2 * len(all_of_them)
    return closed
