"""The comparisons with PyVRP, DIDPPy and HiGHS are fair, legal and valid on tiny instances."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from brute_force import brute_force
from hand_made import BEYOND, FAR, NORTH, OPTIMAL_PLAN, SOUTH, STATION, hand_made

import adr_opt
from adr_opt.mission import Mission

BENCH = Path(__file__).parents[1] / "bench"
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
        promise = peers.pyvrp_promise(mission, time_limit_s=0.2, seed=0, statistic=statistic)
        assert promise.visits > 0.0
        as_it_is = peers.legal(mission, peers.as_it_is(mission, promise.order))
        mended = peers.legal(mission, peers.mended(mission, promise.order))
        assert as_it_is <= mended <= optimum + 1e-9


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
        kept = peers.legal(mission, peers.mended(mission, promise.order))
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


@pytest.mark.parametrize("solver", ["ipm", "simplex"])
def test_linear_relaxation_bounds_the_mission(bounds, tiny, solver):
    """HiGHS's bound is at least brute force, and merging nodes does not tighten it."""
    pytest.importorskip("highspy")
    for mission, optimum in tiny:
        fine, coarse = (
            bounds.highs_bound(mission, time_limit_s=10.0, solver=solver, bucket_s=bucket).value
            for bucket in (0.0, 3600.0)
        )
        assert optimum - 1e-9 <= fine <= coarse + 1e-6


def test_best_plan_is_a_point_of_the_linear_relaxation(bounds):
    """The worked-out optimum, with its refuelling, keeps all rows of the linear relaxation."""
    pytest.importorskip("highspy")
    mission = Mission(hand_made(), threads=1)
    for bucket in (0.0, 3600.0):
        bound = bounds.highs_bound(mission, time_limit_s=10.0, bucket_s=bucket)
        assert 3.0 - 1e-9 <= bound.value <= 4.0


def test_any_prices_give_a_bound(bounds, tiny):
    """The bound from dual values holds for wrong ones too."""
    pytest.importorskip("scipy")
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
    with pytest.raises(adr_opt.errors.MissingExtra, match=r"\[peers\]"):
        peers.need("no_such_package")
