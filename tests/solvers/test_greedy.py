"""Greedy planners: as published, and with the guard that keeps the way back open."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from brute_force import brute_force
from calling import call
from hand_made import BEYOND, NORTH, SOUTH, STATION, hand_made
from random_rules import random_mission

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.stop import MaxIterations
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from adr_opt.run.methods import get


def plan(mission: Mission, method: str, **options: Any) -> Result:
    """Plan with a method that ends by itself."""
    return call(get(method), mission, stop=MaxIterations(1), **options)


@pytest.fixture(scope="module")
def hand() -> Mission:
    return Mission(hand_made(), threads=1)


@pytest.fixture(scope="module")
def fields() -> list[Mission]:
    return [Mission(adr_opt.generate("nominal", seed), threads=1) for seed in range(5)]


def test_published_greedy_strands_itself(hand: Mission) -> None:
    """It takes north first, the first listed of the cheapest, goes on to beyond and is stranded."""
    result = plan(hand, "greedy")
    assert result.sequence == (NORTH, BEYOND)
    assert result.plan is not None
    assert result.plan.legs[-1].delta_v_left_m_s < 40.0
    assert result.status == "feasible"


def test_guarded_greedy_comes_back(hand: Mission) -> None:
    """It refuels after north, because from beyond nothing leads back, and then takes south."""
    result = plan(hand, "greedy-guarded")
    assert result.sequence is not None
    assert result.sequence[:3] == (NORTH, STATION, SOUTH)
    assert result.objective == 2.0


def test_guard_gives_way_at_the_end() -> None:
    """With time for a single move and no tank for the way back, an unguarded target is taken."""
    mission = Mission(hand_made(periods=3.2, delta_v_m_s=200.0), threads=1)
    result = plan(mission, "greedy-guarded")
    assert result.sequence == (NORTH,)


def test_time_alone_is_a_cost() -> None:
    """With α = 0 the quickest target is taken first, whatever its ΔV."""
    mission = Mission(adr_opt.generate("nominal", 0), threads=1)
    first = {}
    for name, weights in (("ΔV", {}), ("time", {"alpha": 0.0, "beta": 1.0})):
        sequence = plan(mission, "greedy", **weights).sequence
        assert sequence
        first[name] = mission.timetable.lookup(STATION, sequence[0], 0.0)
    assert first["time"][1] < first["ΔV"][1]
    assert first["time"][0] > first["ΔV"][0]
    arrivals = [mission.timetable.lookup(STATION, j, 0.0)[1] for j in range(1, 51)]
    assert first["time"][1] == min(arrivals)


def test_first_move_is_the_cheapest(fields: list[Mission]) -> None:
    """No target is cheaper to go to at first by the connections that greedy chooses from."""
    mission = fields[0]
    targets = range(1, len(mission.names))
    delta_v = [mission.timetable.lookup(STATION, j, 0.0)[0] for j in targets]
    result = plan(mission, "greedy")
    assert result.sequence is not None
    assert result.sequence[0] == 1 + int(np.argmin(delta_v))


@pytest.mark.slow
def test_published_order_of_the_planners(fields: list[Mission]) -> None:
    """On nominal fields greedy visits less than guarded greedy, and that at most what beam does."""
    for mission in fields:
        poor = plan(mission, "greedy").objective
        guarded = plan(mission, "greedy-guarded").objective
        wide = plan(mission, "beam", width=500).objective
        assert poor < guarded <= wide


def test_no_refuelling_that_nothing_follows(fields: list[Mission]) -> None:
    """No plan ends at the station: a refuelling is only worth what is visited after it."""
    for mission in fields:
        for method in ("greedy", "greedy-guarded"):
            sequence = plan(mission, method).sequence
            assert sequence
            assert sequence[-1] != STATION


def with_required(seed: int, share: float) -> Mission:
    """A random mission with a share of required targets."""
    instance, rng = random_mission(seed), np.random.default_rng(seed)
    targets = tuple(
        target.replace(required=bool(rng.random() < share)) for target in instance.targets
    )
    return Mission(instance.replace(targets=targets), threads=1)


@pytest.mark.parametrize("method", ["greedy", "greedy-guarded"])
def test_required_targets_come_first_when_time_presses(method: str) -> None:
    """Most missions that have a plan with all required targets get one.

    By paying no attention to what is required less than half of them do; none of those is lost.
    """
    feasible = found = by_chance = 0
    for seed in range(100):
        mission = with_required(seed, 0.4)
        if not mission.required or not math.isfinite(brute_force(mission)[0]):
            continue
        feasible += 1
        result = plan(mission, method)
        if result.plan is not None:
            found += 1
            assert adr_opt.check(mission.instance, result.plan) == ()
        bare = with_required(seed, 0.0)
        unaware = mission.closed(plan(bare, method).sequence or ())
        if not mission.lacking(unaware) and mission.may_stop(unaware):
            by_chance += 1
            assert result.plan is not None, seed
    assert feasible > 10
    assert by_chance < 0.5 * feasible
    assert found > 0.7 * feasible


def test_a_required_target_waits_where_there_is_time(fields: list[Mission]) -> None:
    """One far target of fifty is serviced, and costs no more than a few of the others."""
    mission = fields[0]
    usual = plan(mission, "greedy-guarded")
    missing = max(set(range(1, 51)) - set(usual.sequence or ()))
    targets = list(mission.instance.targets)
    targets[missing - 1] = targets[missing - 1].replace(required=True)
    instance = mission.instance.replace(targets=tuple(targets))
    result = plan(Mission(instance, threads=1), "greedy-guarded")
    assert result.sequence is not None
    assert missing in result.sequence
    assert result.sequence[:3] == (usual.sequence or ())[:3]
    assert result.objective >= usual.objective - 4.0


@pytest.mark.parametrize("method", ["greedy", "greedy-guarded"])
def test_another_time_value_is_another_layer(fields: list[Mission], method: str) -> None:
    """A time value makes greedy choose from other connections; the instance's own is the default.

    What is no finite number is refused.
    """
    mission = fields[0]
    usual = plan(mission, method)
    own = mission.instance.time_value_m_s_per_h
    assert plan(mission, method, time_value_m_s_per_h=own).sequence == usual.sequence
    assert plan(mission, method, time_value_m_s_per_h=1000.0).sequence != usual.sequence
    for value in (math.nan, math.inf):
        with pytest.raises(InputError, match="time_value_m_s_per_h"):
            plan(mission, method, time_value_m_s_per_h=value)
