"""The planner `ortools`: legal, repeatable, never worse than the plan it starts from."""

from __future__ import annotations

import time

import numpy as np
import pytest
from calling import call

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.common.errors import InputError
from adr_opt.common.progress import silent
from adr_opt.common.stop import AnyOf, Interrupted, MaxIterations, MaxRuntime
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


def best_prize(mission) -> float:
    """The most that any order of bodies collects, over all connections: every order, one by one."""
    rules = mission.rules
    best = -np.inf

    def extend(order) -> None:
        nonlocal best
        closed = mission.closed(order)
        if rules.may_end[closed[-1] if closed else rules.start]:
            timing = mission.time(closed)
            if timing.made == len(closed):
                best = max(best, timing.objective)
        for j in range(rules.service.size):
            if mission.time((*order, j)).made > len(order):
                extend((*order, j))

    extend(())
    return best


def greedy(mission) -> float:
    guarded = get("greedy-guarded")
    return guarded(mission, seed=0, stop=MaxIterations(1), progress=silent).objective


@pytest.mark.parametrize("seed", range(6))
def test_tiny_instances(seed):
    """On tiny instances the plan is not below greedy and not above the optimum."""
    mission = Mission(adr_opt.generate("tiny", seed, targets=5))
    assert greedy(mission) <= plan(mission).objective <= best_prize(mission)


def test_tiny_instances_are_mostly_solved():
    """A window covers a whole tiny mission, so the optimal prize comes out nearly always."""
    missions = [Mission(adr_opt.generate("tiny", seed, targets=5)) for seed in range(12)]
    met = [plan(mission).objective == best_prize(mission) for mission in missions]
    assert sum(met) >= 10


def _other_missions():
    """Missions of other kinds on one small field."""
    base = adr_opt.generate("tiny", 3, targets=5).with_limits(delta_v_m_s=700.0)
    station, chaser = base.stations[0], base.chaser
    second = station.replace(name="second", orbit=base.targets[4].orbit)
    duration = base.mission.duration_s
    beside = {"orbit": base.targets[0].orbit}

    def of(**changes):
        return base.replace(chasers=(chaser.replace(**changes),))

    windows = [(0.3, 1.0), (0.0, 0.5), (0.2, 0.7), (0.0, 0.4), (0.5, 0.9)]
    return {
        "two stations": base.replace(stations=(station, second)),
        "no station": of(start=beside).replace(stations=()),
        "starts beside": of(start=beside),
        "returns": of(end={"station": station.name}),
        "returns to another": base.replace(
            stations=(station, second), chasers=(chaser.replace(end={"station": "second"}),)
        ),
        "three targets": of(max_targets=3),
        "a part of the time": of(available_s=(0.2 * duration, 0.8 * duration)),
        "windows": base.replace(
            targets=tuple(
                target.replace(window_s=(opens * duration, closes * duration), prize=1.0 + number)
                for number, (target, (opens, closes)) in enumerate(
                    zip(base.targets, windows, strict=True)
                )
            )
        ),
    }


@pytest.mark.parametrize("kind", _other_missions())
def test_missions_of_every_kind(kind):
    """Stations, starts, ends, limits and windows: legal, between greedy and the optimum."""
    mission = Mission(_other_missions()[kind])
    found = plan(mission, windows=12).objective
    assert greedy(mission) <= found <= best_prize(mission) + 1e-9
    assert found > 0.0


def test_gains_a_visit_on_a_nominal_instance(nominal):
    """A dozen windows add at least one visit to guarded greedy on the nominal instance."""
    assert plan(nominal, windows=12).objective >= greedy(nominal) + 1.0


@pytest.mark.slow
def test_same_seed_same_plan(nominal):
    """Seed, windows and jobs fix the result, counters included; another seed searches elsewhere."""
    one, two, other = (plan(nominal, windows=5, seed=seed) for seed in (3, 3, 4))
    assert one.sequence == two.sequence
    assert one.counters == two.counters
    assert other.sequence != one.sequence or other.counters != one.counters
    threads = [plan(nominal, windows=5, jobs=2) for _ in range(2)]
    assert threads[0].sequence == threads[1].sequence
    assert threads[0].counters == threads[1].counters


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
    assert 0.0 < result.objective < 9.0
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
    begun = time.process_time()
    ortools(nominal, seed=0, stop=MaxRuntime(0.5), progress=silent)
    assert time.process_time() - begun < 10.0
    interrupted = Interrupted()
    interrupted.interrupt()
    stop = AnyOf(interrupted, MaxIterations(50))
    assert ortools(nominal, seed=0, stop=stop, progress=silent).counters["windows"] == 0


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
