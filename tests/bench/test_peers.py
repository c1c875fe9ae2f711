"""The comparisons with PyVRP, OR-Tools and DIDPPy are fair and legal on tiny instances."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import peers
import pytest
from brute_force import brute_force, brute_force_campaign
from contest.promise import need, static_costs
from hand_made import BEYOND, FAR, NORTH, OPTIMAL_PLAN, SOUTH, STATION, hand_made
from random_rules import random_campaign

import adr_opt
from adr_opt.mission.mission import Mission
from adr_opt.mission.order_repair import as_it_is, mended
from adr_opt.mission.problem import Problem, problem_of


@pytest.fixture(scope="module")
def tiny() -> tuple[tuple[Mission, float], ...]:
    """Tiny missions with their optima; the last has unequal prizes."""
    found = []
    for seed in range(3):
        instance = adr_opt.generate("tiny", seed, targets=6)
        if seed == 2:
            targets = tuple(
                target.replace(prize=0.3 + 0.7 * number)
                for number, target in enumerate(instance.targets)
            )
            instance = instance.replace(targets=targets)
        mission = Mission(instance, threads=1)
        found.append((mission, brute_force(mission)[0]))
    return tuple(found)


def test_pyvrp_keeps_a_legal_plan(tiny):
    """PyVRP's order, timed exactly in either way, passes check and never beats brute force."""
    if not hasattr(pytest.importorskip("pyvrp").Model, "add_location"):
        pytest.skip("PyVRP 0.14 or later")
    for (mission, optimum), statistic in zip(tiny, ("mean", "best", "quartile"), strict=True):
        promise = peers.pyvrp_promise(
            problem_of(mission), time_limit_s=0.2, seed=0, statistic=statistic
        )
        assert promise.visits > 0.0
        cut, repaired = (
            peers.kept_of(problem_of(mission), promise, follow) for follow in (as_it_is, mended)
        )
        assert cut <= repaired <= optimum + 1e-9


STATIC_PEERS = pytest.mark.parametrize("peer", ["pyvrp", "ortools"])


def promised(peer: str, problem: Problem, **how: Any) -> Any:
    """What a peer that plans on static costs promises; skipped if it is not there."""
    if peer == "pyvrp" and not hasattr(pytest.importorskip("pyvrp").Model, "add_location"):
        pytest.skip("PyVRP 0.14 or later")
    plans = peers.pyvrp_promise if peer == "pyvrp" else peers.ortools_promise
    return plans(problem, seed=0, **{"time_limit_s": 0.3, **how})


def test_ortools_routing_keeps_a_legal_plan(tiny):
    """The order of OR-Tools' routing, timed exactly, passes check and never beats brute force."""
    for (mission, optimum), statistic in zip(tiny, ("mean", "best", "middle"), strict=True):
        promise = promised("ortools", problem_of(mission), statistic=statistic)
        assert promise.visits > 0.0
        cut, repaired = (
            peers.kept_of(problem_of(mission), promise, follow) for follow in (as_it_is, mended)
        )
        assert cut <= repaired <= optimum + 1e-9


@STATIC_PEERS
@pytest.mark.slow
def test_static_peers_plan_campaigns(peer):
    """Routes of several chasers share no target, pass check once cut, and are not above the best.

    What is promised is what the routes name, and mending takes nothing away.
    """
    kept = []
    drawn = [random_campaign(seed) for seed in range(6)]
    drawn += [adr_opt.generate("tiny", seed, targets=4, chasers=2, stations=2) for seed in range(3)]
    for instance in drawn:
        campaign = Problem(instance)
        promise = promised(peer, campaign)
        first = campaign.instance.first_target
        targets = [j for route in promise.routes for j in route if j >= first]
        assert len(promise.routes) == len(campaign.missions)
        assert len(set(targets)) == len(targets)
        assert promise.visits == pytest.approx(campaign.collected(targets))
        prizes, _ = brute_force_campaign(campaign)
        ways = [peers.kept_of(campaign, promise, follow) for follow in (as_it_is, mended)]
        assert max(ways) <= max(prizes, 0.0) + 1e-9
        assert ways[0] <= ways[1]
        kept.append(ways[1])
    assert min(kept[-3:]) > 0.0


def test_ortools_routing_keeps_tanks_at_its_costs():
    """On its own matrix each tank of OR-Tools holds from refuelling to refuelling, and its time.

    No station follows another one or the start, and somebody does refuel.
    """
    instance = adr_opt.generate("campaign", 0, targets=20, chasers=2, stations=2)
    campaign = Problem(instance.with_limits(duration_s=5 * 86400.0, delta_v_m_s=600.0))
    promise = promised("ortools", campaign, time_limit_s=1.0, statistic="quartile")
    delta_v, duration = static_costs(campaign.missions[0], "quartile")
    first, refuelled = instance.first_target, 0
    assert all(len(route) > 1 for route in promise.routes)
    for mission, route in zip(campaign.missions, promise.routes, strict=True):
        way = [mission.rules.start, *route]
        left, spent = mission.rules.budget, 0.0
        for i, j in itertools.pairwise(way):
            left, spent = left - delta_v[i, j], spent + duration[i, j]
            assert left >= -1e-9
            if j < first:
                assert i >= first
                left, refuelled = mission.rules.budget, refuelled + 1
        assert spent <= mission.rules.duration
    assert refuelled > 0


def test_static_costs_are_sampled():
    """The middle matrix is one of the samples, and none is below the best of them."""
    mission = Mission(adr_opt.generate("tiny", 1), threads=1)
    best, middle, mean = (static_costs(mission, each)[0] for each in ("best", "middle", "mean"))
    assert (best <= middle + 1e-9).all()
    assert (best <= mean + 1e-9).all()
    half = mission.timetable.matrices([1800.0 * round(mission.rules.duration / 3600.0)]).delta_v[0]
    same = np.isclose(middle, half) | ~np.isfinite(middle)
    assert same.mean() > 0.9
    assert not np.allclose(middle[same], best[same])


@pytest.mark.parametrize("earlier_is_better", [False, True])
def test_didppy_keeps_a_legal_plan(tiny, earlier_is_better):
    """CABS's plan in slots, timed exactly, passes check and is no better than brute force."""
    pytest.importorskip("didppy", minversion="0.11.0")
    for mission, optimum in tiny:
        promise = peers.didppy_promise(
            mission, time_limit_s=5.0, earlier_is_better=earlier_is_better
        )
        assert promise.visits > 0.0
        assert promise.bound >= promise.visits - 1e-9
        kept = peers.kept_of(problem_of(mission), promise, mended)
        assert 0.0 < kept <= optimum + 1e-9


def test_mending_refuels_and_leaves_out():
    """Of an order that needs fuel, the refuelling is put in; of an impossible one, a part stays."""
    mission = Mission(hand_made(), threads=1)
    assert as_it_is(mission, (SOUTH, NORTH, BEYOND)) == (SOUTH,)
    assert mended(mission, (SOUTH, NORTH, BEYOND)) == OPTIMAL_PLAN
    assert mended(mission, OPTIMAL_PLAN) == OPTIMAL_PLAN
    assert mended(mission, (STATION, BEYOND, NORTH)) == (NORTH, BEYOND)
    assert mended(mission, (FAR, SOUTH)) == (SOUTH,)
    assert mended(mission, ()) == ()


def test_missing_package_is_one_sentence():
    """A peer that is not installed is named with the extra that brings it."""
    with pytest.raises(adr_opt.common.errors.MissingExtra, match=r"\[peers\]"):
        need("no_such_package")


def test_peers_stand_beside_ours(capsys):
    """A table has our methods and a peer, as it is and mended, and gaps where there are several."""
    peers.fields("tiny", count=1, limit=0.2, static=("mean",), peers=("ortools",), ours=("beam",))
    printed = capsys.readouterr().out
    for method in ("beam", "OR-Tools routing, mean, as it is", "OR-Tools routing, mean, mended"):
        assert f"| {method} | " in printed
    assert "gap" not in printed
