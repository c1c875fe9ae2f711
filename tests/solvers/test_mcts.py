"""Monte Carlo tree search: legal, reproducible, as published by default, strong when tuned."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from brute_force import brute_force
from calling import call
from on_a_layer import best_on_layer

import adr_opt
from adr_opt.common.stop import MaxIterations
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from solvers.planners.mcts import mcts
from solvers.planners.mcts import policy as policies
from solvers.planners.mcts.settings import PUBLISHED

EVERY_WORD = [
    {"rollout": "guarded"},
    {"moves": "guarded", "width": 2},
    {"play": "value"},
    {"scale": "range", "best_share": 1.0},
    {"tree": "kept", "answer": "best"},
    {"missions": 3},
    {"preset": "tuned", "simulations": 50, "rollout": "uniform", "moves": "legal"},
]


def plan(mission: Mission, iterations: int = 200, seed: int = 0, **options: Any) -> Result:
    """Plan with a reproducible limit."""
    stop = MaxIterations(iterations)
    return call(mcts, mission, seed=seed, stop=stop, **options)


@pytest.fixture(scope="module")
def nominal() -> Mission:
    return Mission(adr_opt.generate("nominal", 0))


@pytest.fixture(scope="module")
def tiny() -> Mission:
    return Mission(adr_opt.generate("tiny", 0, zones=2))


def test_published_numbers():
    """The default preset has the numbers and the rollouts that the study states."""
    stated = (PUBLISHED.c, PUBLISHED.simulations, PUBLISHED.depth, PUBLISHED.rollout)
    assert stated == (1.5, 200, 15, "uniform")


def test_published_is_default(nominal):
    """Without options, the published search is flown, and giving its numbers changes nothing."""
    result = plan(nominal)
    again = plan(
        nominal,
        preset="published",
        simulations=200,
        depth=15,
        c=1.5,
        rollout="uniform",
        moves="legal",
        play="visits",
        scale="none",
        tree="new",
        missions=1,
        answer="played",
    )
    assert result.sequence == again.sequence
    assert result.counters["missions"] == 1
    # One step for every move, and one that finds no move left.
    assert result.counters["steps"] == len(result.sequence) + 1


def test_published_visits(nominal):
    """The published search visits about 20 of 50 targets: more than greedy, less than tuned."""
    mean = np.mean([plan(nominal, seed=seed).objective for seed in range(5)])
    assert 18.0 <= mean <= 22.0


def test_tuned_visits(nominal):
    """One tuned mission of the first nominal field visits at least 28 targets."""
    assert plan(nominal, iterations=50, preset="tuned").objective >= 28.0


@pytest.mark.parametrize("seed", range(6))
def test_tuned_finds_tiny_optimum(seed):
    """On tiny instances the tuned search finds all that there is on the layer it moves on."""
    mission = Mission(adr_opt.generate("tiny", seed))
    result = plan(mission, iterations=100, seed=seed, preset="tuned")
    assert result.objective == best_on_layer(mission) <= brute_force(mission)[0]


@pytest.mark.parametrize("seed", range(6))
def test_guard_costs_nothing_on_tiny(seed):
    """Searching all legal moves with uniform rollouts finds no more than the guarded search."""
    mission = Mission(adr_opt.generate("tiny", seed))
    guarded = plan(mission, iterations=100, preset="tuned")
    legal = plan(mission, iterations=100, preset="tuned", moves="legal", rollout="uniform")
    assert legal.objective <= guarded.objective


@pytest.mark.parametrize("options", [{}, {"preset": "tuned"}])
def test_same_seed_same_plan(nominal, options):
    """The seed and the number of iterations decide the plan, and other seeds change it."""
    first, second, *others = (plan(nominal, 5, seed, **options) for seed in (1, 1, 2, 3, 4))
    assert first.sequence == second.sequence
    assert first.counters == second.counters
    assert any(first.sequence != other.sequence for other in others)


@pytest.mark.parametrize("options", EVERY_WORD)
def test_every_word_gives_legal_plan(tiny, options):
    """Whatever is set, check finds nothing wrong and the optimum is not exceeded."""
    result = plan(tiny, 60, **options)
    assert adr_opt.check(tiny.instance, result.plan) == ()
    assert 0.0 < result.objective <= brute_force(tiny)[0]


def test_stop_is_asked_before_every_step(nominal):
    """A mission stopped after some steps is the beginning of the one that was not stopped."""
    whole = plan(nominal)
    part = plan(nominal, iterations=7)
    assert part.counters["steps"] == 7
    assert part.sequence == whole.sequence[:7]


def test_prizes_count(tiny):
    """A single target worth more than all others together is in every tuned plan."""
    instance = tiny.instance
    for index in range(3):
        targets = list(instance.targets)
        targets[index] = targets[index].replace(prize=100.0)
        mission = Mission(instance.replace(targets=tuple(targets)))
        assert index + 1 in plan(mission, 60, preset="tuned").sequence


def test_memory_bounds_tree_not_plan(nominal, monkeypatch):
    """A kept tree that runs out of memory is begun anew, and the mission goes on."""
    monkeypatch.setattr("solvers.planners.mcts.LARGEST_TREE", 1)
    result = plan(nominal, 40, preset="tuned", simulations=100)
    assert adr_opt.check(nominal.instance, result.plan) == ()
    assert result.objective >= 25.0


def test_uniform_rollouts_are_uniform(tiny):
    """The first move of a uniform rollout is any legal move, all equally often."""
    rules, bodies = tiny.rules, len(tiny.names)
    policy = policies.RolloutSettings(1, False, 0.0, 1.0)
    start = policies.rule_kernels.beginning(rules)
    memory, rng = policies.scratch(bodies), np.random.default_rng(0)
    counts = np.zeros(bodies)
    draws = 6000
    for _ in range(draws):
        policies.rollout(rules, policy, rng, memory, 0, start)
        counts[memory.sequence[0]] += 1
    mask = np.zeros(bodies, dtype=np.bool_)
    legal = policies.rule_kernels.legal_moves(rules, start, memory.visited, mask)
    assert (counts[~mask] == 0).all()
    expected = draws / legal
    assert np.abs(counts[mask] - expected).max() < 5.0 * np.sqrt(expected)


def test_polish_only_improves():
    """The open-loop polish gives a legal plan, never worse than without it, and here better."""
    mission = Mission(adr_opt.generate("nominal", 0))
    plain = adr_opt.solve(mission, "mcts", time_limit=60.0)
    polished = adr_opt.solve(mission, "mcts", time_limit=60.0, polish=30)
    assert adr_opt.check(mission.instance, polished.plan) == ()
    assert polished.objective > plain.objective
    assert polished.counters["polished"] > 0
