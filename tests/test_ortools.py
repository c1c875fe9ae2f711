"""The planner `ortools`: legal, repeatable, never worse than the plan it starts from."""

from __future__ import annotations

import time

import numpy as np
import pytest
from brute_force import brute_force
from hand_made import OPTIMAL_PLAN, hand_made

import adr_opt
from adr_opt.errors import InputError
from adr_opt.kernels.constants import EARTH_RADIUS_M
from adr_opt.mission import Mission
from adr_opt.planner import get, silent
from adr_opt.stop import AnyOf, Interrupted, MaxIterations, MaxRuntime
from solvers.ortools_windows import ortools
from solvers.ortools_windows.network import Worth, fly, fly_rest


@pytest.fixture(scope="module")
def nominal() -> Mission:
    return Mission(adr_opt.generate("nominal", 4))


def plan(mission, windows=6, seed=0, **options):
    """A result that passes the check."""
    result = ortools(mission, seed=seed, stop=MaxIterations(windows), progress=silent, **options)
    assert adr_opt.check(mission.instance, result.plan) == ()
    return result


def greedy(mission) -> float:
    guarded = get("greedy-guarded")
    return guarded(mission, seed=0, stop=MaxIterations(1), progress=silent).objective


def test_hand_made_optimum():
    """Windows find the one optimal plan of the hand-made instance, where greedy does not."""
    mission = Mission(hand_made())
    assert greedy(mission) == 2.0
    assert plan(mission).sequence == OPTIMAL_PLAN


@pytest.mark.parametrize("seed", range(6))
def test_tiny_instances(seed):
    """On tiny instances the plan is not below greedy and not above the optimum."""
    mission = Mission(adr_opt.generate("tiny", seed))
    best, _, _ = brute_force(mission)
    assert greedy(mission) <= plan(mission).objective <= best


def test_tiny_instances_are_mostly_solved():
    """A window covers a whole tiny mission, so the optimal prize comes out nearly always."""
    missions = [Mission(adr_opt.generate("tiny", seed)) for seed in range(12)]
    met = [plan(mission).objective == brute_force(mission)[0] for mission in missions]
    assert sum(met) >= 11


def test_gains_a_visit_on_a_nominal_instance(nominal):
    """A dozen windows add at least one visit to guarded greedy on the nominal instance."""
    assert plan(nominal, windows=12).objective >= greedy(nominal) + 1.0


def test_same_seed_same_plan(nominal):
    """Seed, windows and jobs fix the result, counters included; another seed searches elsewhere."""
    one, two, other = (plan(nominal, windows=5, seed=seed) for seed in (3, 3, 4))
    assert one.sequence == two.sequence
    assert one.counters == two.counters
    assert other.sequence != one.sequence or other.counters != one.counters
    threads = [plan(nominal, windows=5, jobs=2) for _ in range(2)]
    assert threads[0].sequence == threads[1].sequence
    assert threads[0].counters == threads[1].counters


def test_counts_windows_and_reports_every_better_plan(nominal):
    """One window per question to ``stop``; progress hears rising objectives, the last one final."""
    heard: list[float] = []
    result = ortools(nominal, seed=0, stop=MaxIterations(7), progress=lambda o, _: heard.append(o))
    assert result.counters["windows"] == 7
    assert heard == sorted(set(heard))
    assert heard[-1] == result.objective
    assert result.counters["improved"] == len(heard) - 1
    assert result.counters["solves"] + result.counters["closed_by_prices"] == 7


def test_begins_from_a_start_plan(nominal):
    """A start plan is never left worse, and an illegal one is refused."""
    good = plan(nominal, windows=12)
    again = plan(nominal, windows=1, start=good.sequence)
    assert again.objective >= good.objective
    assert plan(nominal, windows=1, start=()).objective > 0.0
    with pytest.raises(InputError, match="start plan"):
        plan(nominal, start=(1, 1))


def test_zones_prizes_and_refuelling():
    """Zones, unequal prizes and small tanks: legal, and not below greedy."""
    instance = adr_opt.generate("reduced-fuel", 1, targets=25, zones=6)
    targets = tuple(
        target.replace(prize=float(1 + number % 3) * 0.5)
        for number, target in enumerate(instance.targets)
    )
    mission = Mission(instance.replace(targets=targets))
    result = plan(mission)
    assert result.objective >= greedy(mission)
    assert 0 in result.sequence


def test_target_out_of_reach():
    """A target to which there is no transfer is left out, and the others are planned."""
    instance = adr_opt.generate("tiny", 1)
    first = instance.targets[0]
    orbit = first.orbit.replace(semi_major_axis_m=EARTH_RADIUS_M + 5000e3)
    mission = Mission(
        instance.replace(targets=(first.replace(orbit=orbit, prize=9.0), *instance.targets[1:]))
    )
    result = plan(mission)
    assert result.objective == brute_force(mission)[0]
    assert 1 not in result.sequence


@pytest.mark.parametrize("changes", [{"targets": ()}, {"prize": 0.0}, {"duration_s": 0.0}])
def test_nothing_to_gain(changes):
    """Without targets, prizes or time the planner ends by itself with a legal plan of worth 0."""
    instance = adr_opt.generate("tiny", 0)
    if "prize" in changes:
        changes = {"targets": tuple(t.replace(prize=0.0) for t in instance.targets)}
    if "duration_s" in changes:
        instance, changes = instance.with_limits(**changes), {}
    mission = Mission(instance.replace(**changes))
    result = ortools(mission, seed=0, stop=Interrupted(), progress=silent)
    assert adr_opt.check(mission.instance, result.plan) == ()
    assert result.objective == 0.0


def test_stops_in_time(nominal):
    """A time limit and an interruption are obeyed within one window."""
    plan(nominal, windows=1)
    begun = time.perf_counter()
    ortools(nominal, seed=0, stop=MaxRuntime(0.5), progress=silent)
    assert time.perf_counter() - begun < 10.0
    interrupted = Interrupted()
    interrupted.interrupt()
    stop = AnyOf(interrupted, MaxIterations(50))
    assert ortools(nominal, seed=0, stop=stop, progress=silent).counters["windows"] == 0


@pytest.mark.parametrize(
    "option", [{"jobs": -1}, {"edges": 0}, {"effort": 0.0}, {"longest_window": 2}]
)
def test_options_out_of_range(nominal, option):
    """An option out of range is refused by name."""
    with pytest.raises(InputError, match=next(iter(option))):
        plan(nominal, **option)


def test_the_rest_is_timed_exactly(nominal):
    """Flying a rest from a state inside a plan gives what timing the whole plan gives."""
    sequence = np.array(plan(nominal, windows=1).sequence)
    timing = nominal.time(sequence)
    worth = Worth(1e-5, 1e-4)
    cut = 9
    body, now = int(sequence[cut - 1]), float(timing.ends[cut - 1])
    ends, values = fly(nominal.rules, worth, body, now, sequence[cut:])
    assert np.array_equal(ends[1:], timing.ends[cut:])
    value, need = fly_rest(nominal.rules, worth, sequence[cut:], body, now)
    assert value == pytest.approx(values[-1] - worth.per_s * now)
    refuel = cut + int(np.flatnonzero(sequence[cut:] == 0)[0])
    assert need == pytest.approx(
        nominal.time(sequence[: refuel + 1]).delta_v - nominal.time(sequence[:cut]).delta_v
    )
