"""All rules together, each on and off, against plain enumeration.

See docs/model.md sections 3, 4, 5 and 8.

In two-body motion and under J2, where planes drift: in short missions, and in long ones that live
on waiting for nodes. And over connections that are given.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from against_enumeration import bound_of_cost
from brute_force import brute_force
from random_rules import (
    by_days,
    captured_field,
    captured_mission,
    drifting_mission,
    falling_field,
    falling_mission,
    given_mission,
    random_mission,
    started_mission,
    towing_mission,
    visiting_field,
)
from seeds import over_kinds

import adr_opt
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.problem.settings import Objective
from solvers.labels.label_search import LabelSearch
from solvers.walks.walks import WalkBound

every_kind = over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(150), 10),
    j2=(drifting_mission, range(90), 5),
    given=(given_mission, range(80), 6),
    visits=(visiting_field, range(120), 10),
    captures=(captured_field, range(240), 10),
    started=(started_mission, range(90), 6),
)
every_kind_and_tows = over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(150), 20),
    j2=(drifting_mission, range(90), 10),
    given=(given_mission, range(80), 12),
    visits=(visiting_field, range(120), 20),
    captures=(captured_mission, range(240), 20),
    started=(started_mission, range(90), 9),
    tow=(towing_mission, range(80), 10),
    falls=(falling_mission, range(160), 12),
)
SEARCHED = {
    "two_body": (random_mission, range(40), 8),
    "j2": (drifting_mission, range(40), 4),
    "given": (given_mission, range(40), 4),
    "visits": (visiting_field, range(60), 3),
    "captures": (captured_field, range(60), 3),
}
searched = over_kinds("draw, seeds", **SEARCHED)
searched_and_falls = over_kinds("draw, seeds", **SEARCHED, falls=(falling_mission, range(40), 4))

KINDS = {
    random_mission: {"short"},
    drifting_mission: {"short", "drift"},
    given_mission: {"given"},
    visiting_field: {"short", "drift", "given"},
    started_mission: {"short", "drift", "given"},
    captured_mission: {"short", "drift", "given"},
    towing_mission: {"short", "drift"},
    falling_mission: {"short", "drift", "given", "launch"},
}
"""Of the legs of their plans."""

RARE = {captured_mission: {"launch"}}
"""Which are not drawn at the gate."""


@cache
def enumerated(draw, seed):
    """A mission, and what enumeration finds in it: prizes, cost and order of the best plan."""
    mission = Mission(draw(seed))
    return mission, brute_force(mission)


@every_kind_and_tows
def test_schedules_are_the_best_there_are(draw, seeds):
    """The schedule of the best order costs what enumeration says, and `check` agrees."""
    flown, kinds = 0, set()
    for seed in seeds:
        mission, (prizes, cost, order) = enumerated(draw, seed)
        if not math.isfinite(prizes):
            continue
        schedule = mission.time(order)
        assert schedule.made == len(order), seed
        assert schedule.cost == pytest.approx(cost, abs=1e-6), seed
        result = certify(mission, "test", order, seed=0, runtime_s=0.0)
        assert result.objective == pytest.approx(prizes), seed
        assert adr_opt.check(mission.instance, result.plan) == (), seed
        flown += len(order)
        kinds |= {leg.kind for leg in result.plan.legs}
    assert flown > 10
    assert KINDS[draw] <= kinds <= KINDS[draw] | RARE.get(draw, set())


@every_kind_and_tows
def test_bounds_hold_and_proofs_end_at_the_optimum(draw, seeds):
    """No plan that enumeration knows is above the bound, and `exact` proves the best one."""
    for seed in seeds:
        mission, (prizes, _, _) = enumerated(draw, seed)
        rng = np.random.default_rng(seed)
        worth = mission.rules.prize
        bound = WalkBound(
            mission, float(rng.choice([7.0, 20.0, 50.0])), float(rng.choice([0.0, 0.02, 0.5]))
        )
        for multipliers in (np.zeros(worth.size), rng.uniform(0.0, 1.2, worth.size) * worth):
            value, _ = bound.evaluate(multipliers)
            assert mission.shown(value) >= prizes - 1e-9, seed
        result = adr_opt.solve(mission.instance, "exact", time_limit=60.0)
        if math.isfinite(prizes):
            assert result.status == "optimal", (seed, result)
            assert result.objective == pytest.approx(prizes, abs=1e-9), seed
        else:
            assert result.status == "infeasible", (seed, result)
            assert result.plan is None


@searched_and_falls
def test_searches_end_at_the_optimum_with_any_multipliers(draw, seeds):
    """A search for plans worth the optimum finds one; for more it finds none."""
    for seed in seeds:
        mission, (prizes, _, _) = enumerated(draw, 1000 + seed)
        if not math.isfinite(prizes) or not mission.worth(prizes):
            continue
        worth = mission.rules.prize
        rng = np.random.default_rng(seed)
        bound = WalkBound(mission, 20.0)
        routes = LabelSearch(bound)
        for multipliers in (np.zeros(worth.size), rng.uniform(0.0, 1.0, worth.size) * worth):
            routes.use(multipliers)
            finished, value, _, _ = routes.search(
                mission.worth(prizes) - 1e-6, 10**6, lambda: False
            )
            assert finished
            assert value >= mission.worth(prizes) - 1e-5, seed


USUAL = {"greedy-guarded": 0.2, "beam": 0.5, "mcts": 0.3, "local-search": 0.5, "auto": 0.99}
SHARES = {
    random_mission: USUAL | {"greedy-guarded": 0.3, "beam": 0.7, "mcts": 0.5, "local-search": 0.6},
    **dict.fromkeys((drifting_mission, falling_field, captured_field, given_mission), USUAL),
    visiting_field: {name: share for name, share in USUAL.items() if name != "local-search"},
}
"""Of the optima of all seeds together, what each planner finds at least."""


@over_kinds(
    "method, draw, share, seeds",
    **{
        f"{method}-{draw.__name__}": (
            method,
            draw,
            share,
            range(2000, 2040),
            8 if draw is drifting_mission else 4,
        )
        for draw, shares in SHARES.items()
        for method, share in shares.items()
    },
)
def test_planners_keep_to_all_rules(method, draw, share, seeds):
    """Whatever a planner returns passes `check` and is worth no more than the optimum."""
    found = best = 0.0
    for seed in seeds:
        mission, (prizes, _, _) = enumerated(draw, seed)
        result = adr_opt.solve(mission, method, time_limit=60.0, iterations=3)
        if result.plan is not None:
            assert adr_opt.check(mission.instance, result.plan) == (), seed
            assert result.objective <= prizes + 1e-9, seed
            found += result.objective
        best += max(prizes, 0.0)
    assert found > share * best


@pytest.mark.parametrize("cost_of", ["delta-v", "duration"])
@every_kind
def test_the_least_cost_is_proven(draw, seeds, cost_of):
    """At the best prizes, and any price of a day, `exact` proves the least cost, and never more."""
    proven = 0
    for seed in seeds:
        instance = by_days(draw(seed), seed)
        if cost_of == "duration":
            instance = instance.replace(objective=Objective(cost="duration"))
        mission = Mission(instance)
        prizes, cost, _ = brute_force(mission)
        if not math.isfinite(prizes):
            continue
        plan = adr_opt.solve(mission, "exact", time_limit=60.0, cost=True).plan
        assert plan.objective == pytest.approx(prizes), seed
        assert plan.cost_status == "optimal", (seed, plan.cost, plan.cost_bound, cost)
        assert plan.cost == pytest.approx(cost, rel=2e-6, abs=1e-5), seed
        assert plan.cost_bound <= cost * (1.0 + 1e-9) + 1e-9, seed
        assert adr_opt.check(instance, plan) == (), seed
        proven += plan.cost > 0.0
    assert proven > 0.25 * len(seeds)


@searched
@pytest.mark.parametrize("jobs", [1, 2])
def test_no_plan_costs_less_than_the_bound(draw, seeds, jobs):
    """However dear the plan known, after each round of a proof of the cost the bound holds."""
    closed = 0
    for seed in seeds:
        mission = Mission(by_days(draw(3000 + seed), seed))
        bound, cost = bound_of_cost(mission, 4.0, jobs=jobs) or (0.0, math.inf)
        closed += bound >= cost * (1.0 - 1e-6) - 1e-6
    assert closed > 0.5 * len(seeds)
