"""Beam search: legal, deterministic, optimal where it is wide enough to keep everything."""

from __future__ import annotations

import dataclasses
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from brute_force import brute_force
from calling import call
from hand_made import hand_made
from on_a_layer import best_on_layer
from varied_fields import variant

import adr_opt
from adr_opt.common.constants import STATION
from adr_opt.common.stop import MaxIterations, MaxRuntime
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from solvers.beams import timely_beams
from solvers.beams.beams import TIME_VALUE_M_S_PER_H, BeamSettings, beam_search, usual_settings
from solvers.planners.beam import beam
from solvers.walks.latest_times import latest_of
from solvers.walks.walks import WalkBound

TINY = sorted((Path(__file__).parents[2] / "instances" / "tiny").glob("*.json"))


def plan(mission: Mission, **options: Any) -> Result:
    """Search one beam."""
    return call(beam, mission, **{"stop": MaxIterations(1), **options})


@pytest.fixture(scope="module")
def nominal() -> Mission:
    return Mission(adr_opt.generate("nominal", 0), threads=1)


@pytest.mark.parametrize("width", [1, 2, 7, 64, 500])
def test_every_width_gives_a_legal_plan(nominal: Mission, width: int) -> None:
    """Whatever the width, the plan passes the check and does not end with a refuelling."""
    result = plan(nominal, width=width)
    assert result.plan is not None
    assert adr_opt.check(nominal.instance, result.plan) == ()
    assert result.sequence
    assert result.sequence[-1] != STATION


def test_wide_beams_find_more(nominal: Mission) -> None:
    """A beam of width 500 is at least as good as one of width 1, and finds 29 visits."""
    narrow, wide = plan(nominal, width=1), plan(nominal, width=500)
    assert narrow.objective < wide.objective
    assert wide.objective >= 29.0


def test_nothing_is_left_to_chance(nominal: Mission) -> None:
    """The same call gives the same plan; the seed matters where there is noise."""
    assert plan(nominal, width=60).sequence == plan(nominal, width=60).sequence
    noisy = [plan(nominal, seed=seed, width=60, noise=0.3).sequence for seed in (1, 1, 2, 3)]
    assert noisy[0] == noisy[1]
    assert len(set(noisy)) > 1


@pytest.fixture(scope="module")
def large() -> Mission:
    """A field whose widest beams take many seconds."""
    made = Mission(adr_opt.generate("nominal", 0, targets=120))
    assert made.rules.prize.size == 121
    return made


@pytest.mark.slow
def test_a_search_under_way_is_hurried_to_its_end(large: Mission) -> None:
    """A search that is out of time ends soon all the same, with a plan to the mission's end."""
    plan(large, width=10)
    began = time.process_time()
    found, value, _, _ = beam_search(large, BeamSettings(150_000, 0.17, 0.38), stop=MaxRuntime(0.3))
    assert time.process_time() - began < 4.0
    assert value >= adr_opt.solve(large, "greedy-guarded").objective
    assert large.time(found).made == found.size


def test_a_beam_is_as_wide_as_the_time_allows(
    large: Mission, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A second on 120 targets: a narrow search tells the pace, and the wide one is in time."""
    widths = []

    def spied(mission: Mission, settings: BeamSettings, **more: Any) -> Any:
        widths.append(settings.width)
        return beam_search(mission, settings, **more)

    monkeypatch.setattr(timely_beams, "beam_search", spied)
    began = time.process_time()
    result = adr_opt.solve(large, "beam", time_limit=1.0, width=1_000_000)
    assert time.process_time() - began < 3.0
    assert widths[0] == timely_beams.PILOT_WIDTH
    assert 1 <= widths[1] < 100_000
    assert result.objective > adr_opt.solve(large, "greedy-guarded").objective
    assert not any("ran out of time" in note for note in result.notes)


def test_time_enough_changes_nothing(nominal: Mission) -> None:
    """A limit that is far away gives the plan that no limit gives."""
    limited = plan(nominal, stop=MaxRuntime(1000.0), width=300)
    assert limited.sequence == plan(nominal, width=300).sequence
    assert limited.counters == plan(nominal, width=300).counters


def test_wide_enough_for_small_fields() -> None:
    """Width 200 finds nearly all that its layer has on tiny instances, and never more."""
    instances = [adr_opt.load(path) for path in TINY] + [variant(seed) for seed in range(20)]
    found = possible = 0.0
    for instance in instances:
        mission = Mission(instance, threads=1)
        best = best_on_layer(mission, TIME_VALUE_M_S_PER_H)
        value = plan(mission, width=200).objective
        assert value <= best + 1e-9 <= brute_force(mission)[0] + 2e-9
        found, possible = found + value, possible + best
    assert found >= 0.98 * possible


def test_the_guard_keeps_narrow_beams_from_stranding_themselves() -> None:
    """With little fuel a narrow guarded beam finds a fifth more than one without a guard."""
    guarded = BeamSettings(10, 0.17, 0.38)
    unguarded = dataclasses.replace(guarded, guarded=False)
    found = {guarded: 0.0, unguarded: 0.0}
    for seed in range(4):
        mission = Mission(adr_opt.generate("reduced-fuel", seed))
        for settings in found:
            found[settings] += beam_search(mission, settings)[1]
    assert found[guarded] > 1.2 * found[unguarded]


@pytest.mark.slow
def test_zones_are_waited_out() -> None:
    """A station that is closed for a while strands nobody: beams stay near optimal."""
    lost = 0.0
    for seed in range(4):
        mission = Mission(adr_opt.generate("reduced-time", seed, zones=6))
        optimal = adr_opt.solve(mission, "exact", time_limit=60.0)
        assert optimal.status == "optimal"
        lost += optimal.objective - plan(mission, width=1000).objective
    assert lost <= 1.0


def test_a_guided_beam_finds_no_less() -> None:
    """Guided by latest times, with the optimum as its goal, a beam finds as much in sum."""
    guided = unguided = 0.0
    for seed in range(20):
        mission = Mission(variant(seed), threads=1)
        bound = WalkBound(mission, 20.0)
        value, multipliers = bound.evaluate(np.zeros(len(mission.names)))
        latest = latest_of(bound, mission, multipliers, value)._replace(
            goal=brute_force(mission)[0]
        )
        settings = usual_settings(mission, 100)
        guided += beam_search(mission, settings, guide=latest)[1]
        unguided += beam_search(mission, settings)[1]
    assert guided >= unguided > 0.0


def test_a_way_back_is_preferred_not_required() -> None:
    """Where no target leaves enough for the way back, the beam still visits one."""
    stranded = Mission(hand_made(periods=20.0, delta_v_m_s=140.0), threads=1)
    assert brute_force(stranded)[0] == 1.0
    assert plan(stranded, width=10).objective == 1.0


def test_no_crowding_limit_keeps_the_whole_width(nominal: Mission) -> None:
    """An infinite crowding is the same as a very large one: no body has a limit."""
    for width in (30, 300):
        free, large = (
            plan(nominal, width=width, crowding=crowding) for crowding in (1e9, math.inf)
        )
        assert free.sequence == large.sequence
        assert free.counters == large.counters


@pytest.mark.parametrize("keep", [1, 2, 5, 12, 20])
def test_prefix_is_kept(nominal: Mission, keep: int) -> None:
    """A search from a legal beginning keeps it, and its plan is legal as a whole."""
    settings = BeamSettings(100, 0.17, 0.38)
    whole = plan(nominal, width=100).sequence
    assert whole is not None
    prefix = whole[:keep]
    found, value, delta_v, _ = beam_search(nominal, settings, prefix=prefix)
    assert tuple(found[:keep]) == whole[:keep]
    timing = nominal.time(found)
    assert timing.made == len(found) > keep
    assert timing.objective == value
    # The plan as a whole may be flown at a better schedule than the search knows.
    assert timing.delta_v <= delta_v + 1e-6


def test_prefix_of_everything() -> None:
    """A beginning that visits all targets comes back as it is."""
    mission = Mission(hand_made(periods=40.0), threads=1)
    _, _, whole = brute_force(mission)
    found, value, _, _ = beam_search(mission, BeamSettings(10, 0.17, 0.38), prefix=whole)
    assert tuple(found) == whole
    assert value == 3.0


def test_more_than_64_targets() -> None:
    """Sets of visited targets may take more than one machine word."""
    instance = adr_opt.generate("nominal", 0, targets=70)
    mission = Mission(instance.with_limits(duration_s=2.0 * 86400.0), threads=1)
    result = plan(mission, width=200)
    assert result.plan is not None
    assert adr_opt.check(mission.instance, result.plan) == ()
    assert result.objective >= 9.0
    # Among the last targets alone, the others being worth nothing, it visits several.
    last = mission.instance.replace(
        targets=tuple(
            target.replace(prize=float(number >= 64))
            for number, target in enumerate(mission.instance.targets, start=1)
        )
    )
    assert plan(Mission(last, threads=1), width=200).objective >= 3.0
