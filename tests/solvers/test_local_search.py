"""Local search: whatever search a mission has, plans are legal and nothing gets worse."""

from __future__ import annotations

from typing import Any

import pytest
from brute_force import brute_force
from calling import call

import adr_opt
from adr_opt.common.progress import silent
from adr_opt.common.stop import MaxIterations
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from adr_opt.run.methods import get
from solvers.planners.local_search import local_search


@pytest.fixture(scope="module")
def field() -> Mission:
    """50 targets and a small tank: every plan has to refuel."""
    return Mission(adr_opt.generate("reduced-fuel", 0), threads=1)


@pytest.fixture(scope="module")
def guarded(field: Mission) -> tuple[int, ...]:
    """The guarded greedy plan of the field."""
    stop = MaxIterations(1)
    sequence = get("greedy-guarded")(field, seed=0, stop=stop, progress=silent).sequence
    assert sequence
    return sequence


def improve(mission: Mission, iterations: int = 2, seed: int = 0, **options: Any) -> Result:
    """Search with a reproducible limit."""
    stop = MaxIterations(iterations)
    return call(local_search, mission, seed=seed, stop=stop, **options)


@pytest.mark.parametrize("seed", range(3))
def test_start_plan_is_never_worsened(field: Mission, guarded: tuple[int, ...], seed: int) -> None:
    """From any start plan, good, short or empty, the result is legal and at least as good."""
    for start in (guarded, guarded[:7], ()):
        result = improve(field, 1, seed, start=start, width=10)
        assert result.plan is not None
        assert adr_opt.check(field.instance, result.plan) == ()
        assert result.objective >= field.time(start).objective


def test_it_improves_greedy(field: Mission, guarded: tuple[int, ...]) -> None:
    """A few iterations collect more than the guarded greedy plan that it begins with."""
    assert improve(field, 3).objective > field.time(guarded).objective


@pytest.mark.parametrize("seed", range(8))
def test_it_finds_the_optimum_of_tiny_instances(seed: int) -> None:
    """On tiny instances it finds what brute force finds."""
    mission = Mission(adr_opt.generate("tiny", seed), threads=1)
    assert improve(mission).objective == brute_force(mission)[0]


def test_it_recovers_a_target_left_out_where_planes_drift() -> None:
    """Where planes drift a plan that lost a target gets as good again."""
    instance = adr_opt.generate("sso", 1, targets=16).with_limits(duration_s=100 * 86400.0)
    mission = Mission(instance, threads=1)
    best = improve(mission).sequence
    assert best
    shorter = best[:-1]
    assert mission.time(shorter).objective < mission.time(best).objective
    again = improve(mission, start=shorter)
    assert again.objective >= mission.time(best).objective
    assert again.plan is not None
    assert adr_opt.check(instance, again.plan) == ()
