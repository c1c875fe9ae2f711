"""The network of the exact models holds the plans, and reduced costs remove none of the best."""

from __future__ import annotations

import math

import numpy as np
import pytest
from brute_force import brute_force
from seeds import over_seeds
from small_missions import DAY_S, network_of, random_mission, ruled_mission

from adr_opt.mission.mission import Mission
from adr_opt.problem.chasers import InOrbit
from solvers.models import solver_network
from solvers.models.reduction import best_through, can_reach
from solvers.models.solver_network import all_of, bodies_along, keep, path_of
from solvers.networks.network import build


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


@pytest.mark.parametrize("mission_of", [random_mission, ruled_mission])
@over_seeds(range(60), gate=6)
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


@over_seeds(range(60), gate=6)
def test_paths_are_schedules(seed):
    """Every path of the network that visits no target twice can be flown as the rules have it."""
    mission = ruled_mission(seed)
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
            done = legs.size == 0 or len(order) == rules.limits.targets
            if not done:
                leg = rng.choice(legs)
                node = int(found.landing[leg])
                order.append(int(found.body[node]))
                left = rules.budget if rules.is_station[order[-1]] else left - found.delta_v[leg]
        assert mission.time(order).made == len(order)


def test_a_network_without_what_is_needed_is_caught(monkeypatch):
    """If legs dominated one another whatever they cost, some best plan would be lost."""

    def whatever_it_costs(pair, landing, delta_v, dominated):
        right(pair, landing, np.zeros_like(delta_v), dominated)

    def lost(seed):
        mission = random_mission(seed)
        best = brute_force(mission)[2]
        return len(path_of(network_of(mission), best, mission.rules)) < len(best)

    right = solver_network._dominated
    monkeypatch.setattr(solver_network, "_dominated", whatever_it_costs)
    assert any(map(lost, range(40)))


@pytest.mark.parametrize("mission_of", [random_mission, ruled_mission])
@over_seeds(range(60), gate=6)
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

    def caught(seed):
        mission = random_mission(seed)
        optimum, _, best = brute_force(mission)
        rules, found = mission.rules, network_of(mission)
        broken = found._replace(delta_v=found.delta_v + 100.0)
        through = best_through(broken, rules, np.zeros(rules.prize.size), 100.0)
        return np.any(through[path_of(found, best, rules)] < optimum - 1e-9)

    assert any(map(caught, range(60)))
