"""Several chasers: planners, bounds and `check` against plain enumeration, and one another."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
import pytest
from against_enumeration import held, held_costs, optimal
from brute_force import brute_force_campaign, ways_of_mission
from random_rules import (
    by_days,
    carrying,
    drifting_mission,
    falling_campaign,
    given_field,
    given_mission,
    mixed_campaign,
    random_campaign,
    random_mission,
    towing,
)
from resonant_fields import RARE, resonant
from seeds import over_kinds, over_seeds

import adr_opt
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from solvers.labels.label_search import LabelSearch
from solvers.walks.walks import WalkBound

PROVING = ("auto", "exact")

every_kind = over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(100), 3),
    j2=(drifting_mission, range(30), 3),
    given=(given_field, range(40), 3),
)


@every_kind
@pytest.mark.parametrize("method", [*PROVING, "greedy-guarded", "ortools"])
def test_plans_pass_and_bounds_hold(method, draw, seeds):
    """What is planned passes `check`, and enumeration knows nothing above what is proven."""
    results = held((Problem(random_campaign(seed, draw)) for seed in seeds), method)
    assert len(results) > 0.6 * len(seeds)
    if method in PROVING:
        assert optimal(results) == len(results)


@over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(100), 2),
    j2=(drifting_mission, range(100), 2),
    given=(given_field, range(100), 2),
    mixed=(mixed_campaign, range(100), 2),
)
def test_time_that_is_left_gives_the_least_cost(draw, seeds):
    """`auto` ends with a plan of least cost among all that collect as much, and proves it."""
    planned = 0
    for seed in seeds:
        instance = draw(seed) if draw is mixed_campaign else random_campaign(seed, draw)
        campaign = Problem(instance)
        plan = adr_opt.solve(campaign, "auto", time_limit=60.0).plan
        if plan is None:
            continue
        prizes, cost = brute_force_campaign(campaign)
        assert plan.objective == pytest.approx(prizes), seed
        assert plan.cost == pytest.approx(cost, rel=2e-6, abs=1e-5), (seed, plan.cost, cost)
        assert plan.cost_status == "optimal", (seed, plan.cost_bound, cost)
        planned += 1
    assert planned > 0.5 * len(seeds)


@over_kinds("seeds", falls=(range(60), 3))
@pytest.mark.parametrize("method", [*PROVING, "greedy-guarded"])
def test_prizes_fall_for_all_chasers(method, seeds):
    """A prize is what it is as the service ends, whoever makes it, and proofs know all of it."""
    results, fallen = held((Problem(falling_campaign(seed)) for seed in seeds), method), 0
    for instance, result in results:
        targets = {each.name: each.greatest_prize for each in instance.targets}
        most = math.fsum(targets.get(name, 0.0) for name in result.plan.destinations)
        fallen += result.objective < most - 1e-9
    assert len(results) > 0.6 * len(seeds)
    assert fallen > 0.15 * len(results)
    if method in PROVING:
        assert optimal(results) == len(results)


@every_kind
@pytest.mark.parametrize("method", [*PROVING, "ortools"])
def test_chasers_of_many_kinds(method, draw, seeds):
    """What differs between chasers is each one's own, a margin is kept by all, proofs hold."""
    campaigns = [
        Problem(mixed_campaign(seed, draw), margin=0.1 * (seed % 3 == 0)) for seed in seeds
    ]
    results = held(campaigns, method)
    assert sum(len(campaign.kinds) > 1 for campaign in campaigns) > 0.7 * len(seeds)
    assert len(results) > 0.33 * len(seeds)
    if method in PROVING:
        assert optimal(results) >= 0.6 * len(results)


@every_kind
@pytest.mark.parametrize("make", [random_campaign, mixed_campaign])
def test_the_least_cost_is_that_of_enumeration(make, draw, seeds):
    """No bound on the cost lies above the least, and what is proven to be the least is."""
    campaigns = []
    for seed in seeds:
        instance = make(seed, draw)
        if seed % 2:
            instance = carrying(instance, seed)
        if seed % 3 == 0 and instance.given is None:
            instance = towing(instance, seed)
        if instance.objective.cost == "delta-v":
            instance = by_days(instance, seed)
        campaigns.append(Problem(instance))
    held_costs(campaigns)


@over_seeds([*RARE, *range(30)], gate=3)
def test_proofs_hold_on_knife_edges(seed):
    """Where rounding decides, what is proven of several chasers is what enumeration finds."""
    rng = np.random.default_rng([6, seed])
    instance = resonant(seed)
    first = instance.chaser
    second = first.replace(name="second", max_targets=1 if rng.random() < 0.3 else None)
    chasers = [first, second] if rng.random() < 0.5 else [first, second, first.replace(name="c")]
    campaign = Problem(instance.replace(chasers=tuple(chasers)))
    prizes, _ = brute_force_campaign(campaign)
    for method in ("auto", "exact"):
        result = adr_opt.solve(campaign, method, time_limit=30.0, iterations=8)
        assert adr_opt.check(campaign.instance, result.plan) == ()
        assert result.status == "optimal"
        assert result.objective == pytest.approx(prizes)


@over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(120), 66),
    j2=(drifting_mission, range(120), 9),
    given=(given_mission, range(120), 33),
)
def test_every_set_of_targets_that_is_worth_enough_is_listed(draw, seeds):
    """What ends proofs has a route for each set that enumeration finds, and for no other."""
    listed = several = 0
    for seed in seeds:
        mission = Mission(draw(seed))
        rng = np.random.default_rng([7, seed])
        multipliers = rng.uniform(0.0, 1.0, len(mission.names)) * mission.planning_prizes
        first = mission.instance.first_target
        worth = {
            done: math.fsum(mission.planning_prizes[j] - multipliers[j] for j in done)
            for done in ways_of_mission(mission)
            if done
        }
        if not worth:
            continue
        least = float(rng.choice([-5.0, 0.0, 0.5, 1.0])) * mission.planning_prizes.max()
        search = LabelSearch(WalkBound(mission, 20.0), all_sets=True)
        search.use(multipliers)
        finished, _, _, _ = search.search(search.total + least, 10**6, lambda: False)
        routes = search.plans(10**6)
        found = {frozenset(j for j in route if j >= first) for route in routes} - {frozenset()}
        assert finished
        off = 1e-6 * mission.planning_prizes.max()
        assert found >= {done for done in worth if worth[done] > least + off}, seed
        assert found <= {done for done in worth if worth[done] > least - 1e-3}, seed
        listed += len(found)
        several += any(one < other for one in found for other in found)
    assert listed > 0.8 * len(seeds)
    assert several > len(seeds) / 12


@over_seeds(range(1, 40, 3), gate=1)
def test_the_order_of_chasers_decides_nothing(seed):
    """In whatever order chasers are listed, as much is proven, and one more takes nothing away."""
    instance = mixed_campaign(seed)
    idle = instance.chasers[0].replace(name="one more", end="anywhere")
    fleets = [*list(permutations(instance.chasers))[:3], (*instance.chasers, idle)]
    *results, with_more = [
        adr_opt.solve(instance.replace(chasers=chasers), time_limit=30.0, iterations=8)
        for chasers in fleets
    ]
    for one in results:
        assert one.status != "unknown"
        assert all(one.objective <= other.upper_bound + 1e-9 for other in (*results, with_more))
