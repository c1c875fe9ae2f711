"""The planner `ortools`: legal, repeatable, never worse than the plan it starts from."""

from __future__ import annotations

import numpy as np
import pytest
from brute_force import brute_force
from calling import call

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.common.progress import silent
from adr_opt.common.stop import MaxIterations
from adr_opt.kernels.rules.rules import beginning, replay
from adr_opt.mission.mission import Mission
from adr_opt.run.methods import get
from solvers.planners.ortools_windows import ortools
from solvers.planners.ortools_windows.order import best_insertion, flown
from solvers.planners.ortools_windows.window_network import SlackWorth, fly_rest


@pytest.fixture(scope="module")
def nominal() -> Mission:
    return Mission(adr_opt.generate("nominal", 4))


def plan(mission, windows=6, seed=0, **options):
    """A result that passes the check."""
    result = call(ortools, mission, seed=seed, stop=MaxIterations(windows), **options)
    assert adr_opt.check(mission.instance, result.plan) == ()
    return result


def greedy(mission) -> float:
    guarded = get("greedy-guarded")
    return guarded(mission, seed=0, stop=MaxIterations(1), progress=silent).objective


def test_tiny_instances_are_mostly_solved():
    """A window covers a whole tiny mission, so the optimal prize comes out nearly always."""
    missions = [Mission(adr_opt.generate("tiny", seed, targets=5)) for seed in range(12)]
    met = [plan(mission).objective == brute_force(mission)[0] for mission in missions]
    assert sum(met) >= 10


def test_gains_a_visit_on_a_nominal_instance(nominal):
    """A dozen windows add at least one visit to guarded greedy on the nominal instance."""
    assert plan(nominal, windows=12).objective >= greedy(nominal) + 1.0


def test_the_usual_time_value_is_that_of_beams(nominal):
    """Who names no time value gets that of beams, in windows and insertions too."""
    usual, named = plan(nominal, windows=4), plan(nominal, windows=4, time_value_m_s_per_h=110.0)
    assert (usual.sequence, usual.counters) == (named.sequence, named.counters)
    assert plan(nominal, windows=4, time_value_m_s_per_h=75.0).counters != named.counters


def test_counts_windows_and_reports_every_better_plan(nominal):
    """One window per question to ``stop``; progress hears rising objectives, the last one final."""
    heard: list[float] = []
    result = ortools(nominal, seed=0, stop=MaxIterations(7), progress=lambda o, _: heard.append(o))
    assert result.counters["windows"] == 7
    assert heard == sorted(set(heard))
    assert heard[-1] == result.objective
    assert result.counters["improved"] == len(heard) - 1
    assert result.counters["solves"] + result.counters["closed_by_prices"] == 7


def test_target_out_of_reach():
    """A target to which there is no transfer is left out, and the others are planned."""
    instance = adr_opt.generate("tiny", 1)
    first = instance.targets[0]
    orbit = first.orbit.replace(semi_major_axis_m=EARTH_RADIUS_M + 5000e3)
    mission = Mission(
        instance.replace(targets=(first.replace(orbit=orbit, prize=9.0), *instance.targets[1:]))
    )
    result = plan(mission)
    assert 0.0 < result.objective < 9.0
    assert 1 not in result.sequence


def test_the_pace_is_a_schedule_of_the_order(nominal):
    """The pace of a measure is flown by the order, and by that measure no schedule is better."""
    sequence = np.array(plan(nominal, windows=1).sequence)
    order = flown(nominal, sequence)
    assert order is not None
    assert order.timing.made == sequence.size
    for worth in (SlackWorth(1e-5, 1e-4), SlackWorth(1e-9, 1e-3), SlackWorth(1e-3, 1e-9)):
        pace = order.pace(worth)
        cost = worth.per_m_s * pace.costs[-1] + worth.per_s * pace.times[-1]
        assert pace.value == pytest.approx(order.timing.objective - cost)
        least = worth.per_m_s * order.timing.delta_v + worth.per_s * order.timing.ends[-1]
        assert cost <= least + 1e-12
        assert (np.diff(pace.times) > 0.0).all()
        assert (pace.lefts >= 0.0).all()
        spent = -np.diff(pace.lefts)
        legs = np.diff(pace.costs)
        refuelled = sequence < nominal.rules.first_target
        assert spent[~refuelled] == pytest.approx(legs[~refuelled])
        assert (pace.lefts[1:][refuelled] == nominal.rules.budget).all()
    quick, cheap = order.pace(SlackWorth(1.0, 1e-9)), order.pace(SlackWorth(1e-12, 1.0))
    assert quick.times[-1] < cheap.times[-1]
    assert cheap.costs[-1] == pytest.approx(order.timing.delta_v)


def test_the_rest_is_flown_by_the_rules(nominal):
    """Flying a rest from a state inside a plan gives what replaying the whole plan gives."""
    rules = nominal.rules
    sequence = np.array(
        get("greedy-guarded")(nominal, seed=0, stop=MaxIterations(1), progress=silent).sequence
    )
    ends, lefts = np.empty((2, sequence.size))
    visited = np.zeros(rules.service.size, dtype=np.bool_)
    made, _, _ = replay(rules, sequence, beginning(rules), visited, ends, lefts)
    assert made == sequence.size
    worth = SlackWorth(1e-5, 1e-4)
    stop = int(np.flatnonzero(rules.is_station[sequence])[-1])
    for cut in range(1, sequence.size):
        value, need = fly_rest(rules, worth, sequence[cut:], int(sequence[cut - 1]), ends[cut - 1])
        before = np.concatenate((lefts[cut - 1 : cut], lefts[cut:-1]))
        before[rules.is_station[sequence[cut - 1 : -1]]] = rules.budget
        drawn = np.where(rules.is_station[sequence[cut:]], np.nan, before - lefts[cut:])
        if cut > stop:
            assert need == pytest.approx(lefts[cut - 1] - lefts[-1])
            prize = rules.prize[sequence[cut:]].sum()
            assert value == pytest.approx(prize - 1e-4 * drawn.sum() - 1e-5 * ends[-1])
        assert need <= lefts[cut - 1] + 1e-9


def test_insertions_are_legal_and_found(nominal):
    """Of plans that a target was taken out of some take one again; all that do can be flown."""
    order = flown(nominal, np.array(plan(nominal, windows=1).sequence))
    assert order is not None
    found = 0
    for place in np.flatnonzero(order.moves >= nominal.rules.first_target):
        shorter = flown(nominal, np.delete(order.moves, place))
        if shorter is None:
            continue
        pace = shorter.pace(SlackWorth(1e-5, 1e-4))
        target, at = best_insertion(
            nominal.rules, shorter.moves, pace.bodies, pace.times, pace.lefts, shorter.targets
        )
        if target >= 0:
            longer = flown(nominal, np.insert(shorter.moves, at, target))
            assert longer is not None
            assert longer.timing.objective == shorter.timing.objective + 1.0
            found += 1
    assert found > 0
