"""Plans for the expected prize, and replanning that keeps to what is worth more on average."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import adr_opt
from adr_opt import analysis
from adr_opt.analysis.rehearse.flight import Situation
from adr_opt.analysis.rehearse.flying_chasers import beginning
from adr_opt.analysis.rehearse.intended import Intended, intended
from adr_opt.analysis.rehearse.mission_facts import MissionFacts
from adr_opt.analysis.rehearse.outlook import Outlook, is_better
from adr_opt.analysis.rehearse.replanning import AtDeviations, AtEveryService
from adr_opt.common.errors import InputError
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty

TROUBLED = Uncertainty(
    legs={"delta_v_factor": {"lognormal_sigma": 0.2}},
    service_s={"factor": {"lognormal_sigma": 0.3}},
    capture={"success": 0.8, "tries": 2},
)


@pytest.fixture(scope="module", name="tiny")
def _tiny() -> tuple[Instance, Plan]:
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "beam").plan
    assert plan is not None
    return instance, plan


def begun(tiny: tuple[Instance, Plan]) -> tuple[MissionFacts, Intended, Situation]:
    """Before the first leg of a mission."""
    facts = MissionFacts(tiny[0])
    planned = intended(facts, tiny[1])
    craft = beginning(facts, 0, planned.kits[0], facts.chasers[0].limits.ready, 1.0)
    return facts, planned, Situation(facts, craft, (craft,), set())


def test_routes_are_worth_what_following_them_collects(tiny) -> None:
    """From the beginning on, as in rehearsals of the whole plan, in each of the same worlds."""
    facts, planned, now = begun(tiny)
    outlook, worlds = Outlook(facts, TROUBLED), range(40)
    found = outlook.worths(now, planned.routes, worlds)
    flown = analysis.rehearse(*tiny, TROUBLED, samples=40).outcomes
    assert found.tolist() == [each.expected for each in flown]
    assert outlook.of_plan(planned, worlds).tolist() == found.tolist()
    assert not now.craft.made
    assert len(set(found.tolist())) > 2


def test_what_is_required_comes_before_all_prizes(tiny) -> None:
    """Routes that service what is required are worth more, by what is taken off their prizes."""
    first, *others = tiny[0].targets
    targets = (first.replace(required=True), *others)
    instance = tiny[0].replace(targets=targets)
    plan = adr_opt.solve(instance, "beam").plan
    assert plan is not None
    facts, planned, now = begun((instance, plan))
    outlook, worlds = Outlook(facts, TROUBLED), range(20)
    all_of_it = outlook.worths(now, planned.routes, worlds)
    without = [
        each for each in planned.routes[0] if facts.names[each.hop.destination] == first.name
    ]
    short = outlook.worths(now, [planned.routes[0][: planned.routes[0].index(without[0])]], worlds)
    assert all_of_it.max() > sum(target.prize for target in targets) > short.max()
    prizes = outlook.prizes(all_of_it)
    flown = analysis.rehearse(instance, plan, TROUBLED, samples=20).outcomes
    assert prizes == pytest.approx([each.expected for each in flown])


@pytest.mark.parametrize("policy", [AtDeviations, AtEveryService])
def test_a_new_plan_is_flown_only_if_it_is_worth_more(tiny, monkeypatch, policy) -> None:
    """A plan of nothing does not replace the one at hand, half a plan gives way to the whole."""
    facts, planned, now = begun(tiny)
    whole = [list(route) for route in planned.routes]
    half = Intended(None, (planned.routes[0][:1],), planned.kits)
    for begins, offered, kept in ((planned, [[]], whole), (half, whole, whole)):
        made = policy(facts, begins, TROUBLED)
        monkeypatch.setattr(made, "_planned", lambda *_, offered=offered, **__: offered)
        made._choose(now)
        assert made._routes == kept


def test_equal_worths_are_no_reason_to_change() -> None:
    """Nor are differences within the error of their mean; one that is the same everywhere is."""
    worths = np.arange(10.0)
    assert not is_better(worths, worths)
    assert not is_better(worths + np.resize((3.0, -2.9), 10), worths)
    assert is_better(worths + 0.01, worths)


@pytest.mark.parametrize(
    ("fields", "samples"), [(1, 4), pytest.param(12, 8, marks=pytest.mark.slow)]
)
def test_replanning_collects_no_less_than_following(fields, samples) -> None:
    """In the same worlds, where captures fail, and legs cost more or less than planned."""
    uncertainty = Uncertainty(
        capture={"success": 0.8, "tries": 2}, legs={"delta_v_factor": {"lognormal_sigma": 0.2}}
    )
    more = list[float]()
    for seed in range(fields):
        instance = adr_opt.generate("tiny", seed)
        plan = adr_opt.solve(instance, "beam").plan
        found = [
            analysis.rehearse(instance, plan, uncertainty, policy=policy, samples=samples).outcomes
            for policy in ("replan", "follow")
        ]
        more += [one.expected - other.expected for one, other in zip(*found, strict=True)]
    assert np.mean(more) >= 0.0


def test_a_plan_for_the_expected_prize_is_one_of_the_instance(tiny, tmp_path) -> None:
    """It is judged like any, and states what it collects: no less than the plain one."""
    made = analysis.expected(tiny[0], TROUBLED, "beam", time_limit=20.0)
    plan = made.plan
    assert plan is not None
    assert plan.expected is not None
    assert not adr_opt.check(tiny[0], plan)
    assert made.tried > 3
    assert plan.expected.prize >= made.plain - 3.0 * plan.expected.standard_error
    flown = analysis.rehearse(tiny[0], plan, TROUBLED, samples=400).to_dict()["expected_prize"]
    error = np.hypot(flown["standard_error"], plan.expected.standard_error)
    assert abs(flown["mean"] - plan.expected.prize) < 4.0 * error
    plan.save(tmp_path / "p.json")
    assert Plan.load(tmp_path / "p.json") == plan
    assert "expected" not in tiny[1].to_dict()


def test_prudence_pays_where_services_are_long(tiny) -> None:
    """Where stays last far longer, a plan that expects it collects more than the plain one."""
    slow = Uncertainty(service_s={"added": {"mean_s": 7000.0}})
    made = analysis.expected(tiny[0], slow, "beam", time_limit=20.0)
    assert made.plan is not None
    assert made.plan.expected is not None
    assert made.plan.expected.prize > made.plain


def test_an_impossible_mission_is_said_to_be_one(tiny) -> None:
    """Where a target is required that cannot be serviced, there is no plan."""
    first, *others = tiny[0].targets
    late: Any = first.replace(required=True, window_s=(0.0, 1.0))
    made = analysis.expected(
        tiny[0].replace(targets=(late, *others)), TROUBLED, "exact", time_limit=20.0
    )
    assert made.plan is None
    assert made.result.status == "infeasible"
    with pytest.raises(InputError, match="nobody"):
        analysis.expected(tiny[0], Uncertainty(targets={"nobody": {"gone": 0.5}}))
