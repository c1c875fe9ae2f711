"""Rehearsals: policies in drawn worlds."""

from __future__ import annotations

import json
import math
from functools import cache
from itertools import pairwise, product
from pathlib import Path

import launched
import numpy as np
import pytest
import towed_fields
import two_chasers
from drawn_worlds import drawn_uncertainty
from random_rules import captured, random_campaign, random_mission

import adr_opt
from adr_opt.analysis.rehearse.intended import intended
from adr_opt.analysis.rehearse.mission_facts import MissionFacts
from adr_opt.analysis.rehearse.rehearsals import share, summary
from adr_opt.analysis.rehearse.replay import replay
from adr_opt.analysis.rehearse.sampling import Setting, flown_in, rehearse, setting_of
from adr_opt.analysis.replan import remaining_plan
from adr_opt.common.errors import InputError
from adr_opt.plan.plan import InstanceReference, Plan
from adr_opt.problem.chasers import Tank
from adr_opt.problem.disposal import DisposalPerigee
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.problem.world import DrawnWorld

CERTAIN = Uncertainty()


@cache
def tiny() -> tuple[Instance, Plan]:
    instance = adr_opt.generate("tiny", 0, targets=12)
    instance = instance.replace(chasers=(instance.chaser.replace(tank=Tank(delta_v_m_s=1000.0)),))
    return instance, adr_opt.solve(instance, "beam").plan


@cache
def kept() -> tuple[Instance, Plan]:
    """The same with a part of the tank kept, and more prizes than the rest of it is enough for."""
    instance, _ = tiny()
    chaser = instance.chaser.replace(end_of_life_m_s=400.0)
    instance = instance.replace(chasers=(chaser,))
    return instance, adr_opt.solve(instance, "beam").plan


@cache
def released() -> tuple[Instance, Plan]:
    """Tows of objects that have to come down under control."""
    instance = towed_fields.field()
    mission = {"disposal": DisposalPerigee(perigee_m=50e3), "max_uncontrolled_kg": 10.0}
    instance = instance.replace(mission=instance.mission.replace(**mission))
    return instance, adr_opt.solve(instance, time_limit=5.0).plan


@cache
def towed() -> tuple[Instance, Plan]:
    instance = towed_fields.field()
    return instance, adr_opt.solve(instance, time_limit=5.0).plan


def flown(instance: Instance, plan: Plan, policy: str, uncertainty: Uncertainty, seed: int = 0):  # type: ignore[no-untyped-def]
    facts = MissionFacts(instance)
    return flown_in(
        facts, intended(facts, plan), Setting(instance, plan, uncertainty, policy), seed
    )


@pytest.mark.parametrize(
    ("kind", "policy"),
    [
        ("single", "beam"),  # of the others it may find a better plan
        *product(
            ("single", "campaign", "launched", "towed", "kept", "released"),
            ("follow", "skip", "replan", "learned"),
        ),
    ],
)
def test_without_uncertainty_every_policy_flies_the_plan(kind: str, policy: str) -> None:
    """In a world where nothing differs all legs are flown when and at what they were planned."""
    instance, plan = {
        "single": tiny,
        "campaign": lambda: (two_chasers.campaign(), two_chasers.planned()),
        "launched": lambda: (launched.campaign(), launched.planned()),
        "towed": towed,
        "kept": kept,
        "released": released,
    }[kind]()
    made, outcome = flown(instance, plan, policy, CERTAIN)
    names = instance.names
    own = {
        instance.chasers[craft.chaser].name: [
            (names[leg.hop.destination], leg.hop.arrival, leg.delta_v, leg.end_s)
            for leg in craft.made
        ]
        for craft in made.chasers
    }
    for route in plan.routes:
        for leg, (name, *figures) in zip(route.legs, own[route.chaser], strict=True):
            assert name == leg.destination
            assert figures == pytest.approx(
                [leg.arrival_s, leg.delta_v_m_s, leg.end_s], rel=1e-9, abs=1e-6
            )
    assert outcome.prize == outcome.expected == plan.objective
    assert not outcome.losses
    assert outcome.last_s == pytest.approx(max(leg.done_s for leg in plan.legs))


def test_follow_stops_before_a_leg_that_it_cannot_pay() -> None:
    """Where many legs cost thrice as much the tank lasts for a part of the plan, and no more."""
    instance, plan = tiny()
    factor = {"lognormal_sigma": 3.0, "least": 1.0, "most": 3.0}  # one of both, nearly always
    dear = Uncertainty(legs={"delta_v_factor": factor})
    made, outcome = flown(instance, plan, "follow", dear)
    (craft,) = made.chasers
    assert craft.ended in ("delta-v", "dry")
    assert 0 < outcome.prize < plan.objective
    spent = 0.0
    for leg in craft.made:
        assert leg.delta_v <= 3.0 * leg.hop.delta_v + 1e-9
        spent = 0.0 if leg.outcome == "refuelled" else spent + leg.delta_v
        assert spent <= instance.chaser.tank.delta_v_m_s + 1e-3
    assert set(outcome.losses.values()) <= {"delta-v", "dry"}


def test_a_late_chaser_takes_the_next_connection_to_the_same_body() -> None:
    """After long services `follow` keeps the order of the plan, and leaves when it is free."""
    instance, plan = tiny()
    long = Uncertainty(service_s={"added": {"mean_s": 6000.0}})
    late = 0
    for seed in range(5):
        made, _ = flown(instance, plan, "follow", long, seed)
        (craft,) = made.chasers
        legs = craft.made
        assert [instance.names[leg.hop.destination] for leg in legs] == list(
            plan.destinations[: len(legs)]
        )
        for before, leg in pairwise(legs):
            assert leg.hop.departure >= before.free_s - 1e-3
            assert leg.ready_s == before.free_s
        late += any(
            leg.hop.departure > planned.departure_s
            for leg, planned in zip(legs, plan.legs, strict=False)
        )
    assert late


def test_skip_collects_what_follow_stops_before() -> None:
    """Where some services are long `skip` collects more than `follow` in the mean."""
    instance, plan = tiny()
    long = Uncertainty(service_s={"added": {"chance": 0.3, "mean_s": 20_000.0}})
    means = {
        policy: rehearse(instance, plan, long, policy=policy, samples=60).to_dict()["prize"]["mean"]
        for policy in ("follow", "skip")
    }
    assert means["skip"] > means["follow"]


def test_targets_gone_and_failed_captures_are_lost_for_that_reason() -> None:
    """A target that is gone takes no service; one whose tries all fail takes all of them."""
    instance, plan = tiny()
    targets = [name for name in plan.destinations if name not in instance.station_names]
    first, second = targets[:2]
    uncertainty = Uncertainty(targets={first: {"gone": 1.0}, second: {"success": 0.0, "tries": 2}})
    made, outcome = flown(instance, plan, "follow", uncertainty)
    assert (outcome.losses[first], outcome.losses[second]) == ("gone", "capture")
    by_name = {
        instance.names[leg.hop.destination]: leg for craft in made.chasers for leg in craft.made
    }
    service_s = MissionFacts(instance).chasers[0].limits.service[instance.names.index(second)]
    gone, failed = by_name[first], by_name[second]
    assert gone.end_s == gone.hop.arrival
    assert failed.tries == 2
    assert failed.end_s == pytest.approx(failed.hop.arrival + 2 * service_s)


def test_each_try_waits_for_a_window() -> None:
    """A capture that fails is tried again when the next window opens, and not after the last."""
    instance, plan = tiny()
    first = plan.legs[0]
    stay_s = first.end_s - first.arrival_s
    opens_s = first.arrival_s + 3.0 * stay_s
    windows = [(0.0, first.arrival_s + 0.5 * stay_s), (opens_s, opens_s + 0.6 * stay_s)]
    targets = tuple(
        target.replace(windows_s=windows, capture_s=0.4 * stay_s)
        if target.name == first.destination
        else target
        for target in instance.targets
    )
    made = instance.replace(targets=targets)
    plan = plan.replace(instance=InstanceReference(name=made.name, sha256=made.sha256))
    assert adr_opt.check(made, plan) == ()
    model = Uncertainty(targets={first.destination: {"success": 0.0, "tries": 3}})
    came = flown(made, plan, "follow", model)[0].chasers[0].made[0]
    assert (came.outcome, came.tries) == ("capture", 2)
    assert came.end_s == pytest.approx(opens_s + stay_s)


def test_a_launch_that_slips_begins_later() -> None:
    """The first leg of a launched chaser arrives no earlier than its slip allows."""
    instance, plan = launched.campaign(), launched.planned()
    slips = Uncertainty(launches={"slip_s": {"mean_s": 86400.0}})
    made, _ = flown(instance, plan, "follow", slips, 3)
    facts, world = MissionFacts(instance), DrawnWorld(instance, slips, 3)
    assert any(craft.made for craft in made.chasers)
    for craft in made.chasers:
        chaser = facts.chasers[craft.chaser]
        assert world.slip_s(chaser.name) > 0.0
        if craft.made:
            ready_s = chaser.limits.ready + world.slip_s(chaser.name)
            assert craft.made[0].hop.arrival >= ready_s


def test_expected_prizes_have_the_mean_of_prizes_and_less_variance() -> None:
    """Without the luck of captures rehearsals differ less, and are worth as much on average."""
    instance, plan = tiny()
    uncertainty = Uncertainty(capture={"success": 0.6, "tries": 2}, gone=0.1)
    made = rehearse(instance, plan, uncertainty, samples=1500)
    prizes = np.array([each.prize for each in made.outcomes])
    expected = np.array([each.expected for each in made.outcomes])
    differ = prizes - expected
    assert abs(differ.mean()) < 3.5 * differ.std() / math.sqrt(differ.size)
    assert expected.std() < 0.7 * prizes.std()


def test_rehearsals_of_another_uncertainty_are_refused(tmp_path: Path) -> None:
    """Worlds of two uncertainties do not mix in one file."""
    instance, plan = tiny()
    path = tmp_path / "rehearsals.jsonl"
    rehearse(instance, plan, drawn_uncertainty(instance, 1), samples=2, path=path)
    with pytest.raises(InputError, match="made with other uncertainty"):
        rehearse(instance, plan, CERTAIN, samples=2, path=path)


def test_planners_elsewhere_use_one_core_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """The planner of several chasers gets one core where others plan beside it."""
    asked = []

    def noted(problem, method, **more):  # type: ignore[no-untyped-def]
        asked.append(more.get("jobs"))
        raise InterruptedError

    monkeypatch.setattr(remaining_plan, "solve", noted)
    instance, plan = two_chasers.campaign(), two_chasers.planned()
    slow = Uncertainty(service_s={"added": {"mean_s": 9000.0}})
    setting = Setting(instance, plan, slow, "beam")
    for cores in (0, 1):
        facts = MissionFacts(instance, cores=cores)
        with pytest.raises(InterruptedError):
            flown_in(facts, intended(facts, plan), setting, 0)
    assert asked == [None, 1]


@pytest.mark.parametrize(
    "draw", [random_mission, random_campaign, lambda seed: captured(random_mission(seed), seed)]
)
def test_check_accepts_replays(draw) -> None:  # type: ignore[no-untyped-def]
    """A rehearsal as a plan of its world has its prize, and `check` finds nothing."""
    flown_some = 0
    for number in range(4):
        instance = draw(number)
        plan = adr_opt.solve(instance, time_limit=5.0).plan
        if plan is None:
            continue
        uncertainty = drawn_uncertainty(instance, number)
        for policy in ("follow", "replan", "learned"):
            made = replay(Setting(instance, plan, uncertainty, policy), number)
            assert adr_opt.check(made.instance, made.plan) == ()
            assert made.plan.objective == pytest.approx(made.outcome.prize)
            flown_some += bool(made.plan.legs)
    assert flown_some


def test_a_replay_with_tows_and_kits_is_accepted() -> None:
    """Masses towed and kits brought back are in what a replay says of tanks."""
    for instance, plan in (towed(), (launched.campaign(), launched.planned())):
        uncertainty = Uncertainty(
            capture={"success": 0.6}, legs={"delta_v_factor": {"lognormal_sigma": 0.03}}
        )
        for seed in range(3):
            made = replay(Setting(instance, plan, uncertainty, "follow"), seed)
            assert adr_opt.check(made.instance, made.plan) == ()
            assert made.plan.objective == pytest.approx(made.outcome.prize)


def test_what_does_not_fit_is_refused() -> None:
    """Unknown policies, plans of other instances, and policies without a plan are refused."""
    instance, plan = tiny()
    known = "beam, follow, learned, ppo, replan, skip"
    with pytest.raises(InputError, match=f"unknown; use one of: {known}"):
        rehearse(instance, plan, CERTAIN, policy="none", samples=1)
    with pytest.raises(InputError, match="follows a plan; give one"):
        setting_of(instance, None, CERTAIN, "follow")
    other = adr_opt.generate("tiny", seed=1)
    with pytest.raises(InputError, match="belongs to the instance"):
        rehearse(other, plan, CERTAIN, samples=1)
    with pytest.raises(InputError, match="samples = 0"):
        rehearse(instance, plan, CERTAIN, samples=0)
    limited = instance.replace(
        stations=tuple(each.replace(max_refuellings=1) for each in instance.stations)
    )
    with pytest.raises(InputError, match="limited refuellings"):
        setting_of(limited, None, CERTAIN, "replan")
    first, *others = instance.targets
    falls = first.replace(prize_until=((1e4, first.prize),))
    with pytest.raises(InputError, match="prize_until"):
        setting_of(instance.replace(targets=(falls, *others)), None, CERTAIN, "replan")


def test_a_policy_that_plans_begins_without_a_plan() -> None:
    """`replan` makes a plan of its own where none is given."""
    instance, _ = tiny()
    made = rehearse(instance, None, CERTAIN, policy="replan", samples=1)
    assert made.outcomes[0].prize == made.plan.objective > 0.0


def test_equal_prizes_have_no_error() -> None:
    """The standard error of equal values is 0 to the last bit, and their mean is the value."""
    for value in (0.1, 4.0 / 3.0, 1e9 / 7.0):
        told = summary([value] * 7)
        assert (told["mean"], told["standard_error"]) == (value, 0.0)
    assert share([True] * 6) == {"share": 1.0, "standard_error": 0.0}


def test_answers_have_the_fields_of_the_contract() -> None:
    """The JSON answer has means, standard errors and quantiles of prize, tanks and last day."""
    instance, plan = tiny()
    told = rehearse(instance, plan, drawn_uncertainty(instance, 1), samples=20).to_dict()
    json.dumps(told)
    for each in (told["prize"], told["last_day"], told["tanks"][0]["left_m_s"]):
        assert set(each) == {"mean", "standard_error", "quantiles"}
        values = list(each["quantiles"].values())
        assert values == sorted(values)
    lost = sum(each["share"] for each in told["lost_targets"])
    assert lost == pytest.approx(sum(told["losses"].values()))
