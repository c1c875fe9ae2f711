"""Cheaper plans of campaigns that collect as much."""

from __future__ import annotations

import math

import numpy as np
import pytest
from brute_force import brute_force_campaign
from random_rules import carrying, given_field, limited, mixed_campaign, priced, random_mission

import adr_opt
from adr_opt.common.stop import Proven
from adr_opt.mission.problem import Problem
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import Objective
from solvers.beams.greedy_order import guarded_sequence
from solvers.progress.gap import GapTracker
from solvers.routes.one_chaser import one_after_another
from solvers.routes.route_pool import RoutePool
from solvers.routes.route_search import RouteSearch
from solvers.routes.target_exchange import Exchanges


def drawn(seed: int) -> Instance:
    """A campaign of tiny fields, at any cost, with limits or without."""
    rng = np.random.default_rng([21, seed])
    instance = mixed_campaign(seed, (random_mission, given_field)[int(rng.integers(2))])
    if rng.random() < 0.5:
        instance = carrying(instance, seed)
    cost = ("delta-v", "duration", "expense")[int(rng.integers(3))]
    if cost == "expense":
        instance = priced(instance, seed)
    else:
        instance = instance.replace(objective=Objective(cost=cost))
    return limited(instance, seed) if rng.random() < 0.3 else instance


def test_what_is_made_cheaper_is_legal_and_mostly_the_cheapest():
    """Plans stay legal and collect no less, cost no more, and most reach the enumerated least."""
    reached = asked = 0
    for seed in range(60):
        campaign = Problem(drawn(seed))
        certificate, pool = GapTracker(campaign, lambda *_: None), RoutePool(campaign)
        certificate.offer(*one_after_another(campaign, guarded_sequence))
        if certificate.routes is None:
            continue
        worth, cost = certificate.incumbent, certificate.cost
        search = Exchanges(campaign, seed, certificate, pool)
        found = search.anneal(60, Proven())
        assert certificate.incumbent >= worth, seed
        if certificate.incumbent == worth:
            assert certificate.cost <= cost, seed
            assert found == (certificate.cost < cost), seed
        assert campaign.limits.allow(
            campaign.use(mission, route, mission.time(route).delta_vs)
            for mission, route in zip(campaign.missions, certificate.routes, strict=True)
        )
        prizes, least = brute_force_campaign(campaign)
        if math.isfinite(prizes) and campaign.shown(certificate.incumbent) == pytest.approx(prizes):
            asked += 1
            assert certificate.cost >= least * (1.0 - 1e-9) - 1e-6, seed
            reached += math.isclose(certificate.cost, least, rel_tol=1e-6, abs_tol=1e-6)
    assert asked >= 15
    assert reached >= 0.7 * asked


def test_plans_by_expense_are_made_cheaper_without_being_asked():
    """With the expense as the cost, `auto` ends with a plan that no exchange makes cheaper."""
    field = adr_opt.generate("removal", 5, targets=7, chasers=3)
    expense = {"fixed": 55.0, "per_kg": 0.0, "per_kg_squared": 2e-3}
    instance = field.replace(
        chasers=tuple(chaser.replace(expense=expense) for chaser in field.chasers),
        objective={"cost": "expense"},
    )
    campaign = Problem(instance)
    result = adr_opt.solve(campaign, "auto", time_limit=60.0)
    assert result.counters["exchanges"] > 0
    assert adr_opt.check(instance, result.plan) == ()
    certificate = GapTracker(campaign, lambda *_: None)
    certificate.offer(*result.routes)
    search = Exchanges(campaign, 1, certificate, RoutePool(campaign))
    assert not search.anneal(100, Proven())


@pytest.mark.slow
def test_exchanges_find_what_beams_miss():
    """In a long campaign they bring in targets that flying anew chaser by chaser leaves out."""
    campaign = Problem(adr_opt.generate("removal", 7, targets=40, chasers=3))
    certificate, pool = GapTracker(campaign, lambda *_: None), RoutePool(campaign)
    search = RouteSearch(campaign, 0, Proven(), certificate, pool)
    search.begin()
    for _ in range(20):
        search.move(100)
    before = certificate.incumbent
    assert Exchanges(campaign, 0, certificate, pool).anneal(300, Proven())
    assert certificate.incumbent >= before + 3.0
