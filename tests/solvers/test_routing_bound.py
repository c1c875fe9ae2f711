"""The static bound is never below the optimum, and no trivial one."""

from __future__ import annotations

import importlib
import math

import numpy as np
import pytest
from brute_force import brute_force
from calling import prove
from hand_made import OPTIMAL_PLAN, OPTIMUM, hand_made
from seeds import over_seeds
from small_missions import TINY, random_mission, ruled_mission

import adr_opt
from adr_opt.mission.mission import Mission
from solvers.bounds.routing_bound import routing_bound, static_costs


@over_seeds(range(120), gate=6)
def test_routing_bound_is_valid(seed):
    """Brute force lies under the static bound, whatever the zones, prizes, tank and duration."""
    mission = random_mission(1000 + seed)
    optimum, _, _ = brute_force(mission)
    result = prove(routing_bound, mission)
    assert optimum - 1e-9 <= result.upper_bound <= mission.total_prize + 1e-9
    assert result.plan is None


@over_seeds(range(80), gate=6)
def test_routing_bound_is_valid_with_every_feature(seed):
    """So it does with several stations or none, windows, ends, and a start of its own."""
    mission = ruled_mission(1000 + seed)
    optimum, _, best = brute_force(mission)
    least = optimum - 1e-9
    assert prove(routing_bound, mission).upper_bound >= least
    if least > -math.inf:
        assert prove(routing_bound, mission, start=best).upper_bound >= least


@over_seeds(range(30), gate=3)
def test_static_costs_out_of_time(seed):
    """Costs known in closed form, where time is short, are nowhere above the best of all legs."""
    mission = ruled_mission(seed)
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


@pytest.mark.slow
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
