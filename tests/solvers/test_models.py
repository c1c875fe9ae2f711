"""The exact models: equal to brute force, whatever they are asked for and however they end."""

from __future__ import annotations

import math
import sys
import threading
import time

import numpy as np
import pytest
from brute_force import brute_force
from calling import prove
from hand_made import OPTIMAL_PLAN, OPTIMUM, hand_made
from seeds import first_of, over_seeds
from small_missions import DAY_S, TINY, ruled_mission

import adr_opt
from adr_opt.common.constants import SLACK_M_S
from adr_opt.common.errors import MissingExtra
from adr_opt.common.stop import Interrupted, MaxRuntime
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from solvers.bounds.routing_bound import in_steps, routing_bound
from solvers.models import course
from solvers.models.cp_sat import cp_sat
from solvers.planners.mip import mip

all_methods = pytest.mark.parametrize("method", [mip, routing_bound])


@pytest.fixture(autouse=True)
def _mip_extra(request):
    """Tests of the mip method need its extra."""
    if "mip" in request.node.name:
        pytest.importorskip("pyomo")
        pytest.importorskip("pyomo")


def has_proven(result, mission, optimum):
    """Whether a result is a certificate that the optimum is what it is."""
    if optimum == -math.inf:
        assert (result.status, result.upper_bound) == ("infeasible", -math.inf)
        return result.plan is None
    near = 1e-6 * max(1.0, optimum)
    assert result.status == "optimal"
    assert abs(result.objective - optimum) <= near
    assert optimum - 1e-9 <= result.upper_bound <= optimum + near
    assert adr_opt.check(mission.instance, result.plan) == ()
    return True


@pytest.mark.parametrize("path", first_of(TINY, gate=2), ids=lambda path: path.stem)
def test_tiny_family(path):
    """On every committed tiny instance the optimum is proven, with and without a start plan."""
    mission = Mission(adr_opt.load(path), threads=1)
    optimum, _, best = brute_force(mission)
    assert has_proven(prove(mip, mission), mission, optimum)
    assert has_proven(prove(mip, mission, start=best), mission, optimum)
    assert has_proven(prove(mip, mission, start=best[:1]), mission, optimum)


@pytest.mark.parametrize("whole", [True, False])
@over_seeds(range(3000, 3060), gate=6)
def test_missions_with_every_feature(whole, seed, monkeypatch):
    """With every rule on or off, and arcs removed or not, the planner equals enumeration."""
    monkeypatch.setattr(course, "WHOLE_LEGS", 10**9 if whole else 0)
    mission = ruled_mission(seed)
    optimum, _, best = brute_force(mission)
    start = best if seed % 2 and optimum > -math.inf else None
    assert has_proven(prove(mip, mission, jobs=1, start=start), mission, optimum)


@all_methods
@pytest.mark.parametrize("change", [{"delta_v_m_s": 0.0}, {"duration_s": 0.0}])
def test_nothing_can_be_reached(method, change):
    """Without ΔV or without time the bound is 0."""
    instance = adr_opt.generate("tiny", 1)
    mission = Mission(instance.with_limits(**change))
    result = prove(method, mission)
    assert result.upper_bound == 0.0
    assert result.objective <= 0.0


@pytest.mark.parametrize("prizes", [(1e12, 1.0), (1e-7, 3e-7), (1e9, 0.5), (6e6, 9e6)])
def test_prizes_of_any_size(prizes):
    """Prizes far from 1 and far apart: proven to the step, or it is said that none could be told.

    HiGHS knows no more than seven digits of an objective.
    """
    instance = adr_opt.generate("tiny", 4)
    targets = tuple(
        target.replace(prize=prizes[number % 2]) for number, target in enumerate(instance.targets)
    )
    mission = Mission(instance.replace(targets=targets))
    optimum, _, _ = brute_force(mission)
    result = prove(mip, mission)
    assert optimum * (1.0 - 1e-12) <= result.upper_bound <= optimum + 1e-6 * max(1.0, optimum)
    if max(prizes) > 1e6 * mission.prize_step:
        assert result.status == "feasible"
        assert any("within its tolerances" in note for note in result.notes)
    else:
        assert (result.status, result.objective) == ("optimal", pytest.approx(optimum, rel=1e-15))


def test_a_tank_that_is_just_too_small():
    """Paths that exceed the tank by less than the solver can tell are ruled out, to a proof."""
    mission = Mission(hand_made(), threads=1)
    spent = 2.0 * (
        300.0
        - certify(mission, "x", OPTIMAL_PLAN, seed=0, runtime_s=0.0).plan.legs[0].delta_v_left_m_s
    )
    mission = Mission(hand_made(delta_v_m_s=spent - 1.05 * SLACK_M_S), threads=1)
    optimum, _, _ = brute_force(mission)
    result = prove(mip, mission)
    assert optimum < OPTIMUM
    assert has_proven(result, mission, optimum)
    assert result.counters["forbidden"] > 0


@pytest.mark.slow
def test_an_interruption_ends_the_solver(monkeypatch):
    """Someone who says enough from outside, without a time limit, does not wait for the proof."""
    monkeypatch.setattr(course, "WHOLE_LEGS", 10**9)
    instance = adr_opt.generate("reduced-time", 0, targets=14)
    mission = Mission(instance.with_limits(duration_s=2.0 * DAY_S))
    stop = Interrupted()
    timer = threading.Timer(1.5, stop.interrupt)
    timer.start()
    began = time.monotonic()
    result = prove(mip, mission, stop=stop, most_arcs=10**9)
    assert result.upper_bound <= 14.0
    assert result.status == "feasible"
    assert time.monotonic() - began < 60.0
    timer.cancel()


def test_a_network_that_is_too_large():
    """What is too large for the solver is not tried: a bound, a plan, and a note that says so."""
    mission = Mission(adr_opt.generate("reduced-time", 0, targets=15))
    result = prove(mip, mission, most_arcs=1, evaluations=20)
    assert result.upper_bound < 15.0
    assert result.counters["solves"] == 0
    assert result.status == "feasible"
    assert any("most_arcs = 1" in note for note in result.notes)


def test_missing_extra(monkeypatch):
    """Without Pyomo the method says which extra to install."""
    module = sys.modules["solvers.planners.mip"]
    found = module.find_spec
    monkeypatch.setattr(module, "find_spec", lambda name: None if name == "pyomo" else found(name))
    with pytest.raises(MissingExtra, match=r"pyomo.*\[mip\]"):
        prove(mip, Mission(hand_made()))


def test_prizes_in_steps_are_never_too_few():
    """Whole multiples stay exact; all others are rounded up by less than a billionth of the sum."""
    steps, step = in_steps(np.array([0.0, 6.0, 15.0]), 3.0)
    assert (steps.tolist(), step) == ([0, 2, 5], 3.0)
    prize = np.random.default_rng(0).uniform(0.0, 1.0, 100)
    prize[0] = 0.0
    steps, step = in_steps(prize, 1.0)
    assert np.all(steps * step >= prize)
    assert np.all(steps * step <= prize + 1e-9 * prize.sum())
    assert steps[0] == 0


@pytest.mark.slow
def test_three_days_with_twenty_targets():
    """A reduced instance: goals are proven one after the other, within a margin of a visit."""
    mission = Mission(adr_opt.generate("reduced-time", 0, targets=20))
    result = prove(mip, mission, stop=MaxRuntime(240.0))
    assert result.upper_bound == 12.0
    assert math.isfinite(result.objective)
    assert result.upper_bound - result.objective <= 1.0


def test_cp_sat_leaves_out_the_presolving_that_proves_wrong_optima() -> None:
    """The limit that keeps google/or-tools#5293 away is nothing, however the solver is called."""
    for seed, remaining_s, effort in ((0, math.inf, math.inf), (2**40, 1.0, 2.0)):
        assert cp_sat(seed, remaining_s, effort).parameters.presolve_inclusion_work_limit == 0
