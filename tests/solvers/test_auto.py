"""The default planner: anytime, reproducible under a work limit, and it knows when it is done."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from brute_force import brute_force
from calling import call
from hand_made import OPTIMUM, hand_made
from seeds import over_seeds

import adr_opt
from adr_opt.common.progress import silent
from adr_opt.common.stop import AnyOf, Interrupted, MaxIterations, MaxRuntime
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from adr_opt.run.method_call import warm_up
from adr_opt.run.methods import PLANNERS
from solvers.beams import timely_beams
from solvers.planners import one_route
from solvers.planners.auto import auto
from solvers.planners.beam import beam

TINY = sorted((Path(__file__).parents[2] / "instances" / "tiny").glob("*.json"))


def plan(mission: Mission, iterations: int = 50, seed: int = 0, **options: Any) -> Result:
    """Plan with a reproducible limit, on one core unless told otherwise."""
    stop = AnyOf(MaxIterations(iterations), MaxRuntime(60.0))
    return call(auto, mission, seed=seed, stop=stop, **{"jobs": 1, **options})


@pytest.fixture(scope="module")
def field() -> Mission:
    """A field that is not proven within a round."""
    instance = adr_opt.generate("nominal", 1, targets=30)
    return Mission(instance.with_limits(duration_s=3.0 * 86400.0, delta_v_m_s=1500.0), threads=1)


@pytest.mark.parametrize("path", TINY, ids=lambda path: path.stem)
def test_tiny_instances_are_proven(path: Path) -> None:
    """Every committed tiny instance ends by itself as optimal, with brute force's objective."""
    mission = Mission(adr_opt.load(path), threads=1)
    result = plan(mission)
    assert result.status == "optimal"
    assert result.objective == brute_force(mission)[0]
    assert result.upper_bound >= result.objective


@over_seeds(range(2), gate=1)
def test_never_behind_beam(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A single round does every search of the planner beam, and keeps what is best."""
    searched: list[timely_beams.BeamSettings] = []
    search = timely_beams.beam_search

    def spied(mission: Mission, settings: timely_beams.BeamSettings, **more: Any) -> Any:
        searched.append(settings)
        return search(mission, settings, **more)

    monkeypatch.setattr(timely_beams, "beam_search", spied)
    mission = Mission(adr_opt.generate("nominal", seed, zones=6 * seed), threads=1)
    alone = beam(mission, seed=0, stop=MaxIterations(1), progress=silent)
    of_beam = set(searched)
    assert len(of_beam) == 2
    searched.clear()
    assert plan(mission, 2, prove=False).objective >= alone.objective
    assert of_beam <= set(searched)


def test_what_is_told_never_gets_worse(field: Mission) -> None:
    """On two cores, too, incumbents rise, bounds fall, and both end at the result."""
    heard: list[tuple[float, float]] = []
    result = call(
        auto,
        field,
        stop=MaxIterations(4),
        jobs=2,
        progress=lambda incumbent, bound: heard.append((incumbent, bound)),
    )
    incumbents, bounds = zip(*heard, strict=True)
    assert list(incumbents) == sorted(incumbents)
    assert list(bounds) == sorted(bounds, reverse=True)
    assert len(set(heard)) == len(heard)
    assert incumbents[-1] == result.objective
    assert bounds[-1] == result.upper_bound


def test_a_poor_start_plan_does_no_harm(field: Mission) -> None:
    """The guarded greedy plan is taken where the start plan is worse."""
    first = plan(field, 4).sequence
    assert first is not None
    assert plan(field, 1, start=first[:1]).objective >= 5.0


def test_interrupted_in_the_middle(field: Mission) -> None:
    """Interrupted by whoever hears of the first bound, it ends soon with what there is."""
    stop = Interrupted()

    def hear(incumbent: float, bound: float) -> None:
        if bound < field.total_prize:
            stop.interrupt()

    result = call(auto, field, stop=AnyOf(stop, MaxRuntime(30.0)), progress=hear, jobs=1)
    assert stop.is_set
    assert result.counters["rounds"] == 1
    assert result.plan is not None
    assert adr_opt.check(field.instance, result.plan) == ()
    assert math.isfinite(result.upper_bound)


@pytest.mark.slow
def test_without_a_proof(field: Mission) -> None:
    """Without proving it only searches: no bound, as good a plan as guarded greedy at least."""
    result = plan(field, 5, prove=False)
    assert result.upper_bound == math.inf
    assert "labels" not in result.counters
    assert result.objective >= adr_opt.solve(field, "greedy-guarded").objective
    everything = plan(Mission(hand_made(), threads=1), 5, prove=False)
    assert everything.objective == OPTIMUM


def test_proof_and_search_help_each_other(field: Mission) -> None:
    """With a proof the plan is at least as good as without, and the bound is above both."""
    proving, searching = plan(field, 4), plan(field, 4, prove=False)
    assert proving.objective >= searching.objective
    assert proving.upper_bound >= proving.objective


@pytest.mark.slow
def test_on_one_core_the_beam_comes_before_the_proof(monkeypatch):
    """A proof that takes all the time there is cannot keep auto from the beam of `beam`."""
    warm_up(PLANNERS, "auto")  # whose practice is not looked at
    done = []
    usual, advance = one_route.RouteSearches.usual, one_route.ConcurrentProof.advance

    def searching(self, width):
        done.append(width)
        usual(self, width)

    def proving(self):
        done.append("proof")
        advance(self)

    monkeypatch.setattr(one_route.RouteSearches, "usual", searching)
    monkeypatch.setattr(one_route.ConcurrentProof, "advance", proving)
    mission = Mission(adr_opt.generate("nominal", 0, targets=30))
    adr_opt.solve(mission, "auto", jobs=1, iterations=2, time_limit=60.0)
    assert "proof" in done
    assert done.index(one_route.USUAL_WIDTH) < done.index("proof")
