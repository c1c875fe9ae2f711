"""The comparisons with PyVRP, DIDPPy and HiGHS are fair, legal and valid on tiny instances."""

from __future__ import annotations

import importlib.util
import itertools
import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from brute_force import brute_force, brute_force_campaign
from hand_made import BEYOND, FAR, NORTH, OPTIMAL_PLAN, SOUTH, STATION, hand_made
from random_rules import random_campaign

import adr_opt
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of

BENCH = Path(__file__).parents[2] / "bench"
SLOT_S = 240.0


@pytest.fixture(scope="module")
def script() -> Iterator[Callable[[str], ModuleType]]:
    """Import a script of the bench folder, which is no package."""
    sys.path.insert(0, str(BENCH))

    def load(name: str) -> ModuleType:
        if name not in sys.modules:
            spec = importlib.util.spec_from_file_location(name, BENCH / f"{name}.py")
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            sys.modules[name] = module
            spec.loader.exec_module(module)
        return sys.modules[name]

    yield load
    sys.path.remove(str(BENCH))


@pytest.fixture(scope="module")
def peers(script: Callable[[str], ModuleType]) -> ModuleType:
    return script("peers")


@pytest.fixture(scope="module")
def bounds(script: Callable[[str], ModuleType]) -> ModuleType:
    return script("bound_peers")


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


def test_pyvrp_keeps_a_legal_plan(peers, tiny):
    """PyVRP's order, timed exactly in either way, passes check and never beats brute force."""
    if not hasattr(pytest.importorskip("pyvrp").Model, "add_location"):
        pytest.skip("PyVRP 0.14 or later")
    for (mission, optimum), statistic in zip(tiny, ("mean", "best", "quartile"), strict=True):
        promise = peers.pyvrp_promise(
            problem_of(mission), time_limit_s=0.2, seed=0, statistic=statistic
        )
        assert promise.visits > 0.0
        as_it_is = peers.legal(problem_of(mission), peers.as_it_is(mission, promise.order))
        mended = peers.legal(problem_of(mission), peers.mended(mission, promise.order))
        assert as_it_is <= mended <= optimum + 1e-9


STATIC_PEERS = pytest.mark.parametrize("peer", ["pyvrp", "ortools"])


def promised(peers: ModuleType, peer: str, problem: Problem, **how: Any) -> Any:
    """What a peer that plans on static costs promises; skipped if it is not there."""
    if peer == "pyvrp" and not hasattr(pytest.importorskip("pyvrp").Model, "add_location"):
        pytest.skip("PyVRP 0.14 or later")
    plans = peers.pyvrp_promise if peer == "pyvrp" else peers.ortools_promise
    return plans(problem, seed=0, **{"time_limit_s": 0.3, **how})


def test_ortools_routing_keeps_a_legal_plan(peers, tiny):
    """The order of OR-Tools' routing, timed exactly, passes check and never beats brute force."""
    for (mission, optimum), statistic in zip(tiny, ("mean", "best", "middle"), strict=True):
        promise = promised(peers, "ortools", problem_of(mission), statistic=statistic)
        assert promise.visits > 0.0
        as_it_is = peers.legal(problem_of(mission), peers.as_it_is(mission, promise.order))
        mended = peers.legal(problem_of(mission), peers.mended(mission, promise.order))
        assert as_it_is <= mended <= optimum + 1e-9


@STATIC_PEERS
@pytest.mark.slow
def test_static_peers_plan_campaigns(peers, peer):
    """Routes of several chasers share no target, pass check once cut, and are not above the best.

    What is promised is what the routes name, and mending takes nothing away.
    """
    kept = []
    drawn = [random_campaign(seed) for seed in range(6)]
    drawn += [adr_opt.generate("tiny", seed, targets=4, chasers=2, stations=2) for seed in range(3)]
    for instance in drawn:
        campaign = Problem(instance)
        promise = promised(peers, peer, campaign)
        first = campaign.instance.first_target
        targets = [j for route in promise.routes for j in route if j >= first]
        assert len(promise.routes) == len(campaign.missions)
        assert len(set(targets)) == len(targets)
        assert promise.visits == pytest.approx(campaign.collected(targets))
        prizes, _ = brute_force_campaign(campaign)
        ways = [
            peers.legal_routes(campaign, peers.timed(campaign, promise.routes, follow))
            for follow in (peers.as_it_is, peers.mended)
        ]
        assert max(ways) <= max(prizes, 0.0) + 1e-9
        assert ways[0] <= ways[1]
        kept.append(ways[1])
    assert min(kept[-3:]) > 0.0


def test_ortools_routing_keeps_tanks_at_its_costs(peers):
    """On its own matrix each tank of OR-Tools holds from refuelling to refuelling, and its time.

    No station follows another one or the start, and somebody does refuel.
    """
    instance = adr_opt.generate("campaign", 0, targets=20, chasers=2, stations=2)
    campaign = Problem(instance.with_limits(duration_s=5 * 86400.0, delta_v_m_s=600.0))
    promise = promised(peers, "ortools", campaign, time_limit_s=1.0, statistic="quartile")
    delta_v, duration = peers.static_costs(campaign.missions[0], "quartile")
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


def test_static_costs_are_sampled(peers):
    """The middle matrix is one of the samples, and none is below the best of them."""
    mission = Mission(adr_opt.generate("tiny", 1), threads=1)
    best, middle, mean = (
        peers.static_costs(mission, each)[0] for each in ("best", "middle", "mean")
    )
    assert (best <= middle + 1e-9).all()
    assert (best <= mean + 1e-9).all()
    half = mission.timetable.matrices([1800.0 * round(mission.rules.duration / 3600.0)]).delta_v[0]
    same = np.isclose(middle, half) | ~np.isfinite(middle)
    assert same.mean() > 0.9
    assert not np.allclose(middle[same], best[same])


def test_gaps_are_to_the_best_bound_of_the_mission(peers):
    """A gap counts from the least bound of an instance, and never from that of a rounded model."""
    known, unknown = (adr_opt.generate("campaign", 1, chasers=chasers) for chasers in (None, 4))
    a, b, bounds = known.name, unknown.name, {known.name: 37.0, unknown.name: math.inf}
    fields = [Problem(known), Problem(unknown)]
    assert peers.best_bounds([], fields) == bounds
    rows = [
        peers.Row(method, name, visits, promised, bound, 0.0, 1.0)
        for method, name, visits, promised, bound in (
            ("auto", a, 36.0, 36.0, 38.0),
            ("auto", b, 8.0, 8.0, 10.0),
            ("PyVRP, mean, as it is", a, 18.5, 40.0, math.inf),
            ("PyVRP, mean, as it is", b, 6.0, 20.0, math.inf),
            ("DIDPPy, 240 s, as it is", a, 5.0, 5.0, 5.0),
            ("DIDPPy, 240 s, as it is", b, 6.0, 6.0, 6.0),
        )
    ]
    bounds = peers.best_bounds(rows, fields)
    assert bounds == {a: 37.0, b: 10.0}
    shown = peers.table(rows, bounds)
    assert "| auto | 22.00 | 36 8 | 22.00 | 100 % | 24.00 | 11.4 % |" in shown
    assert "| PyVRP, mean, as it is | 12.25 | 18.5 6 | 30.00 | 41 % | – | 45.0 % |" in shown
    assert "- PyVRP: one matrix for all times" in shown
    assert "| – | – | 0.0 s" in peers.table(rows[2:], peers.best_bounds(rows[2:4], fields))
    assert "gap" not in peers.table(rows)


def test_methods_for_one_chaser_are_left_out_of_campaigns(peers, capsys):
    """Of several chasers only what plans for them is compared, and what is left out is named."""
    ours, others = peers.able(["auto", "beam", "ortools"], ["pyvrp", "didppy"], True)
    assert (ours, others) == (["auto", "ortools"], ["pyvrp"])
    assert capsys.readouterr().err == "for one chaser, left out: beam, didppy\n"
    assert peers.able(["beam"], None, False) == (["beam"], ["pyvrp", "didppy", "didppy-early"])
    assert peers.able(["auto"], None, True) == (["auto"], ["pyvrp", "ortools"])
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("earlier_is_better", [False, True])
def test_didppy_keeps_a_legal_plan(peers, tiny, earlier_is_better):
    """CABS's plan in slots, timed exactly, passes check and is no better than brute force."""
    pytest.importorskip("didppy", minversion="0.11.0")
    for mission, optimum in tiny:
        promise = peers.didppy_promise(
            mission, time_limit_s=5.0, slot_s=SLOT_S, earlier_is_better=earlier_is_better
        )
        assert promise.visits > 0.0
        assert promise.bound >= promise.visits - 1e-9
        kept = peers.legal(problem_of(mission), peers.mended(mission, promise.order))
        assert 0.0 < kept <= optimum + 1e-9


@pytest.mark.parametrize("slot_s", [60.0, 240.0, 1500.0])
def test_relaxed_didppy_bounds_the_mission(peers, bounds, tiny, slot_s):
    """With everything rounded to the good, DIDPPy's bound is at least brute force."""
    pytest.importorskip("didppy", minversion="0.11.0")
    for mission, optimum in tiny:
        bound = bounds.didppy_bound(mission, time_limit_s=5.0, slot_s=slot_s)
        assert optimum - 1e-9 <= bound.value <= mission.total_prize


def test_rounding_to_the_bad_is_no_bound(peers, bounds):
    """In coarse slots the cautious model proves less than the optimum, the relaxed one does not."""
    pytest.importorskip("didppy", minversion="0.11.0")
    mission = Mission(adr_opt.generate("tiny", 9, targets=6), threads=1)
    optimum, _, _ = brute_force(mission)
    cautious = peers.didppy_promise(mission, time_limit_s=5.0, slot_s=2400.0)
    assert cautious.bound < optimum
    assert bounds.didppy_bound(mission, time_limit_s=5.0, slot_s=2400.0).value >= optimum


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["ipm", "simplex"])
def test_linear_relaxation_bounds_the_mission(bounds, tiny, solver):
    """HiGHS's bound is at least brute force, and merging nodes does not tighten it."""
    for mission, optimum in tiny:
        fine, coarse = (
            bounds.highs_bound(mission, time_limit_s=10.0, solver=solver, bucket_s=bucket).value
            for bucket in (0.0, 3600.0)
        )
        assert optimum - 1e-9 <= fine <= coarse + 1e-6


def test_best_plan_is_a_point_of_the_linear_relaxation(bounds):
    """The worked-out optimum, with its refuelling, keeps all rows of the linear relaxation."""
    mission = Mission(hand_made(), threads=1)
    for bucket in (0.0, 3600.0):
        bound = bounds.highs_bound(mission, time_limit_s=10.0, bucket_s=bucket)
        assert 3.0 - 1e-9 <= bound.value <= 4.0


def test_any_prices_give_a_bound(bounds, tiny):
    """The bound from dual values holds for wrong ones too."""
    rng = np.random.default_rng(0)
    for mission, optimum in tiny:
        relaxation = bounds.linear_relaxation(mission)
        for _ in range(20):
            prices = rng.uniform(-0.5, 1.0, relaxation.limit.size)
            prices[-1] *= 1e-3
            assert bounds.dual_bound(relaxation, prices) >= optimum - 1e-9


def test_mending_refuels_and_leaves_out(peers):
    """Of an order that needs fuel, the refuelling is put in; of an impossible one, a part stays."""
    mission = Mission(hand_made(), threads=1)
    assert peers.as_it_is(mission, (SOUTH, NORTH, BEYOND)) == (SOUTH,)
    assert peers.mended(mission, (SOUTH, NORTH, BEYOND)) == OPTIMAL_PLAN
    assert peers.mended(mission, OPTIMAL_PLAN) == OPTIMAL_PLAN
    assert peers.mended(mission, (STATION, BEYOND, NORTH)) == (NORTH, BEYOND)
    assert peers.mended(mission, (FAR, SOUTH)) == (SOUTH,)
    assert peers.mended(mission, ()) == ()


def test_missing_package_is_one_sentence(peers):
    """A peer that is not installed is named with the extra that brings it."""
    with pytest.raises(adr_opt.common.errors.MissingExtra, match=r"\[peers\]"):
        peers.need("no_such_package")
