"""Planning, refining and planning again: plans that hold, or the reason why none does."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from brute_force import brute_force
from conftest import Cli, refused
from fields import eccentric
from seeds import first_of
from small_missions import random_mission

import adr_opt
from adr_opt.common.stop import Interrupted
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.flight.tanks import tanks_of
from adr_opt.fly.refine import RefinedPlan
from adr_opt.fly.refine.lessons import Lessons
from adr_opt.fly.refine.loop import RefinedResult
from adr_opt.kernels.legs.found import ConnectionArrays
from adr_opt.legs.corrections import Corrections
from adr_opt.mission.mission import Mission
from adr_opt.plan.plan import InstanceReference, Plan
from adr_opt.plan.refined_plan import reference
from adr_opt.problem.instance import Instance

QUICK = "greedy-guarded"


def on_ellipses(seed: int, dynamics: str, tank_m_s: float) -> Instance:
    """A tiny field with e up to 0.02: what the plan's own burns cost is far from the plan."""
    drawn = adr_opt.generate("tiny", seed).replace(dynamics=dynamics)
    return eccentric(drawn, 0.02, seed).with_limits(delta_v_m_s=tank_m_s)


@cache
def breaking() -> tuple[Instance, RefinedResult]:
    """A mission whose first plan breaks its tank when refined, planned until it holds."""
    instance = on_ellipses(0, "j2", 600.0)
    return instance, adr_opt.solve_refined(instance, "exact", freedom="planned", time_limit=60.0)


def assert_holds(instance: Instance, found: RefinedResult) -> None:
    """The plan is one of the instance, and flown by the other integrator it holds."""
    assert found.holds, found.reason
    assert found.plan is not None
    assert found.refined is not None
    assert adr_opt.check(instance, found.plan) == ()
    assert fly_refined(instance, found.refined).holds
    assert len(found.refined.legs) == len(found.plan.legs)
    assert found.refined.plan == reference(found.plan)


def test_a_plan_that_breaks_its_tank_is_planned_again() -> None:
    """The first plan breaks a tank when refined, and the loop ends with one that holds."""
    instance, found = breaking()
    assert len(found.rounds) > 1
    assert any("is over by" in trouble for trouble in found.rounds[0].troubles)
    assert found.rounds[-1].corrections
    assert_holds(instance, found)


def test_what_is_proven_is_said_of_the_corrected_connections() -> None:
    """A proof over corrected connections is in the notes, and not a bound of the plan's file."""
    instance, found = breaking()
    assert found.plan is not None
    (note,) = [note for note in found.plan.notes if "of the corrected connections" in note]
    assert note.startswith("no plan of the corrected connections collects more than")
    assert found.plan.upper_bound is None
    first = adr_opt.solve(instance, "exact", time_limit=60.0)
    assert found.result.upper_bound <= first.upper_bound + 1e-9


def test_a_plan_that_holds_at_once_keeps_its_proof() -> None:
    """Without corrections the bound is one of the instance, and stays in the plan."""
    instance = adr_opt.generate("tiny", 1).replace(dynamics="j2")
    found = adr_opt.solve_refined(instance, "exact", time_limit=60.0)
    assert len(found.rounds) == 1
    assert_holds(instance, found)
    assert found.plan is not None
    assert found.plan.status == "optimal"
    assert not any("corrected" in note for note in found.plan.notes)


@pytest.mark.parametrize("freedom", ["free", "planned"])
@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
@pytest.mark.parametrize("seed", first_of(range(4), gate=2))
def test_every_mission_ends_with_a_plan_that_holds(seed: int, dynamics: str, freedom: str) -> None:
    """Whatever the tank and the burns, what is returned holds in the other integrator."""
    instance = on_ellipses(seed, dynamics, [250.0, 400.0, 700.0, 1200.0][seed])
    found = adr_opt.solve_refined(instance, QUICK, freedom=freedom, seed=seed)
    if found.reason:
        assert found.refined is None or found.rounds[-1].troubles
    else:
        assert_holds(instance, found)


def test_the_margin_is_kept_back_of_flown_delta_v() -> None:
    """With a margin no tank is flown further than what is left of it."""
    instance = on_ellipses(0, "j2", 600.0)
    found = adr_opt.solve_refined(instance, QUICK, freedom="planned", margin=0.1)
    assert_holds(instance, found)
    assert found.refined is not None
    for tank in fly_refined(instance, found.refined).tanks:
        assert tank.flown_delta_v_m_s is not None
        assert tank.flown_delta_v_m_s <= 0.9 * 600.0 + 1e-6


def test_a_mission_that_cannot_hold_ends_with_a_reason(cli: Cli) -> None:
    """Where a required target costs more when flown than the tank has, that is said with status 1.

    By the model there is a plan, and the command line writes it before it says that it breaks.
    """
    whole = on_ellipses(0, "j2", 5000.0)
    first = adr_opt.solve(whole.replace(targets=whole.targets[:1]), "exact").plan
    assert first is not None
    alone = whole.replace(targets=(whole.targets[0].replace(required=True),))
    leg = first.legs[0]
    flown = adr_opt.refine(alone, first.replace(instance=reference_to(alone)), freedom="planned")
    over = flown.legs[0].flown_delta_v_m_s - leg.delta_v_m_s
    assert over > 1.0
    tight = alone.with_limits(delta_v_m_s=leg.delta_v_m_s + 0.01 * over)
    Path("my.json").write_text(tight.to_json(), encoding="utf-8")
    told = cli(
        "solve my.json --method exact --refine --burns planned --refined-out r.json --out p.json"
    )
    assert told.status == 1
    assert "found no plan" in told.err
    assert "services all required targets" in told.err


def reference_to(instance: Instance) -> InstanceReference:
    """What names an instance in a plan."""
    return InstanceReference(name=instance.name, sha256=instance.sha256)


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
@pytest.mark.parametrize("seed", first_of(range(8), gate=4))
def test_corrected_missions_equal_brute_force(seed: int, dynamics: str) -> None:
    """Over corrected connections the exact method proves what brute force finds, and plans hold."""
    instance = random_mission(seed, zones=False).instance.replace(dynamics=dynamics)
    rng = np.random.default_rng(seed)
    pairs = [(a, b) for a in instance.names for b in instance.names if a != b]
    shares = {
        (a, b, "short"): float(rng.choice([0.9, 1.2, 2.0, math.inf]))
        for a, b in pairs
        if rng.random() < 0.5
    }
    corrections = Corrections(shares, {"short": 1.15}, {"short": 20.0})
    corrected = Mission(instance, threads=1).corrected(corrections)
    best, _, _ = brute_force(corrected)
    result = adr_opt.solve(corrected, "exact", time_limit=60.0)
    assert result.objective == pytest.approx(best)
    assert result.upper_bound == pytest.approx(best, abs=1e-5)
    bound = adr_opt.bound(corrected, "lagrangian", time_limit=60.0)
    assert bound.upper_bound >= best - 1e-6
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    assert best <= brute_force(Mission(instance, threads=1))[0]


def test_corrected_connections_cost_what_is_said() -> None:
    """A pair costs its share of factor and addition of its kind, and a barred one is gone."""
    instance = adr_opt.generate("tiny", 0)
    a, b, c, d = instance.names[:4]
    corrections = Corrections(
        {(a, b, "short"): 1.1, (a, c, "short"): math.inf}, {"short": 1.25}, {"short": 12.5}
    )
    model, corrected = Mission(instance), Mission(instance).corrected(corrections)
    before = model.timetable.connections(a, b, resolution_m_s=0.0)
    after = corrected.timetable.connections(a, b, resolution_m_s=0.0)
    assert np.array_equal(after.departure, before.departure)
    assert after.delta_v == pytest.approx(1.1 * (1.25 * before.delta_v + 12.5))
    assert corrected.timetable.connections(a, c).departure.size == 0
    other = corrected.timetable.connections(a, d, resolution_m_s=0.0)
    assert other.delta_v == pytest.approx(
        1.25 * model.timetable.connections(a, d, resolution_m_s=0.0).delta_v + 12.5
    )
    assert corrections.corrected(a, b, "short", 100.0) == pytest.approx(151.25)
    assert corrections.modelled(a, b, "short", 151.25) == pytest.approx(100.0)
    assert corrections.modelled(a, d, "short", 137.5) == pytest.approx(100.0)
    assert corrections.modelled(a, b, "drift", 100.0) == 100.0


def test_corrections_make_sense() -> None:
    """Nothing becomes free, and what corrects nothing changes nothing."""
    with pytest.raises(ValueError, match="factors"):
        Corrections({}, {"short": 0.0})
    with pytest.raises(ValueError, match="shares"):
        Corrections({("a", "b", "short"): 0.0})
    with pytest.raises(ValueError, match="additions_m_s"):
        Corrections({}, {}, {"drift": -1.0})
    assert not Corrections({("a", "b", "short"): 1.0}, {"short": 1.0}, {"drift": 0.0})
    assert Corrections({}, {}, {"drift": 5.0})
    assert Corrections({("a", "b", "short"): math.inf})
    nothing = ConnectionArrays(*(np.empty(0) for _ in range(6)))
    assert Corrections().applied("a", "b", nothing) is nothing


def test_lessons_are_the_dearest_leg_and_the_mean() -> None:
    """A pair costs what its dearest leg did, others the mean factor, and the lost are barred."""
    _, found = breaking()
    plan, refined = found.plan, found.refined
    assert plan is not None
    assert refined is not None
    lost = refined.replace(
        legs=refined.legs[1:], status="incomplete", missing=[{"leg": 1, "reason": "no way"}]
    )
    lessons = Lessons(breaking()[0])
    lessons.learn(plan, lost)
    lessons.learn(plan, lost)
    corrections = lessons.corrections
    first = plan.legs[0]
    assert corrections.shares[first.origin, first.destination, "short"] == math.inf
    mean = lost.flown_delta_v_m_s / lost.planned_delta_v_m_s
    assert corrections.factors["short"] == pytest.approx(max(1.0, mean))
    assert corrections.additions_m_s["short"] == 0.0
    for leg in lost.legs:
        costs = leg.planned_delta_v_m_s, leg.flown_delta_v_m_s
        charged = corrections.corrected(leg.origin, leg.destination, leg.kind, costs[0])
        assert charged == pytest.approx(max(costs))
    saving = Lessons(breaking()[0], spend_savings=True)
    saving.learn(plan, lost)
    for leg in lost.legs:
        charged = saving.corrections.corrected(
            leg.origin, leg.destination, leg.kind, leg.planned_delta_v_m_s
        )
        assert charged == pytest.approx(leg.flown_delta_v_m_s)


@pytest.mark.parametrize("spend_savings", [False, True])
def test_whatever_is_learnt_a_plan_costs_what_its_legs_did(spend_savings: bool) -> None:
    """After any lessons no leg of any of them costs less than flown, nor unasked than planned."""
    rng = np.random.default_rng(0)
    plan = breaking()[1].plan
    assert plan is not None
    flown = breaking()[1].refined
    assert flown is not None
    lessons, heard = Lessons(breaking()[0], spend_savings), []
    for _ in range(12):
        legs = []
        for leg in flown.legs:
            kind = str(rng.choice(["short", "drift"]))
            planned, share = float(rng.uniform(5.0, 300.0)), float(rng.uniform(0.6, 1.6))
            cost = share * planned + (float(rng.uniform(0.0, 150.0)) if kind == "drift" else 0.0)
            made = leg.model_copy(
                update={"kind": kind, "planned_delta_v_m_s": planned, "flown_delta_v_m_s": cost}
            )
            legs.append(made)
        heard += legs
        lessons.learn(plan, flown.model_copy(update={"legs": tuple(legs)}))
        corrections = lessons.corrections
        for leg in heard:
            charged = corrections.corrected(
                leg.origin, leg.destination, leg.kind, leg.planned_delta_v_m_s
            )
            assert charged >= leg.flown_delta_v_m_s * (1.0 - 1e-12)
            for planned in (1.0, 1000.0) if not spend_savings else ():
                costs = corrections.corrected(leg.origin, leg.destination, leg.kind, planned)
                assert costs >= planned * (1.0 - 1e-12)
                assert corrections.corrected("a", "b", leg.kind, planned) >= planned


def test_what_drifting_legs_cost_more_is_an_addition() -> None:
    """Phase costs a drift the same however cheap it is; of few legs the mean excess is told."""
    shape = breaking()[1].refined
    plan = breaking()[1].plan
    assert shape is not None
    assert plan is not None
    one = shape.legs[0]

    def told(costs: list[tuple[float, float]]) -> Corrections:
        lessons = Lessons(breaking()[0])
        legs = tuple(
            one.model_copy(
                update={
                    "kind": "drift",
                    "destination": f"d{at}",
                    "planned_delta_v_m_s": planned,
                    "flown_delta_v_m_s": flown,
                }
            )
            for at, (planned, flown) in enumerate(costs)
        )
        lessons.learn(plan, shape.model_copy(update={"legs": legs}))
        return lessons.corrections

    few = told([(20.0, 120.0), (100.0, 180.0)])
    assert few.of_kind("drift") == (1.0, pytest.approx(90.0))
    many = told([(20.0, 110.0), (100.0, 198.0), (200.0, 308.0), (300.0, 418.0)])
    assert many.of_kind("drift") == (pytest.approx(1.1), pytest.approx(88.0))
    cheap = told([(20.0, 18.0), (100.0, 90.0)])
    assert cheap.of_kind("drift") == (1.0, 0.0)


def test_savings_are_spent_where_one_wants_to() -> None:
    """Free burns save ΔV: counted on, they let a mission short of ΔV do more, and still it holds.

    Unasked no connection becomes cheaper than the model.
    """
    instance = adr_opt.generate("tiny", 0).replace(dynamics="j2")
    least = adr_opt.solve_refined(instance, "exact", time_limit=60.0)
    assert least.plan is not None
    needed = max(tank.planned_delta_v_m_s for tank in tanks_of(instance, least.refined))
    tight = instance.with_limits(delta_v_m_s=0.97 * needed)
    plain = adr_opt.solve_refined(tight, "exact", time_limit=60.0)
    assert_holds(tight, plain)
    lessons = Lessons(tight)
    lessons.learn(plain.plan, plain.refined)
    assert lessons.corrections.factors == {"short": 1.0}
    spent = adr_opt.solve_refined(tight, "exact", time_limit=60.0, spend_savings=True)
    assert spent.holds
    assert fly_refined(tight, spent.refined).holds
    assert spent.rounds[1].corrections.factors["short"] < 0.95
    assert (spent.plan.objective, -spent.refined.flown_delta_v_m_s) >= (
        plain.plan.objective,
        -plain.refined.flown_delta_v_m_s,
    )
    overdrawn = {violation.rule for violation in adr_opt.check(tight, spent.plan)}
    assert overdrawn <= {"delta-v"}
    assert bool(overdrawn) == any("by the model a tank needs" in note for note in spent.plan.notes)


@pytest.mark.parametrize("bound", [None, "lagrangian"])
def test_what_is_proven_of_savings_is_no_bound_of_the_instance(bound: str | None) -> None:
    """A plan that spends savings collects more than is proven possible by the model.

    So it states no bound, nor that it is optimal: what is proven is in the notes, and of the
    corrected connections.
    """
    tight = adr_opt.generate("tiny", 0).replace(dynamics="j2").with_limits(delta_v_m_s=450.0)
    proven = adr_opt.solve(tight, "exact", time_limit=60.0).upper_bound
    spent = adr_opt.solve_refined(tight, "exact", time_limit=60.0, spend_savings=True, bound=bound)
    assert spent.plan is not None
    assert fly_refined(tight, spent.refined).holds
    assert spent.plan.objective > proven
    assert {violation.rule for violation in adr_opt.check(tight, spent.plan)} == {"delta-v"}
    plan = spent.plan
    assert (plan.upper_bound, plan.gap, plan.cost_bound, plan.cost_gap) == (None,) * 4
    assert plan.status == "feasible"
    (note,) = [note for note in plan.notes if "collects more than" in note]
    assert "of the corrected connections" in note


def test_when_rounds_are_over_what_holds_of_a_plan_is_kept() -> None:
    """After one round of a plan that breaks its tank, the legs before that are the plan."""
    instance, _ = breaking()
    found = adr_opt.solve_refined(instance, "exact", freedom="planned", rounds=1)
    assert len(found.rounds) == 1
    assert found.rounds[0].troubles
    assert_holds(instance, found)
    assert found.plan is not None
    assert found.plan.objective < found.rounds[0].objective
    assert any("hold when refined" in note for note in found.plan.notes)


def test_what_holds_of_a_route_with_kits_takes_fewer_of_them_along() -> None:
    """Legs that are kept have the masses of a chaser that takes no kits for those left out."""
    instance = on_ellipses(2, "j2", 600.0)
    chaser = instance.chaser.replace(
        tank={"dry_mass_kg": 100.0, "propellant_kg": 24.0, "isp_s": 300.0}, kit_mass_kg=2.0
    )
    targets = tuple(target.replace(removal="kit") for target in instance.targets)
    instance = instance.replace(chasers=(chaser,), targets=targets)
    found = adr_opt.solve_refined(instance, "exact", freedom="planned", rounds=1, time_limit=60.0)
    assert found.rounds[0].troubles
    assert_holds(instance, found)
    assert found.plan is not None
    assert 0.0 < found.plan.objective < found.rounds[0].objective


def test_who_interrupts_gets_what_there_is() -> None:
    """With a stop that leaves no time the loop ends after the first round."""
    instance, _ = breaking()
    stop = Interrupted()
    stop.interrupt()
    found = adr_opt.solve_refined(instance, QUICK, freedom="planned", stop=stop)
    assert len(found.rounds) <= 1
    if found.holds:
        assert_holds(instance, found)
    else:
        assert found.reason


def test_solve_refine_writes_a_plan_that_flies(cli: Cli) -> None:
    """`solve --refine` writes plan and refined plan; `check` and `fly` accept them."""
    instance, _ = breaking()
    Path("my.json").write_text(instance.to_json(), encoding="utf-8")
    arguments = ("solve", "my.json", "--method", "exact", "--refine", "--burns", "planned")
    told = cli(*arguments, "--out", "p.json", "--refined-out", "r.json")
    assert told.status == 0, told
    assert "round 1: prize" in told.err
    assert "wrote r.json" in told.err
    assert "the plan holds when refined" in told.out
    assert cli("check", "my.json", "p.json").status == 0
    flown = cli("fly", "my.json", "r.json")
    assert flown.status == 0
    assert "every tank holds" in flown.out
    as_json = cli(*arguments, "--json", "--quiet", "--gravity", "j3", "--rounds", "7")
    content = json.loads(as_json.out)
    assert content["holds"] is True
    assert content["rounds"][0]["troubles"]
    assert Plan.from_json(json.dumps(content["plan"])).legs
    assert as_json.err == ""
    refined = adr_opt.load_refined("r.json")
    assert isinstance(refined, RefinedPlan)
    assert content["flown_delta_v_m_s"] != refined.flown_delta_v_m_s


def test_options_of_refining_need_refine(cli: Cli) -> None:
    """Without `--refine` they are refused in one sentence, and so are rounds below 1."""
    Path("my.json").write_text(adr_opt.generate("tiny", 0).to_json(), encoding="utf-8")
    refused(cli("solve", "my.json", "--refined-out", "r.json"), "--refined-out r.json: nothing is")
    refused(cli("solve", "my.json", "--gravity", "j2"), "add --refine")
    refused(cli("solve", "my.json", "--refine", "--rounds", "0"), "rounds = 0")
    refused(
        cli("solve", "my.json", "--refine", "--out", "a.json", "--refined-out", "a.json"), "a.json"
    )
    assert not Path("r.json").exists()
