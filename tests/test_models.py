"""The exact models and the static bound: equal to brute force, or never below it."""

from __future__ import annotations

import importlib
import math
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from brute_force import brute_force
from calling import call
from hand_made import OPTIMAL_PLAN, OPTIMUM, hand_made
from random_rules import random_mission as all_rules
from test_proofs_hold import resonant

import adr_opt
from adr_opt.bodies import Station
from adr_opt.chasers import AtStation, Chaser, InOrbit
from adr_opt.errors import MissingExtra
from adr_opt.kernels.constants import SLACK_M_S
from adr_opt.mission import Mission
from adr_opt.result import certify
from adr_opt.stop import Interrupted, MaxIterations, MaxRuntime
from solvers.bounds.routing_bound import routing_bound, static_costs
from solvers.models import course, network
from solvers.models.network import all_of, bodies_along, keep, of_rows, path_of
from solvers.models.reduction import best_through, can_reach
from solvers.models.steps import in_steps
from solvers.planners.cpsat import cpsat
from solvers.planners.mip import mip
from solvers.relaxation.network import build

INSTANCES = Path(__file__).parents[1] / "instances" / "tiny"
TINY = sorted(INSTANCES.glob("tiny-[0-9][0-9][0-9].json"))
DAY_S = 86400.0
RARE = (5034, 5065, 5505)
"""Where prizes come close to what a required target is worth, and where staying is best."""

exact_methods = pytest.mark.parametrize("method", [mip, cpsat])
all_methods = pytest.mark.parametrize("method", [mip, cpsat, routing_bound])


@pytest.fixture(autouse=True)
def _mip_extra(request):
    """Tests of the mip method need its extra."""
    if "mip" in request.node.name:
        pytest.importorskip("pyomo")
        pytest.importorskip("highspy")


def prove(method, mission, **options):
    """Run a method to its end."""
    return call(method, mission, **{"stop": MaxRuntime(60.0), **options})


def random_mission(seed, *, zones=True):
    """2–6 targets, a random tank and mission; zones, unequal and non-integer prizes by turns."""
    rng = np.random.default_rng(seed)
    targets = int(rng.integers(2, 7))
    instance = adr_opt.generate("tiny", seed, targets=targets, zones=3 * (zones and seed % 3 == 0))
    limits = {
        "duration_s": DAY_S * float(rng.uniform(0.5, 2.0 if targets < 5 else 1.5)),
        "delta_v_m_s": float(rng.uniform(300.0, 1500.0)),
    }
    prizes = [
        np.ones(targets),
        rng.integers(0, 6, targets) * 2.0,
        np.round(rng.uniform(0.0, 3.0, targets), 3),
    ][seed % 4 % 3]
    return Mission(
        instance.replace(
            targets=tuple(
                target.replace(prize=float(prize))
                for target, prize in zip(instance.targets, prizes, strict=True)
            ),
        ).with_limits(**limits),
        threads=1,
    )


def featured_mission(seed):
    """A random mission with several stations or none, a start of its own, windows, ends by turns.

    Some of its targets are required, some share an orbit, some are worth nothing.
    """
    rng = np.random.default_rng([7, seed])
    instance = random_mission(seed).instance
    targets = instance.targets
    if seed % 5 == 0:
        targets = (targets[0], targets[1].replace(orbit=targets[0].orbit), *targets[2:])
    duration = instance.mission.duration_s
    stations = instance.stations[: int(rng.integers(0, 2))]
    if len(targets) > 2 and rng.random() < 0.4:
        stations += (Station(name="second", orbit=targets[-1].orbit),)
        targets = targets[:-1]
    start = InOrbit(orbit=instance.stations[0].orbit)
    if stations and rng.random() < 0.6:
        start = AtStation(station=stations[int(rng.integers(len(stations)))].name)
    end = "anywhere"
    if stations and rng.random() < 0.5:
        end = AtStation(station=stations[int(rng.integers(len(stations)))].name)
    if rng.random() < 0.5:
        opens = rng.uniform(0.0, 0.6, len(targets)) * duration
        closes = opens + rng.uniform(0.05, 0.9, len(targets)) * duration
        targets = tuple(
            target.replace(window_s=(float(opens[at]), float(closes[at]) if at % 3 else None))
            for at, target in enumerate(targets)
        )
    if rng.random() < 0.3:
        targets = (*targets[:-1], targets[-1].replace(required=True))
    begin = float(rng.choice([0.0, 0.2])) * duration * float(rng.random())
    chaser = Chaser(
        name="chaser",
        start=start,
        end=end,
        available_s=(begin, None if seed % 2 else 0.9 * duration),
        max_targets=[None, None, 1, 2][int(rng.integers(4))],
        tank=instance.chaser.tank,
    )
    return Mission(
        instance.replace(stations=stations, targets=targets, chasers=(chaser,)), threads=1
    )


def network_of(mission):
    """The network of a mission, as the models get it."""
    return of_rows(build(mission, jobs=1), mission.rules)


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


@exact_methods
@pytest.mark.parametrize("path", TINY, ids=lambda path: path.stem)
def test_tiny_family(method, path):
    """On every committed tiny instance the optimum is proven, with and without a start plan."""
    mission = Mission(adr_opt.load(path), threads=1)
    optimum, _, best = brute_force(mission)
    assert has_proven(prove(method, mission), mission, optimum)
    assert has_proven(prove(method, mission, start=best), mission, optimum)
    assert has_proven(prove(method, mission, start=best[:1]), mission, optimum)


@exact_methods
@pytest.mark.parametrize("start", [None, (), OPTIMAL_PLAN])
def test_hand_made(method, start):
    """The optimum worked out on paper is found and proven; its plan is the only one."""
    mission = Mission(hand_made(), threads=1)
    result = prove(method, mission, start=start)
    assert has_proven(result, mission, OPTIMUM)
    assert result.sequence == OPTIMAL_PLAN


@exact_methods
@pytest.mark.parametrize("seed", range(24))
def test_random_missions(method, seed):
    """With zones, unequal and non-integer prizes the methods equal brute force."""
    mission = random_mission(seed)
    optimum, _, _ = brute_force(mission)
    assert has_proven(prove(method, mission), mission, optimum)


@exact_methods
@pytest.mark.parametrize("seed", range(12))
def test_reduced_networks(method, seed, monkeypatch):
    """With arcs removed by reduced costs, goal by goal, the methods still equal brute force."""
    monkeypatch.setattr(course, "WHOLE_LEGS", 0)
    mission = random_mission(seed)
    optimum, _, best = brute_force(mission)
    assert has_proven(prove(method, mission, jobs=1), mission, optimum)
    assert has_proven(prove(method, mission, jobs=1, start=best), mission, optimum)


@exact_methods
@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize("seed", [*range(40), *RARE])
def test_missions_with_every_feature(method, whole, seed, monkeypatch):
    """With several stations or none, windows, ends, a start of its own and few targets, too."""
    monkeypatch.setattr(course, "WHOLE_LEGS", 10**9 if whole and method is mip else 0)
    mission = featured_mission(seed)
    optimum, _, best = brute_force(mission)
    start = best if seed % 2 and optimum > -math.inf else None
    assert has_proven(prove(method, mission, jobs=1, start=start), mission, optimum)


@all_methods
@pytest.mark.parametrize("part", range(4))
def test_all_rules_at_random(method, part):
    """On the missions that all planners and bounds are tried on, they equal enumeration, too."""
    for seed in range(3000 + part, 3060, 4):
        mission = Mission(all_rules(seed), threads=1)
        optimum, _, _ = brute_force(mission)
        result = prove(method, mission)
        assert result.upper_bound >= optimum - 1e-9
        assert method is routing_bound or has_proven(result, mission, optimum)


@all_methods
@pytest.mark.parametrize("seed", range(100, 125))
def test_limits_that_the_best_plan_just_meets(method, seed, monkeypatch):
    """Where rounding decides whether the best plan fits, enumeration decides the same."""
    monkeypatch.setattr(course, "WHOLE_LEGS", 0 if seed % 2 else 1000)
    instance = resonant(seed)
    mission = Mission(instance, threads=1)
    _, _, best = brute_force(mission)
    if not best:
        pytest.skip("nothing can be reached")
    schedule, tanks = mission.time(best), [0.0]
    for j, delta_v in zip(best, schedule.delta_vs, strict=True):
        tanks[-1] += float(delta_v)
        if mission.rules.is_station[j]:
            tanks.append(0.0)
    rng = np.random.default_rng(seed)
    limits = []
    for limit in (max(tanks), float(schedule.ends[-1])):
        near = np.nextafter(limit, rng.choice([-np.inf, np.inf]))
        short = limit - rng.choice([0.0, 1e-12, 1e-9, 1.5e-6, 5e-5])
        limits.append(max(0.0, float(rng.choice([limit, near, short]))))
    tight = instance.with_limits(delta_v_m_s=limits[0], duration_s=limits[1])
    mission = Mission(tight, threads=1)
    optimum, _, _ = brute_force(mission)
    result = prove(method, mission)
    assert result.upper_bound >= optimum - 1e-9
    assert method is routing_bound or has_proven(result, mission, optimum)


def test_features_matter():
    """The missions above are not all alike: there are some of every kind, and many have plans."""
    missions = [featured_mission(seed) for seed in range(40)]
    optima = np.array([brute_force(mission)[0] for mission in missions])
    assert np.sum(optima == -math.inf) >= 3
    for kind in (
        lambda rules: rules.stations == 0,
        lambda rules: rules.stations == 2,
        lambda rules: rules.start == rules.stations > 0,
        lambda rules: rules.returns,
        lambda rules: rules.ready > 0.0,
        lambda rules: rules.most_targets == 1,
        lambda rules: rules.opens.max() > rules.ready,
        lambda rules: rules.closes.min() < rules.duration,
    ):
        of_kind = np.array([kind(mission.rules) for mission in missions])
        assert np.sum(optima[of_kind] > 0.0) >= 3


def fits(found, legs, rules):
    """Whether legs of a network keep to the tank, as the rules count it."""
    left = rules.budget
    for leg in legs:
        if found.delta_v[leg] > left:
            return False
        left -= found.delta_v[leg]
        if rules.is_station[found.body[found.landing[leg]]]:
            left = rules.budget
    return True


@pytest.mark.parametrize("mission_of", [random_mission, featured_mission])
@pytest.mark.parametrize("seed", range(60))
def test_network_holds_the_plans(seed, mission_of):
    """The best plan is a path of the network, whole or cut down, and such a path can be flown."""
    mission = mission_of(seed)
    _, _, best = brute_force(mission)
    rules = mission.rules
    whole = all_of(build(mission, jobs=1), rules)
    cut = network_of(mission)
    assert cut.legs <= whole.legs
    worthy = [j for j, prize in enumerate(rules.prize) if prize > 0.0]
    for found in (whole, cut):
        legs = path_of(found, best, rules)
        if found is whole or (best and best[-1] in worthy):
            assert len(legs) == len(best)
        assert fits(found, legs, rules)
        assert bodies_along(found, legs[::-1]) == best[: len(legs)]


@pytest.mark.parametrize("seed", range(60))
def test_paths_are_schedules(seed):
    """Every path of the network that visits no target twice can be flown as the rules have it."""
    mission = featured_mission(seed)
    rules, found = mission.rules, network_of(mission)
    rng = np.random.default_rng(seed)
    for _ in range(5):
        node, left, order, done = 0, rules.budget, [], False
        while not done:
            nodes = [node]
            while found.onward[nodes[-1]] >= 0:
                nodes.append(int(found.onward[nodes[-1]]))
            legs = np.concatenate(
                [np.arange(found.first[node], found.first[node + 1]) for node in nodes]
            )
            fresh = ~np.isin(found.destination[legs], [j for j in order if j >= rules.first_target])
            legs = legs[(found.delta_v[legs] <= left) & fresh]
            done = legs.size == 0 or len(order) == rules.most_targets
            if not done:
                leg = rng.choice(legs)
                node = int(found.landing[leg])
                order.append(int(found.body[node]))
                left = rules.budget if rules.is_station[order[-1]] else left - found.delta_v[leg]
        assert mission.time(order).made == len(order)


def test_a_network_without_what_is_needed_is_caught(monkeypatch):
    """If legs dominated one another whatever they cost, some best plan would be lost."""
    missions = [random_mission(seed) for seed in range(40)]
    plans = [brute_force(mission)[2] for mission in missions]

    def whatever_it_costs(pair, landing, delta_v, dominated):
        right(pair, landing, np.zeros_like(delta_v), dominated)

    right = network._dominated
    monkeypatch.setattr(network, "_dominated", whatever_it_costs)
    lost = 0
    for mission, best in zip(missions, plans, strict=True):
        lost += len(path_of(network_of(mission), best, mission.rules)) < len(best)
    assert lost > 0


@pytest.mark.parametrize("mission_of", [random_mission, featured_mission])
@pytest.mark.parametrize("seed", range(60))
def test_reduced_costs_never_remove_the_best_plan(seed, mission_of):
    """For any multipliers and slots every leg of the best plan may belong to one worth as much."""
    mission = mission_of(seed)
    optimum, _, best = brute_force(mission)
    rules, found = mission.rules, network_of(mission)
    legs = path_of(found, best, rules)
    if len(legs) < len(best) or optimum == -math.inf:
        pytest.skip("no plan, or one with moves that are of no use")
    optimum = mission.worth(optimum)
    rng = np.random.default_rng(seed)
    for highest, slot in ((0.0, 1.0), (0.3, 17.0), (4.0, 200.0)):
        multipliers = rng.uniform(0.0, highest, rules.prize.size)
        multipliers[: rules.first_target] = 0.0
        through = best_through(found, rules, multipliers, slot)
        assert np.all(through[legs] >= optimum - 1e-9)
        part = keep(found, can_reach(through, optimum), rules)
        assert len(path_of(part, best, rules)) == len(best)


def walks(found, rules, gain):
    """Value of all walks of a network without refuelling that do not go back at once, by leg."""
    most = np.full(found.legs, -math.inf)

    def go(node, left, value, before, behind, path):
        if path and rules.may_end[found.body[node]]:
            most[path] = np.maximum(most[path], value)
        while node >= 0:
            for leg in range(found.first[node], found.first[node + 1]):
                j = found.destination[leg]
                if found.delta_v[leg] <= left and j != before:
                    after = found.landing[leg]
                    ahead = left - found.delta_v[leg]
                    go(after, ahead, value + gain[j], behind, j, [*path, leg])
            node = found.onward[node]

    go(0, rules.budget, 0.0, -1, rules.start, [])
    return most


def test_reduced_costs_are_those_of_walks():
    """With fine slots, what comes out is the most of a walk through each leg that goes not back."""
    compared = 0
    for seed in range(60):
        instance = random_mission(seed).instance.with_limits(
            duration_s=0.6 * DAY_S, delta_v_m_s=700.0
        )
        start = InOrbit(orbit=instance.stations[0].orbit)
        alone = instance.replace(stations=(), chasers=(instance.chaser.replace(start=start),))
        mission = Mission(alone, threads=1)
        found = network_of(mission)
        if not 0 < found.legs < 400:
            continue
        multipliers = np.random.default_rng(seed).uniform(0.0, 1.0, mission.rules.prize.size)
        multipliers[0] = 0.0
        expected = walks(found, mission.rules, mission.rules.prize - multipliers)
        through = best_through(found, mission.rules, multipliers, 0.01)
        assert np.all(through >= expected + multipliers.sum() - 1e-9)
        compared += np.sum(np.abs(through - expected - multipliers.sum()) < 1e-6)
        assert np.mean(through <= expected + multipliers.sum() + 1e-6) > 0.9
    assert compared > 100


def test_reduced_costs_that_round_up_are_caught():
    """With the ΔV of legs too large by a slot, some leg of some best plan would be removed."""
    caught = 0
    for seed in range(60):
        mission = random_mission(seed)
        optimum, _, best = brute_force(mission)
        rules, found = mission.rules, network_of(mission)
        broken = found._replace(delta_v=found.delta_v + 100.0)
        through = best_through(broken, rules, np.zeros(rules.prize.size), 100.0)
        caught += np.any(through[path_of(found, best, rules)] < optimum - 1e-9)
    assert caught > 0


@pytest.mark.parametrize("seed", range(120))
def test_routing_bound_is_valid(seed):
    """Brute force lies under the static bound, whatever the zones, prizes, tank and duration."""
    mission = random_mission(1000 + seed)
    optimum, _, _ = brute_force(mission)
    result = prove(routing_bound, mission)
    assert optimum - 1e-9 <= result.upper_bound <= mission.total_prize + 1e-9
    assert result.plan is None


@pytest.mark.parametrize("seed", range(80))
def test_routing_bound_is_valid_with_every_feature(seed):
    """So it does with several stations or none, windows, ends, and a start of its own."""
    mission = featured_mission(1000 + seed)
    optimum, _, best = brute_force(mission)
    least = optimum - 1e-9
    assert prove(routing_bound, mission).upper_bound >= least
    if least > -math.inf:
        assert prove(routing_bound, mission, start=best).upper_bound >= least


@pytest.mark.parametrize("seed", range(30))
def test_static_costs_out_of_time(seed):
    """Costs known in closed form, where time is short, are nowhere above the best of all legs."""
    mission = featured_mission(seed)
    costs, quick = static_costs(mission), static_costs(mission, lambda: True)
    there = costs.delta_v >= 0
    assert np.all(quick.delta_v[there] >= 0)
    assert np.all(quick.delta_v[there] <= costs.delta_v[there])
    assert np.all(quick.duration[there] <= costs.duration[there])


def test_routing_bound_is_not_trivial():
    """With half the time it is less than all prizes on the tiny family; a start may meet it."""
    for path in TINY:
        instance = adr_opt.load(path)
        half = instance.with_limits(duration_s=0.5 * instance.mission.duration_s)
        mission = Mission(half, threads=1)
        assert prove(routing_bound, mission).upper_bound < mission.total_prize
    mission = Mission(hand_made(), threads=1)
    result = prove(routing_bound, mission, start=OPTIMAL_PLAN)
    assert (result.status, result.upper_bound) == ("optimal", OPTIMUM)


def test_static_costs_that_are_not_the_best_are_caught(monkeypatch):
    """Without the station, or with legs at twice their least time, the bound falls too low."""
    module = importlib.import_module("solvers.bounds.routing_bound")
    missions = [Mission(adr_opt.load(path), threads=1) for path in TINY]
    missions.append(Mission(hand_made(), threads=1))
    optima = [brute_force(mission)[0] for mission in missions]

    def stranded(mission, enough):
        costs = static_costs(mission, enough)
        costs.delta_v[1:, 0] = -1
        return costs

    def slow(mission, enough):
        costs = static_costs(mission, enough)
        return costs._replace(duration=np.where(costs.duration > 0, 2 * costs.duration, -1))

    for broken in (stranded, slow):
        monkeypatch.setattr(module, "static_costs", broken)
        bounds = [prove(routing_bound, mission).upper_bound for mission in missions]
        assert any(bound < optimum for bound, optimum in zip(bounds, optima, strict=True))


@all_methods
def test_no_targets(method):
    """Without targets the empty plan, or the bound 0, is proven at once."""
    mission = Mission(adr_opt.generate("tiny", 0, targets=0))
    result = prove(method, mission)
    assert result.upper_bound == 0.0
    if method is not routing_bound:
        assert (result.sequence, result.status) == ((), "optimal")


@all_methods
@pytest.mark.parametrize("change", [{"delta_v_m_s": 0.0}, {"duration_s": 0.0}])
def test_nothing_can_be_reached(method, change):
    """Without ΔV or without time the bound is 0."""
    instance = adr_opt.generate("tiny", 1)
    mission = Mission(instance.with_limits(**change))
    result = prove(method, mission)
    assert result.upper_bound == 0.0
    assert result.objective <= 0.0


@all_methods
def test_worthless_targets(method):
    """Where no prize is worth anything, the bound is 0."""
    instance = adr_opt.generate("tiny", 1)
    worthless = tuple(target.replace(prize=0.0) for target in instance.targets)
    assert prove(method, Mission(instance.replace(targets=worthless))).upper_bound == 0.0


@exact_methods
@pytest.mark.parametrize("prizes", [(1e12, 1.0), (1e-7, 3e-7), (1e9, 0.5), (6e6, 9e6)])
def test_prizes_of_any_size(method, prizes):
    """Prizes far from 1 and far apart: the bound is valid and the gap within the tolerance."""
    instance = adr_opt.generate("tiny", 4)
    targets = tuple(
        target.replace(prize=prizes[number % 2]) for number, target in enumerate(instance.targets)
    )
    mission = Mission(instance.replace(targets=targets))
    optimum, _, _ = brute_force(mission)
    result = prove(method, mission)
    assert optimum * (1.0 - 1e-12) <= result.upper_bound <= optimum + 1e-6 * max(1.0, optimum)
    assert result.status == "optimal"


@exact_methods
def test_a_tank_that_is_just_too_small(method):
    """Paths that exceed the tank by less than the solver can tell are ruled out, to a proof."""
    mission = Mission(hand_made(), threads=1)
    spent = 2.0 * (
        300.0
        - certify(mission, "x", OPTIMAL_PLAN, seed=0, runtime_s=0.0).plan.legs[0].delta_v_left_m_s
    )
    mission = Mission(hand_made(delta_v_m_s=spent - 1.05 * SLACK_M_S), threads=1)
    optimum, _, _ = brute_force(mission)
    result = prove(method, mission)
    assert optimum < OPTIMUM
    assert has_proven(result, mission, optimum)
    assert result.counters["forbidden"] > 0


@all_methods
def test_too_short_a_time_limit(method):
    """A limit too short for anything still gives a valid bound, and a plan stays legal."""
    mission = Mission(adr_opt.generate("reduced-time", 0, targets=15))
    began = time.monotonic()
    result = prove(method, mission, stop=MaxRuntime(1e-9))
    assert result.upper_bound == 15.0
    assert result.status != "optimal"
    result = prove(method, mission, stop=MaxRuntime(0.5))
    assert result.upper_bound <= 15.0
    assert result.objective <= result.upper_bound
    assert time.monotonic() - began < 20.0


@exact_methods
def test_an_interruption_ends_the_solver(method, monkeypatch):
    """Someone who says enough from outside, without a time limit, does not wait for the proof."""
    monkeypatch.setattr(course, "WHOLE_LEGS", 10**9)
    instance = adr_opt.generate("reduced-time", 0, targets=14)
    mission = Mission(instance.with_limits(duration_s=2.0 * DAY_S))
    stop = Interrupted()
    timer = threading.Timer(1.5, stop.interrupt)
    timer.start()
    began = time.monotonic()
    result = prove(method, mission, stop=stop, most_arcs=10**9)
    assert result.upper_bound <= 14.0
    assert result.status == "feasible"
    assert time.monotonic() - began < 60.0
    timer.cancel()


@exact_methods
def test_a_network_that_is_too_large(method):
    """What is too large for the solver is not tried: a bound, a plan, and a note that says so."""
    mission = Mission(adr_opt.generate("reduced-time", 0, targets=15))
    result = prove(method, mission, most_arcs=1, evaluations=20)
    assert result.upper_bound < 15.0
    assert result.counters["solves"] == 0
    assert result.status == "feasible"
    assert any("most_arcs = 1" in note for note in result.notes)


@exact_methods
def test_iterations_limit_the_work(method):
    """With a limit on iterations the same work is done twice, to the same result."""
    mission = Mission(adr_opt.generate("reduced-time", 0, targets=15))
    first, second = (prove(method, mission, stop=MaxIterations(3), most_arcs=1) for _ in range(2))
    assert first.counters["evaluations"] <= 3
    assert first.upper_bound == second.upper_bound
    assert first.sequence == second.sequence


@exact_methods
def test_progress_is_monotone(method):
    """The bound only falls and the incumbent only rises, down to the result."""
    mission = Mission(adr_opt.load(TINY[8]), threads=1)
    told = []
    result = prove(method, mission, progress=lambda *pair: told.append(pair))
    incumbents, bounds = zip(*told, strict=True)
    assert list(incumbents) == sorted(incumbents)
    assert list(bounds) == sorted(bounds, reverse=True)
    assert told[-1] == (result.objective, result.upper_bound)


def test_missing_extra(monkeypatch):
    """Without highspy the method says which extra to install."""
    module = sys.modules["solvers.planners.mip"]
    found = module.find_spec
    monkeypatch.setattr(
        module, "find_spec", lambda name: None if name == "highspy" else found(name)
    )
    with pytest.raises(MissingExtra, match=r"highspy.*\[mip\]"):
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
@exact_methods
def test_three_days_with_twenty_targets(method):
    """A reduced instance: goals are proven one after the other, within a margin of a visit."""
    mission = Mission(adr_opt.generate("reduced-time", 0, targets=20))
    result = prove(method, mission, stop=MaxRuntime(240.0))
    assert result.upper_bound == 12.0
    assert math.isfinite(result.objective)
    assert result.upper_bound - result.objective <= 1.0
