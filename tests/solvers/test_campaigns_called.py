"""Several chasers: how methods are called, what they begin from, and that they repeat it."""

from __future__ import annotations

import json

import pytest
from conftest import Cli, refused

import adr_opt
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.problem import Problem
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import AtStation, InOrbit
from adr_opt.problem.instance import Instance
from adr_opt.run import methods

DAY_S = 86400.0
ABLE = {"auto", "exact", "greedy", "greedy-guarded", "ortools"}


@pytest.fixture(scope="module")
def instance() -> Instance:
    """Two chasers that have to leave targets out."""
    drawn = adr_opt.generate("tiny", 3, chasers=2)
    return drawn.with_limits(duration_s=0.6 * DAY_S, delta_v_m_s=600.0)


@pytest.fixture(scope="module")
def plan(instance: Instance) -> Plan:
    made = adr_opt.solve(instance, "greedy-guarded").plan
    assert made is not None
    assert all(len(route.legs) for route in made.routes)
    assert max(len(route.legs) for route in made.routes) > 1
    return made


def test_methods_for_one_chaser_say_so(instance: Instance) -> None:
    """Each planner and bound plans a campaign or refuses it in a sentence that names others."""
    for group, call in ((methods.PLANNERS, adr_opt.solve), (methods.BOUNDS, adr_opt.bound)):
        for name in methods.names(group):
            if name in ABLE:
                assert call(instance, name, iterations=2).status in ("optimal", "feasible")
                continue
            with pytest.raises(
                adr_opt.InputError, match=r"does not follow several chasers.*; use "
            ):
                call(instance, name)
    with pytest.raises(adr_opt.InputError, match="'lagrangian' does not follow several"):
        adr_opt.solve(instance, "auto", bound="lagrangian")


@pytest.mark.parametrize("method", ["auto", pytest.param("exact", marks=pytest.mark.slow)])
@pytest.mark.slow
def test_the_same_rounds_give_the_same_plan(method: str) -> None:
    """Same seed and rounds, same routes, bound and counts, on one core or two."""
    instance = adr_opt.generate("campaign", 1, targets=24, stations=2)
    instance = instance.with_limits(duration_s=3.0 * DAY_S)
    runs = [
        adr_opt.solve(instance, method, time_limit=120.0, iterations=2, seed=5, jobs=jobs)
        for jobs in (1, 2, 2)
    ]
    assert runs[0].counters["rounds"] == 2
    assert runs[0].counters["searches"] > 0
    for run in runs[1:]:
        assert run.routes == runs[0].routes
        assert run.upper_bound == runs[0].upper_bound
        assert run.counters == runs[0].counters
        assert run.plan.routes == runs[0].plan.routes
    other = adr_opt.solve(instance, method, time_limit=120.0, iterations=2, seed=6, jobs=1)
    assert (other.counters, other.routes) != (runs[0].counters, runs[0].routes)


@pytest.mark.parametrize("method", ["auto", "exact", "greedy"])
def test_a_campaign_of_one_is_the_mission(method: str) -> None:
    """One chaser, planned as a campaign, has the plan and the proof of its mission."""
    instance = adr_opt.generate("tiny", 3)
    mission, campaign = (
        adr_opt.solve(problem, method, time_limit=30.0)
        for problem in (instance, Problem(instance, margin=0.0))
    )
    assert campaign.plan.routes == mission.plan.routes
    assert (campaign.upper_bound, campaign.status) == (mission.upper_bound, mission.status)
    assert campaign.counters == mission.counters
    kept = adr_opt.solve(Problem(instance, margin=0.5), "greedy").plan
    assert sum(leg.delta_v_m_s for leg in kept.legs) <= 0.5 * instance.chaser.tank.delta_v_m_s


def test_planning_begins_from_a_plan(instance: Instance, plan: Plan) -> None:
    """A plan, its routes by name or number, or some of them, are begun from; nothing is lost."""
    names = [[leg.destination for leg in route.legs] for route in plan.routes]
    numbers = [[instance.names.index(name) for name in route] for route in names]
    for start in (plan, names, numbers, [tuple(numbers[0])], [[], numbers[1]]):
        result = adr_opt.solve(instance, "auto", start=start, iterations=1)
        assert adr_opt.check(instance, result.plan) == ()
        assert result.objective >= plan.objective
    best = adr_opt.solve(instance, "exact", time_limit=30.0).plan
    # Nothing is left to be found, so the plan that comes back is the one that was given.
    again = adr_opt.solve(instance, "exact", start=best, time_limit=30.0)
    assert again.objective == best.objective


def test_the_routes_of_a_start_belong_to_chasers_by_name(instance: Instance, plan: Plan) -> None:
    """A plan with its routes in another order, or without an empty one, is the same start."""
    backwards = plan.replace(routes=plan.routes[::-1])
    some = plan.replace(routes=plan.routes[1:], objective=float(len(plan.routes[1].legs)))
    for start in (plan, backwards):
        result = adr_opt.solve(instance, "auto", start=start, iterations=1, repair=True)
        assert not any("could be kept" in note for note in result.notes)
        assert result.objective >= plan.objective
    result = adr_opt.solve(instance, "auto", start=some, iterations=1, repair=True)
    assert not any("could be kept" in note for note in result.notes)


@pytest.mark.parametrize(
    ("start", "named"),
    [
        ([[1, 2], [2]], "'debris-002' is visited by two chasers"),
        ([1, 2], "a sequence of bodies for each of 2 chasers"),
        ([[1], [2], [3]], "a sequence of bodies for each of 2 chasers"),
        ([[99]], "may only name the bodies 0 to 8"),
        ([["nobody"], []], "'nobody' is not a body"),
        ([[], [1, 1]], "leg 2 goes from 'debris-001' to itself"),
        ([[0], []], "leg 1 refuels, but no target was visited"),
    ],
)
def test_wrong_starts_are_refused(instance: Instance, start: list, named: str) -> None:
    """What is wrong with the routes of a start is said in one sentence."""
    with pytest.raises(adr_opt.InputError, match=named):
        adr_opt.solve(instance, "auto", start=start, iterations=1)


def test_the_plan_of_another_campaign_is_repaired(cli: Cli, instance: Instance, plan: Plan) -> None:
    """--start of a longer campaign is refused, and --repair keeps a beginning of each route."""
    shorter = instance.with_limits(duration_s=0.35 * DAY_S)
    for name, what in (("short.json", shorter), ("plan.json", plan)):
        with open(name, "w", encoding="utf-8") as file:
            file.write(what.to_json())
    call = ("solve", "short.json", "--start", "plan.json", "--out", "new.json", "--time-limit", "9")
    refused(cli(*call), "start plan: the plan belongs to the instance", "repair")
    outcome = cli(*call, "--repair")
    assert outcome.status == 0, outcome.err
    longest = max(plan.routes, key=lambda route: len(route.legs))
    legs = len(longest.legs)
    assert f"of the start plan's {legs} legs of '{longest.chaser}' could be kept" in outcome.err
    made = adr_opt.load_plan("new.json")
    assert adr_opt.check(shorter, made) == ()
    assert [route["chaser"] for route in json.loads(made.to_json())["routes"]] == [
        chaser.name for chaser in instance.chasers
    ]


def test_no_route_of_a_repaired_start_repeats_another(instance: Instance, plan: Plan) -> None:
    """Of a plan with a target on two routes, --repair keeps it on one, and nothing counts twice."""
    best = adr_opt.solve(instance, "exact", time_limit=30.0)
    longest = max(plan.routes, key=lambda route: len(route.legs))
    twice = plan.replace(
        routes=tuple(longest.replace(chaser=chaser.name) for chaser in instance.chasers)
    )
    for method in ("auto", "exact"):
        result = adr_opt.solve(instance, method, start=twice, repair=True, time_limit=30.0)
        assert adr_opt.check(instance, result.plan) == ()
        assert result.objective == best.objective
    legs = len(longest.legs)
    assert f"none of the start plan's {legs} legs of 'chaser-2' could be kept" in result.notes
    with pytest.raises(adr_opt.InputError, match="is visited twice"):
        certify_routes(Problem(instance), "hand", [(2,), (2,)], seed=0, runtime_s=0.0)


def test_a_target_is_done_once_by_one_chaser(instance: Instance, plan: Plan) -> None:
    """`check` reports a target on two routes, and a chaser that ends where it must not.

    Also one that flies nothing has to be where it has to end.
    """
    first, second = plan.routes
    twice = plan.replace(routes=(first, second.replace(legs=first.legs)))
    said = [v for v in adr_opt.check(instance, twice) if v.rule == "order"]
    assert [v.leg for v in said] == list(range(len(first.legs) + 1, 2 * len(first.legs) + 1))
    assert "was visited before" in said[0].message

    away = InOrbit(orbit=instance.targets[0].orbit.replace(true_anomaly_deg=10.0))
    bound = instance.chasers[1].replace(start=away, end=AtStation(station="station"))
    ends = instance.replace(chasers=(instance.chasers[0], bound))
    result = adr_opt.solve(ends, "auto", time_limit=60.0)
    assert adr_opt.check(ends, result.plan) == ()
    assert ends.names[result.routes[1][-1]] == "station"
    home = result.plan.replace(routes=(result.plan.routes[0],))
    assert "end" in {violation.rule for violation in adr_opt.check(ends, home)}
    # There is no plan where that chaser cannot fly, whatever the others do.
    stays = ends.replace(chasers=(ends.chasers[0], bound.replace(max_targets=0)))
    assert adr_opt.solve(stays, "exact", time_limit=60.0).plan is None
