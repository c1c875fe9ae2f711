"""``replan``: the rest of a mission, planned anew from where its chasers are."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli, refused
from hand_made import PERIOD_S, hand_made
from on_from import violations
from plans import unjudged
from two_chasers import campaign, planned

import adr_opt
from adr_opt.analysis import price, replan
from adr_opt.analysis.replan.chaser_states import states_at
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.plan.plan import InstanceReference, Plan
from adr_opt.plan.routes import routes_of
from adr_opt.problem.chasers import Expense, InOrbit, TankByMass
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import KeepOutZone

ZONE = KeepOutZone(
    min_altitude_m=700e3, max_altitude_m=760e3, start_s=0.9 * DAY_S, end_s=1.3 * DAY_S
)


@cache
def tiny(
    seed: int = 0, *, by_mass: bool = False, kept_m_s: float | None = None
) -> tuple[Instance, Plan]:
    """A tiny field of two days with a small tank, so that it has to refuel, and its plan."""
    instance = adr_opt.generate("tiny", seed, targets=8).with_limits(2.0 * DAY_S, 500.0)
    if by_mass:
        tank = TankByMass(dry_mass_kg=400.0, propellant_kg=72.0, isp_s=310.0)
        instance = instance.replace(chasers=(instance.chaser.replace(tank=tank),))
    chaser = instance.chaser.replace(end_of_life_m_s=kept_m_s)
    instance = instance.replace(chasers=(chaser,))
    plan = adr_opt.solve(instance, "exact", time_limit=30.0).plan
    assert plan is not None
    return instance, plan


@pytest.mark.parametrize(
    ("by_mass", "kept_m_s"), [(False, None), (True, None), (False, 120.0), (True, 120.0)]
)
@pytest.mark.parametrize("seed", range(3))
def test_what_is_flown_and_the_rest_are_one_mission(
    seed: int, by_mass: bool, kept_m_s: float | None
) -> None:
    """At any time, with a zone or without, both together pass `check` on the whole instance."""
    instance, plan = tiny(seed, by_mass=by_mass, kept_m_s=kept_m_s)
    for at_s in np.linspace(0.0, instance.mission.duration_s, 7):
        for zones in ((), (ZONE,)):
            if any(zone.start_s < at_s for zone in zones):
                continue
            made = replan(instance, plan, float(at_s), zones=zones)
            assert adr_opt.check(made.instance, made.plan) == ()
            assert violations(instance, made, zones) == (), (at_s, zones)
            done = {leg.destination for state in made.states for leg in state.legs}
            assert not done & {target.name for target in made.instance.targets}


def test_nothing_new_is_nothing_worse() -> None:
    """Without a change the rest collects what the plan was about to, and no prize is lost."""
    for seed in range(4):
        instance, plan = tiny(seed)
        for share in (0.2, 0.5, 0.8):
            made = replan(instance, plan, share * instance.mission.duration_s)
            assert made.prize_after == made.prize_before
            assert made.lost == ()


def test_a_zone_is_planned_around_as_if_known() -> None:
    """With a zone that falls in later, the whole collects as much as knowing it from the start.

    Where what is flown by then is a beginning of an optimal plan with the zone; elsewhere no more.
    """
    as_much = 0
    for seed in range(4):
        instance, plan = tiny(seed)
        zoned = instance.replace(keep_out_zones=(ZONE,))
        known = adr_opt.solve(zoned, "exact", time_limit=30.0)
        made = replan(instance, plan, 0.4 * DAY_S, zones=(ZONE,), method="exact", time_limit=30.0)
        flown = sum(len(state.legs) for state in made.states)
        targets = {target.name for target in instance.targets}
        before = sum(leg.destination in targets for state in made.states for leg in state.legs)
        assert flown > 0
        assert before + made.prize_after <= known.objective + 1e-9
        as_much += before + made.prize_after >= known.objective - 1e-9
    assert as_much >= 3


def test_a_leg_that_has_begun_is_finished() -> None:
    """Within a leg the chaser is free at its end; while it waits it is where it was, from now."""
    instance, plan = tiny()
    legs = plan.legs
    (state,) = states_at(instance, plan, 0.5 * (legs[1].leaves_s + legs[1].end_s))
    assert state.legs == legs[:2]
    assert state.body == legs[1].destination
    assert state.free_s == legs[1].end_s
    assert state.left_m_s == pytest.approx(legs[1].delta_v_left_m_s)
    waiting = next(leg for leg in legs[1:] if leg.leaves_s > leg.ready_s + 60.0)
    at_s = waiting.leaves_s - 1.0
    (state,) = states_at(instance, plan, at_s)
    assert state.body == waiting.origin
    assert state.free_s == at_s
    (start,) = states_at(instance, plan, 0.0)
    assert start.legs == ()
    assert start.body == instance.chaser.start_name


def test_legs_are_kept_if_wanted() -> None:
    """As many legs as asked for stay as they were, besides those that have begun."""
    instance, plan = tiny()
    at_s = plan.legs[1].leaves_s + 1.0
    made = replan(instance, plan, at_s, keep=2)
    (state,) = made.states
    assert state.legs[:4] == plan.legs[:4]
    assert made.plan is not None
    assert violations(instance, made) == ()


def test_lost_targets_are_left_out() -> None:
    """They are no targets of the rest, and what the plan did after them is planned all the same."""
    instance, plan = tiny()
    lost = next(name for name in plan.destinations[2:] if name not in instance.station_names)
    made = replan(instance, plan, 1.0, lost=[lost])
    assert made.lost == (lost,)
    assert lost not in made.instance.names
    assert lost not in made.dropped
    assert lost not in made.plan.destinations
    assert violations(instance, made) == ()


def test_a_failed_leg_is_planned_anew() -> None:
    """It and what follows are not fixed, even if kept; one that has begun cannot fail."""
    instance, plan = tiny()
    at_s = plan.legs[0].leaves_s + 1.0
    made = replan(instance, plan, at_s, keep=3, failed=3)
    assert made.states[0].legs[:2] == plan.legs[:2]
    assert plan.legs[2] not in made.states[0].legs
    with pytest.raises(InputError, match="it has begun"):
        replan(instance, plan, at_s, failed=1)


def test_a_kept_leg_through_a_new_zone_is_refused() -> None:
    """One that is under way is noted; one that has not begun cannot be kept."""
    instance, plan = tiny()
    leg = plan.legs[1]
    all_over = KeepOutZone(
        min_altitude_m=0.0, max_altitude_m=2000e3, start_s=leg.leaves_s + 10.0, end_s=leg.docked_s
    )
    with pytest.raises(InputError, match="keep fewer legs"):
        replan(instance, plan, leg.leaves_s - 1.0, zones=[all_over], keep=1)
    made = replan(instance, plan, leg.leaves_s + 5.0, zones=[all_over])
    assert "the leg under way" in made.notes[0]


def test_who_may_refuel_at_once_does() -> None:
    """A chaser with an empty tank that has serviced a target goes to the station first.

    Of the hand-made instance the optimum is south, station, north, beyond: so it is planned from
    south on, and the stop is a leg of the whole.
    """
    instance = hand_made()
    plan = price(instance, {"chaser": ("south", "station", "north", "beyond")}).plan()
    made = replan(instance, plan, plan.legs[0].end_s)
    assert made.prize_after == 2.0
    (route,) = made.whole()
    assert [leg.destination for leg in route.legs] == ["south", "station", "north", "beyond"]
    assert violations(instance, made) == ()
    short = plan.replace(routes=(plan.routes[0].replace(legs=plan.legs[:1]),))
    made = replan(instance, unjudged(instance, short), plan.legs[0].end_s)
    assert made.prize_after == 2.0
    assert made.gained == ("north", "beyond")


def test_campaigns_are_planned_on() -> None:
    """Of several chasers each goes on from where it is, and the whole passes `check`."""
    instance, plan = campaign(), planned()
    for share in (0.0, 0.3, 0.6):
        at_s = share * instance.mission.duration_s
        made = replan(instance, plan, at_s, time_limit=60.0)
        assert adr_opt.check(made.instance, made.plan) == ()
        assert violations(instance, made) == ()
        assert made.prize_after >= made.prize_before


def with_kits(seed: int, kit_kg: float = 6.0) -> Instance:
    """The tiny field of :func:`tiny` with a tank by mass and a kit for every target."""
    field, _ = tiny(seed, by_mass=True)
    targets = tuple(target.replace(removal="kit") for target in field.targets)
    chaser = field.chaser.replace(kit_mass_kg=kit_kg)
    return field.replace(targets=targets, chasers=(chaser,))


@pytest.mark.parametrize("seed", range(3))
def test_kits_that_are_aboard_weigh_until_they_are_left(seed: int) -> None:
    """The rest has the kits that are aboard and no more; those that it cannot use are carried."""
    instance = with_kits(seed)
    plan = adr_opt.solve(instance, "auto", time_limit=60.0).plan
    at_s = 0.4 * instance.mission.duration_s
    (state,) = states_at(instance, plan, at_s)
    left = [leg.destination for leg in plan.legs[len(state.legs) :]]
    targets = [name for name in left if name not in instance.station_names]
    assert state.kits == len(targets) >= 2
    made = replan(instance, plan, at_s)
    assert adr_opt.check(made.instance, made.plan) == ()
    assert violations(instance, made) == ()
    assert made.prize_after >= made.prize_before
    others = [target.name for target in made.instance.targets if target.name not in targets[:1]]
    fewer = replan(instance, plan, at_s, lost=others)
    assert adr_opt.check(fewer.instance, fewer.plan) == ()
    idle = len(targets) - int(fewer.prize_after)
    assert idle >= 1
    assert fewer.states[0].idle_kits == idle
    heavier = fewer.instance.chaser.tank.dry_mass_kg - instance.chaser.tank.dry_mass_kg
    assert heavier == pytest.approx(idle * instance.chaser.kit_mass_kg)


@pytest.mark.slow
def test_with_kits_nothing_new_is_nothing_worse() -> None:
    """Whatever kits a better plan would not need, the former rest stays one that may be flown."""
    idle = 0
    for seed in (9, 17, 32, 64, 76):
        rng = np.random.default_rng(seed)
        field = adr_opt.generate("tiny", seed % 10, targets=8).with_limits(2.0 * DAY_S, 500.0)
        stations = field.stations if rng.random() < 0.5 else ()
        kit_kg, propellant_kg = float(rng.choice([6.0, 20.0, 40.0])), rng.choice([72.0, 110.0, 150])
        chaser = field.chaser.replace(
            kit_mass_kg=kit_kg,
            start=field.chaser.start if stations else "anywhere",
            tank=TankByMass(dry_mass_kg=400.0, propellant_kg=float(propellant_kg), isp_s=310.0),
        )
        targets = tuple(
            target.replace(
                removal="kit" if rng.random() < 0.7 else "visit", prize=float(rng.integers(1, 6))
            )
            for target in field.targets
        )
        instance = field.replace(chasers=(chaser,), targets=targets, stations=stations)
        plan = adr_opt.solve(instance, "greedy" if rng.random() < 0.7 else "auto", time_limit=60.0)
        made = replan(instance, plan.plan, plan.plan.legs[0].end_s + 1.0, time_limit=60.0)
        assert made.prize_after >= made.prize_before, seed
        assert adr_opt.check(made.instance, made.plan) == (), seed
        carried = made.states[0].idle_kits
        # Kits that are carried along to the end no plan of the whole mission knows.
        assert carried > 0 or violations(instance, made) == (), seed
        idle += carried > 0
    assert idle > 0


def test_what_stations_gave_is_not_given_again() -> None:
    """Of a station with limits the rest has what is left, in refuellings and in kilograms."""
    instance, plan = tiny(1, by_mass=True)
    stops = [leg for leg in plan.legs if leg.destination in instance.station_names]
    assert stops
    station = instance.stations[0].replace(max_refuellings=len(stops), max_propellant_kg=500.0)
    limited = instance.replace(stations=(station, *instance.stations[1:]))
    reference = InstanceReference(name=limited.name, sha256=limited.sha256)
    made = replan(limited, plan.replace(instance=reference), stops[0].end_s + 1.0)
    (rest,) = made.instance.stations
    assert rest.max_refuellings == len(stops) - 1
    assert 500.0 - 72.0 <= rest.max_propellant_kg < 500.0
    assert adr_opt.check(made.instance, made.plan) == ()
    assert violations(limited, made) == ()


PRICES = {"fixed": 55.0, "per_kg_squared": 2e-6}


@cache
def paid_for() -> tuple[Instance, Plan]:
    """Two launches whose mass costs, and their plan."""
    field = adr_opt.generate("removal", 1, targets=6, chasers=2)
    chasers = tuple(chaser.replace(expense=PRICES) for chaser in field.chasers)
    instance = field.replace(chasers=chasers, objective={"cost": "expense"})
    plan = adr_opt.solve(instance, "auto", time_limit=60.0).plan
    assert plan is not None
    return instance, plan


def test_what_was_launched_is_paid_for_and_all_there_is() -> None:
    """Where launched mass costs, who flies already has what its route needs, and costs no more."""
    instance, plan = paid_for()
    first = min(leg.end_s for leg in plan.legs)
    flying = states_at(instance, plan, first + 1.0)
    made = replan(instance, plan, first + 1.0, time_limit=60.0)
    assert adr_opt.check(made.instance, made.plan) == ()
    assert made.prize_after >= made.prize_before
    for state, chaser in zip(flying, made.instance.chasers, strict=True):
        assert chaser.expense == (Expense(**PRICES) if state.is_new else Expense())
        if not state.is_new:
            end = next(each for each in routes_of(instance, plan) if each.chaser == state.chaser)
            full = end.carried(instance)
            assert chaser.tank.initial_propellant_kg < state.chaser.tank.propellant_kg
            # What its route needs: nothing is left of it at the end.
            assert state.propellant_kg <= full.used_kg + 1e-6


def test_a_chaser_that_flies_costs_nothing_more() -> None:
    """Where all chasers fly already, what they were launched for is paid, and there is a rest."""
    instance, plan = paid_for()
    at_s = max(route.legs[0].end_s for route in plan.routes) + 1.0
    made = replan(instance, plan, at_s, time_limit=60.0)
    assert adr_opt.check(made.instance, made.plan) == ()
    assert made.plan.cost == 0.0
    assert made.prize_after >= made.prize_before


def test_expenses_that_nobody_counts_leave_tanks_full() -> None:
    """By ΔV a chaser was launched with a full tank, whatever a kilogram would have cost."""
    instance, plan = tiny(0, by_mass=True)
    orbit = instance.stations[0].orbit
    free = instance.chaser.replace(name="own", start=InOrbit(orbit=orbit))
    plain = instance.replace(chasers=(free,), stations=())
    priced = plain.replace(chasers=(free.replace(expense={"per_kg": 0.01}),))
    plan = adr_opt.solve(plain, "exact", time_limit=60.0).plan
    reference = InstanceReference(name=priced.name, sha256=priced.sha256)
    at_s = plan.legs[1].end_s
    (one,) = states_at(plain, plan, at_s)
    (other,) = states_at(priced, plan.replace(instance=reference), at_s)
    assert one.propellant_kg == other.propellant_kg > 0.0


def test_drifting_missions_are_planned_on() -> None:
    """Under J2, with months between legs, the whole passes `check` too."""
    field = adr_opt.generate("rocket-bodies", 0, targets=5).with_limits(duration_s=180.0 * DAY_S)
    plan = adr_opt.solve(field, "exact", time_limit=30.0).plan
    assert len(plan.legs) >= 2
    at_s = plan.legs[0].end_s + DAY_S
    made = replan(field, plan, at_s)
    assert violations(field, made) == ()
    assert made.prize_after >= made.prize_before


def test_the_verb_writes_the_rest(cli: Cli) -> None:
    """Instance and plan of the rest fit each other; what changed is told, and as JSON."""
    instance, plan = tiny()
    instance.save("i.json")
    plan.save("p.json")
    Path("z.json").write_text(json.dumps([json.loads(ZONE.model_dump_json())]))
    outcome = cli(
        "replan i.json p.json --at 9.6h --zones z.json --lost",
        plan.destinations[-1],
        "--out",
        "r.json",
        "--out-instance",
        "ri.json",
    )
    assert outcome.status == 0, outcome
    assert "flown or fixed" in outcome.out
    assert f"lost: 1 target: {plan.destinations[-1]}" in outcome.out
    assert cli("check", "ri.json", "r.json").status == 0
    rest = adr_opt.load("ri.json")
    assert rest.keep_out_zones == (ZONE,)
    content = json.loads(
        cli("replan", "i.json", "p.json", "--at", "2026-01-01T12:00:00Z", "--json").out
    )
    assert content["prize_after"] >= content["prize_before"]
    again = replan(instance, plan, 0.5 * DAY_S)
    assert content["fixed"][0]["legs"] == len(again.states[0].legs)


def test_a_required_target_that_cannot_be_reached_is_the_answer_no(cli: Cli) -> None:
    """Exit status 1 where the rest has no plan; nothing is written for it."""
    instance = hand_made()
    plan = price(instance, {"chaser": ("north", "beyond")}).plan()
    required = instance.replace(
        targets=tuple(t.replace(required=t.name == "beyond") for t in instance.targets)
    )
    plan = price(required, {"chaser": ("north", "beyond")}).plan()
    required.save("i.json")
    plan.save("p.json")
    closed = KeepOutZone(min_altitude_m=0.0, max_altitude_m=2000e3, start_s=0.0, end_s=1e9)
    Path("z.json").write_text(json.dumps([json.loads(closed.model_dump_json())]))
    at_h = plan.legs[0].end_s / 3600.0
    outcome = cli(
        "replan", "i.json", "p.json", "--at", f"{at_h}h", "--zones", "z.json", "--out", "r.json"
    )
    assert outcome.status == 1, outcome
    assert "no plan of the rest" in outcome.out
    assert not Path("r.json").exists()


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("--at", "soon"), "give days after the epoch"),
        (("--at", "-1"), "outside the mission"),
        (("--at", "1e3"), "outside the mission"),
        (("--at", "0.1", "--zones", "none.json"), "none.json: no such file"),
        (("--at", "0.1", "--zones", "bad.json"), "bad.json: zone 1: "),
        (("--at", "0.1", "--zones", "i.json", "--lost", "nobody"), "'nobody' is not a body"),
        (("--at", "0.1", "--lost", "station"), "not a target"),
        (("--at", "14", "--lost", "south"), "it is serviced by then"),
        (("--at", "0.1", "--keep", "-1"), "keep = -1"),
        (("--at", "0.1", "--failed", "9"), "the plan has the legs 1 to 4"),
        (("--at", "0.1", "--method", "no"), "'no'"),
        (("--at", "0.1", "--out", "x.json", "--out-instance", "x.json"), "name another file"),
        (("--at", "0.1", "--out", "i.json"), "this is the input"),
    ],
)
def test_a_wrong_call_is_one_sentence(cli: Cli, arguments, named: str) -> None:
    """Exit status 2 and a sentence, and nothing is written."""
    instance = hand_made()
    instance.save("i.json")
    price(instance, {"chaser": ("south", "station", "north", "beyond")}).plan().save("p.json")
    Path("bad.json").write_text('[{"min_altitude_m": 2}]')
    if arguments[1] == "14":
        arguments = ("--at", f"{13.9 * PERIOD_S / DAY_S}", *arguments[2:])
    refused(cli("replan", "i.json", "p.json", *arguments), named)
    assert not Path("x.json").exists()


def test_zones_price_legs_by_their_sequence_again() -> None:
    """Free burns may lead into a new zone: the rest has the price of the sequence, and says so."""
    instance, _ = tiny()
    free = instance.replace(transfer=instance.transfer.replace(burns="free"))
    plan = adr_opt.solve(free, "greedy-guarded").plan
    assert plan is not None
    for zones, burns in (((), "free"), ((ZONE,), "sequence")):
        made = replan(free, plan, 0.4 * DAY_S, zones=zones)
        assert made.instance.transfer.burns == burns
        assert any("paths of free burns" in note for note in made.notes) == bool(zones)
