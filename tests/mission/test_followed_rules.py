"""Each method on fields that every rule binds which it says it follows, against enumeration."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from brute_force import brute_force, brute_force_campaign
from random_rules import DRAWS

import adr_opt
from adr_opt.analysis import price, replan
from adr_opt.analysis.priced import FOLLOWS as PRICED
from adr_opt.analysis.rehearse.mission_facts import FOLLOWS as REHEARSED
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.analysis.replan.replanning import FOLLOWS as REPLANNED
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.plan.plan import InstanceReference, Plan
from adr_opt.problem.instance import Instance
from adr_opt.problem.rules import RULES, Follower
from adr_opt.problem.support import binding, follows_all
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.run.methods import BOUNDS, PLANNERS, names, spec

LONG = {"ortools", "mip"}
METHODS = [
    pytest.param(group, name, marks=[pytest.mark.slow] if name in LONG else [])
    for group in (PLANNERS, BOUNDS)
    for name in names(group)
]

ELSEWHERE = {
    "functions of time": "solvers/test_timed_sets.py",
    "functions of time for several chasers": "solvers/test_route_engine.py",
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


def _priced(instance: Instance, plan: Plan, best: float) -> None:
    made = price(instance, plan, mend=False)
    assert made.holds
    assert made.objective == pytest.approx(plan.objective)
    assert made.plan().cost == pytest.approx(plan.cost, rel=1e-9, abs=1e-6)


def _replanned(instance: Instance, plan: Plan, best: float) -> None:
    made = replan(instance, plan, 0.0, method="greedy-guarded")
    assert made.prize_before <= plan.objective + 1e-9
    if made.result.plan is not None:
        assert adr_opt.check(made.instance, made.result.plan) == ()
        assert made.prize_after <= best + 1e-9


def _rehearsed(instance: Instance, plan: Plan, best: float) -> None:
    (came,) = rehearse(instance, plan, Uncertainty(), samples=1).outcomes
    assert came.prize == pytest.approx(plan.objective)
    assert came.returned
    assert came.losses == {}


@pytest.mark.parametrize(
    ("follower", "agrees"),
    [(PRICED, _priced), (REPLANNED, _replanned), (REHEARSED, _rehearsed)],
    ids=["price", "replan", "rehearse"],
)
def test_who_takes_a_plan_follows_the_rules_that_it_names(
    follower: Follower, agrees: Callable[[Instance, Plan, float], None]
) -> None:
    """What becomes of a plan in a world without errors is what its judge and enumeration say."""
    for instance in fields_for(follower.follows):
        problem = Problem(instance)
        plan = adr_opt.solve(instance, "greedy-guarded", time_limit=20.0).plan
        if plan is None or not plan.objective:
            continue
        best = (
            brute_force(problem.missions[0])[0]
            if problem.alone is not None
            else brute_force_campaign(problem)[0]
        )
        assert plan.objective <= best + 1e-9, instance.name
        agrees(instance, plan, best)


LEFT_OUT = {
    "windows": ("targets", "window_s", (0.0, None)),
    "end of availability": ("chasers", "available_s", (0.0, None)),
    "ends": ("chasers", "end", "anywhere"),
    "most targets": ("chasers", "max_targets", None),
    "visits between refuellings": ("chasers", "max_visits_between_refuels", None),
    "required targets": ("targets", "required", False),
}
"""Rules that only forbid: the part, its field, and what it is where the rule is left out."""


@pytest.mark.parametrize("word", LEFT_OUT)
def test_check_refuses_what_only_a_rule_forbids(word: str) -> None:
    """The best plan without a rule fails with it, where enumeration then finds none so good."""
    part, field, usual = LEFT_OUT[word]
    for seed in range(5 * SEEDS):
        instance = DRAWS["visiting field" if word.startswith("visits") else "random"](seed)
        if not RULES[word].binds(instance):
            continue
        parts = tuple(each.replace(**{field: usual}) for each in getattr(instance, part))
        free = instance.replace(**{part: parts})
        prizes, _, order = brute_force(Mission(free))
        if not math.isfinite(prizes) or not prizes:
            continue
        plan = certify(Mission(free), "test", order, seed=0, runtime_s=0.0).plan
        assert adr_opt.check(free, plan) == (), seed
        found = adr_opt.check(
            instance,
            plan.replace(instance=InstanceReference(name=instance.name, sha256=instance.sha256)),
        )
        if brute_force(Mission(instance))[0] < prizes - 1e-9:
            assert found, (seed, word)
            return
    raise AssertionError(f"no drawn field loses a plan by {word}")


def test_all_rules_are_met_somewhere() -> None:
    """Rules that are not drawn here are those of tests that are there."""
    assert ELSEWHERE.keys() <= RULES.keys()
    for path in ELSEWHERE.values():
        assert (Path(__file__).parents[1] / path).is_file(), path
