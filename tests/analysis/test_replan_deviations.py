"""``replan`` with what went otherwise: failed captures and legs, services and costs."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli, refused
from hand_made import PERIOD_S, hand_made
from on_from import violations
from random_rules import (
    carrying,
    drifting_mission,
    mixed_campaign,
    random_campaign,
    random_mission,
    towing,
)
from toy_roads import solved
from two_chasers import campaign, planned

import adr_opt
from adr_opt.analysis import Replanned, price, replan
from adr_opt.analysis.replan.chaser_states import ChaserState, states_at
from adr_opt.analysis.replan.deviations import Deviations
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import AtStation, InOrbit, TankByMass
from adr_opt.problem.instance import Instance

TANK = TankByMass(dry_mass_kg=400.0, propellant_kg=72.0, isp_s=310.0)
ORDER = ("south", "station", "north", "beyond")


@cache
def simple(*, by_mass: bool = False) -> tuple[Instance, Plan]:
    """The hand-made instance, with its plan of four legs."""
    instance = hand_made()
    if by_mass:
        instance = instance.replace(chasers=(instance.chaser.replace(tank=TANK),))
    return instance, price(instance, {"chaser": ORDER}).plan()


def state_of(instance: Instance, plan: Plan, at_s: float, **told) -> ChaserState:
    """Where the chaser is by then, before it refuels or does anything else that is new."""
    (state,) = states_at(instance, plan, at_s, went=Deviations(**told))
    return state


def passes(made: Replanned) -> bool:
    """Whether there is a rest, and `check` finds nothing in it."""
    return made.plan is not None and adr_opt.check(made.instance, made.plan) == ()


@pytest.mark.parametrize("by_mass", [False, True])
def test_a_missed_target_is_given_up_or_tried_again(by_mass: bool) -> None:
    """The chaser is at it with what is left; it is in the rest only if it may be tried again."""
    instance, plan = simple(by_mass=by_mass)
    leg = plan.legs[2]
    at_s = leg.end_s + 1.0
    as_planned = states_at(instance, plan, at_s)[0]
    gone = replan(instance, plan, at_s, missed=["north"])
    (state,) = gone.states
    assert state.body == "north"
    assert state.missed == gone.given_up == ("north",)
    assert state.left_m_s == as_planned.left_m_s
    assert state.free_s == at_s
    assert "north" not in gone.instance.names
    assert passes(gone)
    again = replan(instance, plan, at_s, missed=["north"], retry=True)
    assert again.missed == ("north",)
    assert again.given_up == ()
    assert passes(again)
    first = next(leg for leg in again.plan.legs if leg.destination == "north")
    # To come once more to where one is, one flies the last kilometre once more.
    assert first.delta_v_m_s < 1.0
    assert "north" in again.plan.destinations
    assert again.gained == ("north",)


def test_who_is_under_way_to_a_target_that_is_missed_is_free_on_arrival() -> None:
    """Before the arrival nothing has been tried; while it is tried, the attempt ends at once."""
    instance, plan = simple()
    leg = plan.legs[0]
    for at_s, free_s in (
        (leg.leaves_s + 1.0, leg.arrival_s),
        (0.5 * (leg.arrival_s + leg.end_s), 0.5 * (leg.arrival_s + leg.end_s)),
        (leg.end_s + 5.0, leg.end_s + 5.0),
    ):
        state = state_of(instance, plan, at_s, missed=("south",))
        assert state.free_s == free_s
        assert state.body == "south"
        assert passes(replan(instance, plan, at_s, missed=["south"]))


def test_a_missed_target_that_was_left_behind_stays_so() -> None:
    """A leg after it that has begun is finished, which a note says, and it may be tried again.

    Who is still there says how long it was tried, and then the leg after it has not begun.
    """
    instance, plan = simple()
    at_s = plan.legs[3].leaves_s + 1.0
    made = replan(instance, plan, at_s, missed=["north"], retry=True)
    assert made.states[0].body == "beyond"
    assert "north" in made.instance.names
    assert "leg 4 to beyond had begun" in made.notes[0]
    tried_s = at_s - plan.legs[2].arrival_s
    still = replan(instance, plan, at_s, missed=["north"], services_s={"north": tried_s})
    assert still.states[0].body == "north"
    assert still.states[0].free_s == pytest.approx(at_s)
    assert "leg 4 to beyond was to begin before" in still.notes[0]
    assert "beyond" in still.instance.names
    assert passes(still)


def test_kits_of_a_missed_target_are_aboard() -> None:
    """Its kit weighs on and may be used elsewhere, and what was refuelled is counted with it."""
    field, _ = simple(by_mass=True)
    targets = tuple(target.replace(removal="kit") for target in field.targets)
    station = field.stations[0].replace(max_propellant_kg=500.0)
    chaser = field.chaser.replace(kits=3, kit_mass_kg=6.0)
    instance = field.replace(targets=targets, chasers=(chaser,), stations=(station,))
    plan = price(instance, {"chaser": ORDER}).plan()
    at_s = plan.legs[0].end_s + 1.0
    done = state_of(instance, plan, at_s)
    missed = state_of(instance, plan, at_s, missed=("south",))
    assert (done.kits, missed.kits) == (2, 3)
    # The same burns with as much aboard; without the kit the same propellant is worth more.
    assert missed.left_m_s < done.left_m_s
    assert missed.propellant_kg == pytest.approx(done.propellant_kg, abs=1e-9)
    later_s = plan.legs[1].end_s + 1.0
    made = replan(instance, plan, later_s, missed=["south"], method="exact")
    assert passes(made)
    used = [
        500.0 - each.instance.stations[0].max_propellant_kg
        for each in (replan(instance, plan, later_s, method="exact"), made)
    ]
    assert used[1] > used[0] + 0.01


def test_a_missed_target_is_none_of_the_most_that_a_chaser_services() -> None:
    """Who may service two targets and has missed one may still service two."""
    field, _ = simple()
    instance = field.replace(chasers=(field.chaser.replace(max_targets=3),))
    plan = price(instance, {"chaser": ORDER}).plan()
    made = replan(instance, plan, plan.legs[0].end_s, missed=["south"])
    assert made.instance.chaser.max_targets == 3
    assert replan(instance, plan, plan.legs[0].end_s).instance.chaser.max_targets == 2


def test_a_service_that_took_longer_or_shorter_moves_when_the_chaser_is_free() -> None:
    """It is free from the end of the service, not before the time asked for; nothing else moves."""
    instance, plan = simple()
    leg = plan.legs[0]
    at_s = leg.arrival_s + 10.0
    for took_s in (600.0, 2.5 * PERIOD_S):
        state = state_of(instance, plan, at_s, services_s={"south": took_s})
        assert state.free_s == pytest.approx(leg.arrival_s + took_s)
        assert state.left_m_s == state_of(instance, plan, at_s).left_m_s
        made = replan(instance, plan, at_s, services_s={"south": took_s})
        assert "south" not in made.instance.names
        assert passes(made)
    # Before the arrival it is told what it will take.
    early = state_of(instance, plan, leg.leaves_s + 1.0, services_s={"south": 600.0})
    assert early.free_s == pytest.approx(leg.arrival_s + 600.0)


def test_a_service_beyond_the_mission_leaves_nothing_to_do() -> None:
    """The rest is empty; where the chaser has to end at a station, there is none."""
    instance, plan = simple()
    at_s, services_s = plan.legs[0].arrival_s, {"south": 30.0 * DAY_S}
    made = replan(instance, plan, at_s, services_s=services_s)
    assert passes(made)
    assert made.plan.legs == ()
    chaser = instance.chaser.replace(end=AtStation(station="station"))
    returning = instance.replace(chasers=(chaser,))
    plan = price(returning, {"chaser": ORDER[:2]}).plan()
    assert replan(returning, plan, at_s, services_s=services_s).plan is None


def test_a_leg_that_was_to_begin_within_a_service_has_not_begun() -> None:
    """Where a service took longer, what was to follow meanwhile is planned anew, and so is said."""
    instance, plan = simple()
    second = plan.legs[1]
    took_s = second.leaves_s + 500.0 - plan.legs[0].arrival_s
    made = replan(instance, plan, second.leaves_s + 900.0, services_s={"south": took_s})
    state = state_of(instance, plan, second.leaves_s + 900.0, services_s={"south": took_s})
    assert [leg.destination for leg in state.legs] == ["south"]
    assert state.free_s == second.leaves_s + 900.0
    assert made.former[0][0] == "station"
    assert "leg 2 to station was to begin before the service at south is over" in made.notes[0]
    assert passes(made)
    with pytest.raises(InputError, match="keep fewer legs"):
        replan(instance, plan, second.leaves_s + 1.0, services_s={"south": took_s}, keep=1)


@pytest.mark.parametrize("by_mass", [False, True])
def test_a_leg_that_took_more_leaves_less(by_mass: bool) -> None:
    """What is left is less by that, until the chaser refuels, and the rest has no more."""
    instance, plan = simple(by_mass=by_mass)
    leg = plan.legs[0]
    planned_m_s = leg.delta_v_m_s
    at_s = leg.end_s
    before = state_of(instance, plan, at_s)
    state = state_of(instance, plan, at_s, costs_m_s={1: planned_m_s + 20.0})
    assert before.left_m_s - state.left_m_s == pytest.approx(20.0)
    assert state.legs[0].delta_v_m_s == planned_m_s + 20.0
    made = replan(instance, plan, at_s, costs_m_s={1: planned_m_s + 20.0}, method="exact")
    assert passes(made)
    if by_mass:
        assert state.propellant_kg < before.propellant_kg - 1.0
    # The way to the station is paid from what is left, also where a rest begins with it.
    assert state.left_m_s >= 131.0
    full = state_of(instance, plan, plan.legs[1].end_s, costs_m_s={1: planned_m_s + 20.0})
    assert full.left_m_s == pytest.approx(instance.chaser.tank.delta_v_m_s)
    # With so little left the station is out of reach, which is what the rest was to begin with.
    stranded = replan(instance, plan, at_s, costs_m_s={1: planned_m_s + before.left_m_s - 100.0})
    assert stranded.plan is not None
    assert stranded.plan.destinations == ()
    assert stranded.instance.chaser.spent_m_s == pytest.approx(
        instance.chaser.tank.delta_v_m_s - 100.0
    )


def test_what_a_tank_does_not_hold_no_leg_can_have_taken() -> None:
    """Neither the leg itself nor one after it that has begun, which is named."""
    instance, plan = simple()
    with pytest.raises(InputError, match="leg 1 to 'south': the tank would lack 100 m/s"):
        replan(instance, plan, plan.legs[0].end_s, costs_m_s={1: 400.0})
    with pytest.raises(InputError, match="leg 2 to 'station': the tank would lack"):
        replan(instance, plan, plan.legs[1].leaves_s + 1.0, costs_m_s={1: 250.0})


def test_a_failed_leg_is_not_flown_as_planned() -> None:
    """Its chaser flies what comes before it, does not leave then, and goes on later."""
    instance, plan = simple()
    for failed in (1, 2, 3, 4):
        leg = plan.legs[failed - 1]
        made = replan(instance, plan, 0.0, failed=failed)
        (state,) = states_at(instance, plan, 0.0, failed=failed)
        assert state.legs == plan.legs[: failed - 1]
        assert state.free_s > leg.leaves_s
        assert passes(made)
        assert violations(instance, made) == ()
        (route,) = made.whole()
        assert all(
            (each.destination, each.departure_s) != (leg.destination, leg.departure_s)
            for each in route.legs
        )
        assert all(each.leaves_s > leg.leaves_s for each in route.legs[failed - 1 :])
    # It may be flown later.
    assert replan(instance, plan, 0.0, failed=4).former == (("beyond",),)
    longer = instance.with_limits(duration_s=20.0 * PERIOD_S)
    plan = price(longer, {"chaser": ORDER}).plan()
    assert replan(longer, plan, 0.0, failed=4).plan.destinations[-1] == "beyond"


def test_a_failed_leg_of_a_campaign_is_that_of_its_chaser() -> None:
    """The other one is where it is at the time; the leg leaves later, or never."""
    instance, plan = campaign(), planned()
    first, second = (route.legs for route in plan.routes)
    failed = len(first) + 2
    leg = second[1]
    made = replan(instance, plan, 0.0, failed=failed, time_limit=60.0)
    one, two = states_at(instance, plan, 0.0, failed=failed)
    assert one.legs == ()
    assert two.legs == second[:1]
    assert two.free_s > leg.leaves_s
    assert passes(made)
    assert violations(instance, made) == ()


def drawn(seed: int) -> tuple[Instance, Plan | None]:
    """One chaser or several, by turns with kits and tows, in all dynamics, and some plan."""
    draw = drifting_mission if seed % 2 else random_mission
    make = (draw, lambda n: random_campaign(n, draw), lambda n: mixed_campaign(n, draw))[seed % 3]
    instance = make(seed // 2)
    if seed % 4 < 2:
        instance = carrying(instance, seed)
    if seed % 5 < 3:
        instance = towing(instance, seed)
    return instance, adr_opt.solve(instance, "greedy", time_limit=60.0).plan


@pytest.mark.slow
def test_whatever_went_otherwise_the_rest_is_a_plan() -> None:
    """Of drawn missions with kits, tows and drifts `check` reads it, and what is told is there."""
    seen = dict.fromkeys(("missed", "tow", "kit", "drift", "cost", "took", "failed", "several"), 0)
    for seed in range(48):
        instance, plan = drawn(seed)
        if plan is None or not plan.legs:
            continue
        rng = np.random.default_rng([42, seed])
        number = int(rng.integers(len(plan.legs)))
        leg = plan.legs[number]
        targets = {target.name: target for target in instance.targets}
        at_s = min(
            float(rng.uniform(leg.leaves_s + 1.0, leg.end_s + 1.0)), instance.mission.duration_s
        )
        told: dict = {}
        kind = ("missed", "cost", "took", "failed")[seed % 4]
        is_target = leg.destination in targets
        if kind == "missed" and is_target:
            told = {"missed": [leg.destination], "retry": bool(rng.random() < 0.6)}
        elif kind == "took" and is_target:
            told = {
                "services_s": {
                    leg.destination: float(rng.uniform(0.3, 2.0)) * (leg.end_s - leg.arrival_s)
                }
            }
        elif kind == "cost":
            told = {"costs_m_s": {number + 1: leg.delta_v_m_s * float(rng.uniform(0.5, 1.0))}}
        elif kind == "failed":
            told, at_s = {"failed": number + 1}, max(leg.ready_s - 10.0, 0.0)
            at_s = min(at_s, instance.mission.duration_s)
        made = replan(instance, plan, at_s, time_limit=60.0, **told)
        if made.plan is None:
            # A required target, or the way home, may be out of reach after that.
            continue
        assert adr_opt.check(made.instance, made.plan) == (), seed
        if kind == "missed" and is_target:
            (state,) = (each for each in made.states if leg in plan_legs(plan, each))
            assert (leg.destination in made.instance.names) == told["retry"], seed
            assert not state.is_put
            assert state.missed == (leg.destination,)
            assert all(each.tow is None for each in state.legs if each.destination in state.missed)
            seen["tow"] += targets[leg.destination].removal == "tow"
            seen["kit"] += targets[leg.destination].removal == "kit"
        if kind == "failed":
            assert all(
                (each.destination, each.departure_s) != (leg.destination, leg.departure_s)
                for route in made.whole()
                for each in route.legs
            ), seed
        seen[kind] += bool(told)
        seen["drift"] += leg.kind == "drift" and bool(told)
        seen["several"] += len(instance.chasers) > 1 and bool(told)
    assert all(seen.values()), seen


def plan_legs(plan: Plan, state) -> tuple:
    """The legs that the plan has for the chaser of a state."""
    routes = {route.chaser: route.legs for route in plan.routes}
    return routes.get(state.chaser.name, () if len(plan.routes) > 1 else plan.legs)


@cache
def towed() -> tuple[Instance, Plan]:
    """Three objects that are towed one after the other, and the plan."""
    field = adr_opt.generate("tiny", 1, targets=3).with_limits(duration_s=200_000.0)
    start = InOrbit(orbit=field.stations[0].orbit)
    tank = TankByMass(dry_mass_kg=500.0, propellant_kg=600.0, isp_s=310.0)
    instance = field.replace(
        stations=(),
        chasers=(field.chaser.replace(start=start, tank=tank),),
        targets=tuple(
            target.replace(removal="tow", mass_kg=250.0, required=False) for target in field.targets
        ),
        mission=field.mission.replace(disposal={"circle_m": 450e3}),
    )
    plan = adr_opt.solve(instance, "exact", time_limit=30.0).plan
    assert plan is not None
    assert len(plan.legs) == 3
    return instance, plan


def test_an_object_that_was_missed_is_not_towed() -> None:
    """The chaser is on its orbit with the propellant of the tow, unless the tow has begun."""
    instance, plan = towed()
    leg = plan.legs[0]
    at_s = leg.end_s + 1.0
    made = replan(instance, plan, at_s, missed=[leg.destination], retry=True, method="exact")
    (state,) = made.states
    assert not state.is_put
    assert not state.is_released
    assert made.instance.chaser.start == InOrbit(
        orbit=instance.targets[
            [target.name for target in instance.targets].index(leg.destination)
        ].orbit
    )
    (normal,) = states_at(instance, plan, at_s)
    assert state.propellant_kg == pytest.approx(normal.propellant_kg)
    assert leg.destination in made.plan.destinations
    assert passes(made)
    with pytest.raises(InputError, match="leg 2 has begun by"):
        replan(instance, plan, leg.tow.start_s + 1.0, missed=[leg.destination])
    last = plan.legs[-1]
    late = replan(instance, plan, last.tow.end_s + 1.0, missed=[last.destination])
    assert not late.states[0].is_released
    assert passes(late)


def test_a_tow_waits_for_a_service_that_took_longer() -> None:
    """The object is still with the chaser when it is over, and is towed in the rest."""
    instance, plan = towed()
    leg = plan.legs[0]
    took_s = leg.tow.start_s + 500.0 - leg.arrival_s
    at_s = leg.tow.start_s + 100.0
    assert state_of(instance, plan, at_s).legs == plan.legs[:2]
    made = replan(instance, plan, at_s, services_s={leg.destination: took_s}, method="exact")
    (state,) = made.states
    assert state.is_put
    assert state.free_s == pytest.approx(leg.tow.start_s + 500.0)
    assert made.plan.legs[0].destination == leg.destination
    assert made.plan.legs[0].tow.start_s >= state.free_s - 1e-3
    assert passes(made)
    last = plan.legs[-1]
    after = replan(
        instance, plan, last.end_s, services_s={last.destination: last.end_s - last.arrival_s + 99}
    )
    assert after.states[0].is_put
    assert passes(after)


def test_a_failed_tow_begins_later() -> None:
    """A leg from a disposal orbit fails with the tow that it begins with: both are later."""
    instance, plan = towed()
    made = replan(instance, plan, plan.legs[0].end_s, failed=2, method="exact")
    (state,) = made.states
    assert state.is_put
    assert state.free_s > plan.legs[0].tow.start_s
    (route,) = made.whole()
    assert route.legs[0].tow.start_s > plan.legs[0].tow.start_s + 0.5
    assert passes(made)
    assert violations(instance, made) == ()


def test_drifting_legs_fail_and_cost_too() -> None:
    """A missed target after a drift of months is tried again; a failed drift leaves later."""
    field = adr_opt.generate("rocket-bodies", 0, targets=5).with_limits(duration_s=180.0 * DAY_S)
    plan = adr_opt.solve(field, "exact", time_limit=30.0).plan
    number, leg = next(
        (at, leg) for at, leg in enumerate(plan.legs, start=1) if leg.kind == "drift"
    )
    made = replan(field, plan, leg.end_s + 1.0, missed=[leg.destination], retry=True)
    assert passes(made)
    assert leg.destination in made.plan.destinations
    failed = replan(field, plan, 0.0, failed=number)
    assert passes(failed)
    assert violations(field, failed) == ()
    (route,) = failed.whole()
    assert all(each.leaves_s > leg.leaves_s for each in route.legs[number - 1 :])
    spent = replan(field, plan, leg.end_s + 1.0, costs_m_s={number: leg.delta_v_m_s + 5.0})
    costs = {number: leg.delta_v_m_s + 5.0}
    states = [state_of(field, plan, leg.end_s + 1.0, costs_m_s=each) for each in ({}, costs)]
    assert states[0].left_m_s - states[1].left_m_s == pytest.approx(5.0)
    assert passes(spent)


def test_missed_targets_of_campaigns_are_open_to_all() -> None:
    """Who has missed one may try again, and so may the other one; the rest passes."""
    instance, plan = campaign(), planned()
    leg = plan.routes[1].legs[0]
    at_s = leg.end_s + 1.0
    made = replan(instance, plan, at_s, missed=[leg.destination], retry=True, time_limit=60.0)
    assert passes(made)
    assert leg.destination in made.instance.names
    assert made.prize_after >= made.prize_before
    assert made.states[1].missed == (leg.destination,)
    assert made.states[0].missed == ()
    given_up = replan(instance, plan, at_s, missed=[leg.destination], time_limit=60.0)
    assert passes(given_up)
    assert leg.destination not in given_up.instance.names


def test_with_given_connections_a_missed_target_leads_on_and_is_led_to() -> None:
    """Its connections are those of the start, and still its own, if it may be tried again."""
    instance, plan = solved()
    leg = plan.legs[0]
    for retry in (False, True):
        made = replan(instance, plan, leg.end_s, missed=[leg.destination], retry=retry)
        given = made.instance.given
        assert passes(made)
        assert (leg.destination in given.names) == retry
        for other in given.names:
            if other == instance.chaser.name:
                continue
            of_old = instance.given.of_pair(leg.destination, other)
            of_start = given.of_pair(instance.chaser.name, other)
            assert all(np.array_equal(old, new) for old, new in zip(of_old, of_start, strict=True))
            if retry:
                of_new = given.of_pair(leg.destination, other)
                assert all(map(np.array_equal, of_old, of_new))


def test_the_verb_takes_all_that_went_otherwise(cli: Cli) -> None:
    """Options by name, days with units, costs by leg; what was missed is named."""
    instance, plan = simple()
    instance.save("i.json")
    plan.save("p.json")
    at = f"{plan.legs[2].end_s + 1.0}s"
    outcome = cli(
        f"replan i.json p.json --at {at} --missed north --retry --service-took south=900s "
        "--cost 3=140 --out r.json --out-instance ri.json"
    )
    assert outcome.status == 0, outcome
    assert "missed, and may be tried again: 1 target: north" in outcome.out
    assert cli("check", "ri.json", "r.json").status == 0
    assert adr_opt.load("ri.json").chaser.tank.initial_delta_v_m_s == pytest.approx(160.0)
    given_up = cli("replan", "i.json", "p.json", "--at", at, "--missed", "north", "--json")
    content = json.loads(given_up.out)
    assert content["missed"] == content["given_up"] == ["north"]


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("--missed", "south"), "missed 'south': leg 1, which leads to it, has not begun"),
        (("--missed", "far"), "missed 'far': no leg of the plan leads to it"),
        (("--missed", "station"), "missed 'station': not a target"),
        (("--retry",), "no target is missed"),
        (("--service-took", "south=2"), "leg 1, which leads to it, is replanned"),
        (("--service-took", "south"), "give NAME=DAYS"),
        (("--service-took", "south=soon"), "--service-took 'soon': give days"),
        (("--service-took", "south=-1"), "service-took 'south': -86400 s"),
        (("--service-took", "south=1e306"), "service-took 'south': "),
        (("--service-took", "south=1", "--service-took", "south=2"), "give one"),
        (("--cost", "1=12"), "cost of leg 1: leg 1 is replanned"),
        (("--cost", "9=12"), "the plan has the legs 1 to 4"),
        (("--cost", "1=-3"), "cost of leg 1: -3 m/s"),
        (("--cost", "1=nan"), "cost of leg 1: nan m/s"),
        (("--cost", "one=3"), "give LEG=M_S"),
    ],
)
def test_what_cannot_have_been_is_one_sentence(cli: Cli, arguments, named: str) -> None:
    """Exit status 2 and a sentence, and nothing is written."""
    instance, plan = simple()
    instance.save("i.json")
    plan.save("p.json")
    refused(cli("replan", "i.json", "p.json", "--at", "0", *arguments, "--out", "x.json"), named)
    assert not Path("x.json").exists()


def test_begun_legs_are_referred_to_what_can_be_told_of_them(cli: Cli) -> None:
    """Who calls a leg failed, or a target lost, that has begun is told to name it as missed."""
    instance, plan = simple()
    instance.save("i.json")
    plan.save("p.json")
    at = ("--at", f"{plan.legs[0].leaves_s + 1.0}s")
    refused(cli("replan", "i.json", "p.json", *at, "--failed", "1"), "report it as missed")
    refused(cli("replan", "i.json", "p.json", *at, "--lost", "south"), "report it as missed")
