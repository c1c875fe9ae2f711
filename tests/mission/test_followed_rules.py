"""Each method on fields that every rule binds which it says it follows, against enumeration."""

from __future__ import annotations

from pathlib import Path

import pytest
from brute_force import brute_force, brute_force_campaign
from random_rules import DRAWS

import adr_opt
from adr_opt.mission.problem import Problem
from adr_opt.problem.instance import Instance
from adr_opt.problem.rules import RULES
from adr_opt.problem.support import binding, follows_all
from adr_opt.run.methods import BOUNDS, PLANNERS, names, spec

LONG = {"ortools", "mip"}
METHODS = [
    pytest.param(group, name, marks=[pytest.mark.slow] if name in LONG else [])
    for group in (PLANNERS, BOUNDS)
    for name in names(group)
]

ELSEWHERE = {
    "functions of time": "solvers/test_timed_sets.py",
    "longest leg": "solvers/test_tours_planned.py",
    "missions apart": "solvers/test_tours_planned.py",
    "low thrust": "plan/test_kits.py",
    "decay": "legs/test_decaying.py",
    "ephemerides": "problem/test_rules_in_files.py",
}
"""Rules that no drawn field of here has, and where methods that follow them are enumerated."""

SEEDS = 60


def fields_for(follows: frozenset[str]) -> list[Instance]:
    """A few drawn fields that a follower may be given, which together meet all of its rules."""
    left, found = set(follows) - ELSEWHERE.keys(), []
    for seed in range(SEEDS):
        for draw in DRAWS.values():
            instance = draw(seed)
            if len(instance.chasers) < 3 and follows_all(instance, follows):
                met = {word for word, _ in binding(instance, left)}
                if met:
                    left -= met
                    found.append(instance)
            if not left:
                return found
    raise AssertionError(f"no drawn field has {sorted(left)}")


@pytest.mark.parametrize(("group", "name"), METHODS)
def test_each_rule_is_followed_by_who_says_so(group: str, name: str) -> None:
    """Plans pass `check` and collect no more than the best one, which no bound is below."""
    call = adr_opt.solve if group == PLANNERS else adr_opt.bound
    for instance in fields_for(spec(name, group).follows):
        problem = Problem(instance)
        best = (
            brute_force(problem.missions[0])[0]
            if problem.alone is not None
            else brute_force_campaign(problem)[0]
        )
        result = call(instance, name, time_limit=20.0, iterations=2)
        assert result.upper_bound >= best - 1e-9, instance.name
        if result.plan is not None:
            assert adr_opt.check(instance, result.plan) == (), instance.name
            assert result.objective <= best + 1e-9, instance.name


def test_all_rules_are_met_somewhere() -> None:
    """Rules that are not drawn here are those of tests that are there."""
    assert ELSEWHERE.keys() <= RULES.keys()
    for path in ELSEWHERE.values():
        assert (Path(__file__).parents[1] / path).is_file(), path
