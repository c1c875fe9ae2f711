"""Towing: what is refused, what it takes, where it leads, and plans against enumeration."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from brute_force import brute_force_campaign, tow_of
from random_rules import (
    carrying,
    drifting_mission,
    mixed_campaign,
    random_campaign,
    random_mission,
    towing,
)

import adr_opt
from adr_opt import analysis
from adr_opt.campaign import Campaign
from adr_opt.cargo import followed, loads_of
from adr_opt.checking.tank import Tank
from adr_opt.dispersion import sample_flights
from adr_opt.episodes import check_playable
from adr_opt.errors import InputError
from adr_opt.export import write_matrix
from adr_opt.flight import fly, fly_refined
from adr_opt.instance import Instance
from adr_opt.kernels import drift, orbits
from adr_opt.kernels.constants import EARTH_RADIUS_M, MU_M3_S2, SLACK_M_S
from adr_opt.kernels.loads import after_service
from adr_opt.mission import Mission
from adr_opt.plan import Plan
from adr_opt.planes import ahead, outward
from adr_opt.plot.segments import segments
from adr_opt.refining import refine
from adr_opt.refining.ephemeris import tracks
from adr_opt.refining.holding import beginning
from adr_opt.refining.plan import RefinedPlan
from adr_opt.tow import leaving_orbits, tows_of
from adr_opt.trajectory import sample, write_plan

CASES = 96

TANK = {"dry_mass_kg": 300.0, "propellant_kg": 600.0, "isp_s": 300.0}


def field(dynamics: str = "two-body", every: int = 2) -> Instance:
    """A tiny field, by turns with objects that are towed and that are not, and a heavy tank."""
    drawn = adr_opt.generate("tiny", 0, targets=6)
    return drawn.replace(
        dynamics=dynamics,
        targets=tuple(
            target.replace(removal="tow" if number % every == 0 else "visit", mass_kg=250.0)
            for number, target in enumerate(drawn.targets)
        ),
        chasers=(drawn.chaser.replace(tank=TANK),),
        mission=drawn.mission.replace(disposal_altitude_m=450e3),
    )


@cache
def planned(dynamics: str = "two-body") -> Plan:
    """A plan of it with several tows."""
    plan = adr_opt.solve(field(dynamics), "exact", time_limit=60.0).plan
    assert plan is not None
    assert len(plan.tows_before) > 0
    return plan


def drawn(seed: int) -> Instance:
    """One chaser or several that tow, by turns with kits, in all dynamics."""
    draw = drifting_mission if seed % 2 else random_mission
    make = (draw, lambda n: random_campaign(n, draw), lambda n: mixed_campaign(n, draw))[seed % 3]
    made = make(seed // 2)
    return towing(carrying(made, seed) if seed % 4 < 2 else made, seed)


every_part = pytest.mark.parametrize(
    "seeds",
    [
        pytest.param(range(part, CASES, 4), id=f"{part}", marks=[pytest.mark.slow] if part else [])
        for part in range(4)
    ],
)


@every_part
@pytest.mark.parametrize("method", ["auto", "exact", "greedy"])
def test_plans_pass_and_bounds_hold(method, seeds):
    """What is planned passes `check`, and enumeration knows nothing above what is proven."""
    towed = planned = proven = 0
    for seed in seeds:
        instance, margin = drawn(seed), (0.0, 0.2, 0.0)[seed % 3]
        campaign = Campaign(instance, margin=margin)
        prizes, cost = brute_force_campaign(campaign)
        asked = {"cost": True} if method == "exact" else {}
        result = adr_opt.solve(campaign, method, time_limit=30.0, iterations=8, **asked)
        assert result.upper_bound >= prizes - 1e-9, seed
        plan = result.plan
        if plan is None:
            assert math.isfinite(prizes) <= (result.status != "infeasible"), seed
            continue
        planned += 1
        towed += sum(leg.tow is not None for leg in plan.legs)
        assert adr_opt.check(instance, plan) == (), seed
        assert result.objective <= prizes + 1e-9, seed
        if result.objective == pytest.approx(prizes):
            assert plan.cost >= cost - 1e-6, seed
        if result.status == "optimal":
            assert result.objective == pytest.approx(prizes), seed
            proven += 1
        if plan.cost_bound is not None:
            assert plan.cost_bound <= cost * (1.0 + 1e-9) + 1e-6, seed
        if plan.cost_status == "optimal":
            assert plan.cost == pytest.approx(cost, rel=2e-6, abs=1e-5), seed
    # Greedy orders visit less than others, so that they have fewer tows as well.
    assert towed > (0.25 if method == "greedy" else 0.3) * len(seeds)
    if method != "greedy":
        assert proven >= 0.8 * planned > 0.4 * len(seeds)


def test_what_a_tow_takes_is_half_an_ellipse():
    """Time, ΔV and mass of a tow are those of a Hohmann transfer, written down once more."""
    for seed in range(30):
        instance = drawn(seed)
        first = instance.first_target
        for body, tow in tows_of(instance).items():
            wanted = tow_of(instance.targets[body - first], instance)
            assert (tow.time_s, tow.delta_v_m_s, tow.object_kg) == pytest.approx(wanted, rel=1e-10)


def test_what_is_left_is_what_masses_say():
    """ΔV left after legs and tows is that of the masses, by the rocket equation, burn by burn."""
    rng = np.random.default_rng(1)
    enough = 0
    for _ in range(500):
        instance = field(every=1)
        tank = {
            "dry_mass_kg": float(rng.uniform(50.0, 2000.0)),
            "propellant_kg": float(rng.uniform(10.0, 3000.0)),
            "isp_s": float(rng.uniform(50.0, 4000.0)),
        }
        chaser = instance.chaser.replace(tank=tank)
        mass_kg = float(rng.uniform(1.0, 9000.0))
        targets = tuple(target.replace(mass_kg=mass_kg) for target in instance.targets)
        instance = instance.replace(chasers=(chaser,), targets=targets)
        loads = loads_of(instance, chaser, 0.0)
        judged, left, spent = Tank(chaser, 0), float(loads.full[0]), []
        for body, tow in tows_of(instance).items():
            assert left - SLACK_M_S == pytest.approx(judged.left_m_s, rel=1e-9, abs=1e-7)
            delta_v = float(rng.uniform(0.0, 0.3)) * judged.left_m_s
            richer, _ = after_service(loads, body, 0, left - delta_v + 1e-3)
            left, _ = after_service(loads, body, 0, left - delta_v)
            judged.burn(delta_v)
            for slower in tow.burns_m_s:
                judged.tow(slower, mass_kg)
            spent.append((instance.names[body], delta_v))
            if left < 0.0:
                assert judged.left_m_s < -SLACK_M_S
                break
            assert richer > left  # who is richer before is so after it
            stage = followed(instance, chaser, spent)[-1]
            assert stage.left_m_s == pytest.approx(judged.left_m_s, rel=1e-9, abs=1e-7)
            assert stage.mass_kg == pytest.approx(judged.mass_kg)
            enough += 1
    assert enough > 300


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
def test_legs_out_of_a_disposal_orbit_can_be_flown(dynamics):
    """The burns of a tow, and of the leg after it, lead to the stand-off behind the target."""
    instance, plan = field(dynamics), planned(dynamics)
    assert adr_opt.check(instance, plan) == ()
    flight = fly(instance, plan)
    assert flight.worst_miss_m < 1e-3
    assert flight.broken_tanks == ()
    (tank,) = flight.tanks
    assert tank.planned_delta_v_m_s == pytest.approx(plan.delta_v_m_s)


def test_a_plan_that_lacks_a_tow_is_not_flown():
    """Neither check nor fly passes a plan that a tow was taken out of, or put into."""
    instance, plan = field(), planned()
    at = _first_tow(plan)
    for removed, said in (("tow", "no tow of it"), ("visit", "but for a tow")):
        other = plan
        if removed == "tow":
            (route,) = plan.routes
            legs = [leg if n != at else leg.replace(tow=None) for n, leg in enumerate(route.legs)]
            other = plan.replace(routes=(route.replace(legs=tuple(legs)),))
        asked = instance.replace(
            targets=tuple(
                each.replace(removal=removed) if each.name == plan.legs[at].destination else each
                for each in instance.targets
            )
        )
        reference = other.instance.replace(name=asked.name, sha256=asked.sha256)
        other = other.replace(instance=reference)
        assert "tow" in {violation.rule for violation in adr_opt.check(asked, other)}
        with pytest.raises(InputError, match=f"leg {at + 1}: .*{said}"):
            fly(asked, other)


def test_drifts_out_of_a_disposal_orbit_can_be_flown():
    """Under J2 chasers drift away from disposal orbits, as `check` says, and meet their targets."""
    flown = 0
    for seed in range(0, 40, 2):
        instance = towing(drifting_mission(seed), seed)
        plan = adr_opt.solve(instance, "greedy").plan
        if plan is None or not plan.tows_before:
            continue
        assert adr_opt.check(instance, plan) == (), seed
        legs = fly(instance, plan).legs
        for number in plan.tows_before:
            assert legs[number - 1].miss_m < 0.1, (seed, number)
            flown += legs[number - 1].kind == "drift"
    assert flown > 4


def test_nodes_drift_as_the_disposal_orbit_does_after_the_departure():
    """What is left of a node counts the object's rate before, and the lower orbit's after it."""
    instance = field("j2", every=1)
    leaving, rows, first = leaving_orbits(instance), instance.orbits(), instance.first_target
    pair = drift.prepare(leaving[first], rows[first + 1], 6.7e6, 8.3e6, instance.oblateness_m2)
    tow, i = tows_of(instance)[first], rows[first]
    lower = orbits.node_rate(tow.radius_m, i[orbits.INCLINATION], instance.oblateness_m2)
    assert abs(lower) > 1.05 * abs(i[orbits.RAAN_RATE])
    for departure, arrival in ((0.0, 1e6), (3e5, 2e6), (1e6, 1e7)):
        node = orbits.node_at(i, departure - tow.time_s) + tow.shift_rad
        node += lower * (arrival - departure)
        lag = math.remainder(orbits.node_at(rows[first + 1], arrival) - node, 2.0 * math.pi)
        left = drift.node_left_from(pair, departure, arrival)
        assert left == pytest.approx(pair.speed * pair.sine * lag, rel=1e-9)


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
def test_a_trajectory_goes_on_through_tows(dynamics):
    """Sampled arcs of a plan with tows follow one another in time and place, tows among them."""
    instance, plan = field(dynamics), planned(dynamics)
    arcs = [arc for _, arc in sample(instance, plan).arcs()]
    for one, other in pairwise(arcs):
        assert one.end_s == pytest.approx(other.start_s, abs=1e-3)
        assert np.linalg.norm(one.positions_m[-1] - other.positions_m[0]) < 1.0
    tows = [arc for arc in arcs if arc.phase == "tow"]
    assert len(tows) == sum(leg.tow is not None for leg in plan.legs)
    for arc in tows:
        radius_m = 6378137.0 + instance.mission.disposal_altitude_m
        assert np.linalg.norm(arc.positions_m[-1]) == pytest.approx(radius_m, abs=0.1)
    shown = segments(instance, plan)
    assert [one.phase for one in shown].count("tow") == len(tows)
    for one, other in pairwise(shown):
        assert one.end_s == pytest.approx(other.start_s, abs=1e-6)


def test_a_window_is_for_the_service_and_not_for_the_tow():
    """A service may end as its window closes, before the tow; the mission has room for both."""
    instance, plan = field(), planned()
    at = _first_tow(plan)
    order = [each.destination for each in plan.legs[: at + 1]]
    leg, tow = plan.legs[at], tows_of(instance)[instance.names.index(order[-1])]

    def made(last_s: float, **changes) -> int:
        targets = tuple(
            target.replace(**changes) if target.name == order[-1] else target
            for target in instance.targets
        )
        limited = instance.with_limits(duration_s=last_s).replace(targets=targets)
        return Campaign(limited).missions[0].time(order).made

    enough = leg.end_s + tow.time_s + 1.0
    assert made(enough) == at + 1
    assert made(enough, window_s=(0.0, leg.end_s + 1.0)) == at + 1
    soonest = Campaign(instance.replace(objective={"cost": "duration"})).missions[0].time(order)
    end = float(soonest.ends[at])
    assert made(end + 1.0) == at + 1
    assert made(end - 1.0) == at
    assert made(enough, window_s=(0.0, end - tow.time_s + 1.0)) == at + 1
    assert made(enough, window_s=(0.0, end - tow.time_s - 1.0)) == at


def _first_tow(plan: Plan) -> int:
    return next(number for number, leg in enumerate(plan.legs) if leg.tow is not None)


@pytest.mark.parametrize(
    "change",
    [
        lambda tow: None,
        lambda tow: tow.replace(delta_v_m_s=tow.delta_v_m_s - 1.0),
        lambda tow: tow.replace(start_s=tow.start_s - 1.0),
        lambda tow: tow.replace(end_s=tow.end_s + 1.0),
        lambda tow: tow.replace(burns=tow.burns[:1]),
        lambda tow: tow.replace(burns=tow.burns[::-1]),
        lambda tow: tow.replace(
            burns=(tow.burns[0].replace(delta_v_m_s=(1.0, 2.0, 3.0)), tow.burns[1])
        ),
        lambda tow: tow.replace(
            burns=(tow.burns[0], tow.burns[1].replace(time_s=tow.burns[1].time_s + 5.0))
        ),
    ],
)
def test_check_judges_tows(change):
    """A tow that is left out, cheaper, at other times, or with other burns is found."""
    instance, plan = field(), planned()
    at = _first_tow(plan)
    legs = list(plan.legs)
    legs[at] = legs[at].replace(tow=change(legs[at].tow))
    broken = plan.replace(routes=(plan.routes[0].replace(legs=tuple(legs)),))
    assert ("tow", at + 1) in {(found.rule, found.leg) for found in adr_opt.check(instance, broken)}


def test_check_counts_what_tows_take():
    """A plan of an instance with a far heavier object breaks the tank, and the mass."""
    instance, plan = field(), planned()
    at = _first_tow(plan)
    heavier = tuple(
        target.replace(mass_kg=2e4) if target.name == plan.legs[at].destination else target
        for target in instance.targets
    )
    other = instance.replace(targets=heavier)
    moved = plan.replace(instance={"name": other.name, "sha256": other.sha256})
    rules = {(found.rule, found.leg) for found in adr_opt.check(other, moved)}
    assert {("delta-v", at + 1), ("mass", at + 1)} <= rules


def test_burns_of_tows_are_against_the_motion():
    """Both burns of a tow point against the motion of where they are made, and sum to its ΔV."""
    instance, plan = field("j2"), planned("j2")
    rows = dict(zip(instance.names, instance.orbits(), strict=True))
    for leg in plan.legs:
        if leg.tow is None:
            continue
        row, burn = rows[leg.destination], leg.tow.burns[0]
        plane = (row[orbits.INCLINATION], orbits.node_at(row, burn.time_s))
        motion = ahead(plane, outward(plane, orbits.latitude_at(row, burn.time_s)))
        assert np.array(burn.delta_v_m_s) / burn.size_m_s == pytest.approx(-motion, abs=1e-9)
        sizes = [burn.size_m_s for burn in leg.tow.burns]
        assert math.fsum(sizes) == pytest.approx(leg.tow.delta_v_m_s)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda i: {"mission": i.mission.replace(disposal_altitude_m=None)}, "disposal_altitude_m"),
        (lambda i: {"mission": i.mission.replace(disposal_altitude_m=100e3)}, "altitude limits"),
        (lambda i: {"mission": i.mission.replace(disposal_altitude_m=900e3)}, "must be below"),
        (
            lambda i: {"targets": (i.targets[0].replace(mass_kg=None), *i.targets[1:])},
            r"targets\[0\].mass_kg: missing",
        ),
        (
            lambda i: {"chasers": (i.chaser.replace(tank={"delta_v_m_s": 900.0}),)},
            "give its dry_mass_kg",
        ),
        (lambda i: {"keep_out_zones": adr_opt.generate("tiny", 0, zones=1).keep_out_zones},
         "keep_out_zones"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused(change, words):
    """Towing without a mass, an altitude below, tanks by mass, or with zones: one sentence."""
    instance = field()
    with pytest.raises(InputError, match=words):
        instance.replace(**change(instance))


def test_given_connections_know_no_tows():
    """Where connections are given nobody knows where a tow leads, and it is refused."""
    instance = field()
    costs = np.ones((1, len(instance.names), len(instance.names)))
    with pytest.raises(InputError, match="connections are given"):
        adr_opt.Timetable.from_matrices(instance, [0.0], costs, costs)


def test_files_without_tows_do_not_speak_of_them():
    """Instances and plans without tows are written as before; those with tows are read again."""
    plain = adr_opt.generate("tiny", 0)
    assert "disposal" not in plain.to_json()
    assert '"tow"' not in adr_opt.solve(plain, "greedy").plan.to_json()
    instance, plan = field(), planned()
    assert Instance.from_json(instance.to_json()) == instance
    assert Plan.from_json(plan.to_json()) == plan


def test_who_knows_no_tows_says_so():
    """Methods and verbs that do not know tows refuse them in a sentence."""
    instance, plan = field(), planned()
    with pytest.raises(InputError, match="replan knows no tows yet"):
        analysis.replan(instance, plan, at_s=1000.0)
    with pytest.raises(InputError, match="knows no tows, and those of"):
        adr_opt.solve(instance, "ortools")
    with pytest.raises(InputError, match="has tows that count"):
        check_playable(Mission(instance))


def test_what_is_exported_has_the_burns_of_tows(tmp_path):
    """Messages and scripts fly tows; a script of a leg that leaves a disposal orbit is refused."""
    instance, plan = field(), planned()
    tows = sum(leg.tow is not None for leg in plan.legs)
    message, script = tmp_path / "a.opm", tmp_path / "a.script"
    write_plan(instance, plan, message)
    write_plan(instance, plan, script)
    burns = sum(len(leg.all_burns) for leg in plan.legs)
    assert message.read_text().count("MAN_EPOCH_IGNITION") == burns
    assert script.read_text().count("Maneuver 'tow'") == 2 * tows
    number = next(iter(plan.tows_before))
    write_plan(instance, plan, tmp_path / "leg.oem", leg=number)
    with pytest.raises(InputError, match="leaves a disposal orbit"):
        write_plan(instance, plan, tmp_path / "leg.script", leg=number)
    with pytest.raises(InputError, match="knows no tows"):
        write_matrix(Mission(instance), tmp_path / "a.vrp", [0.0])


@cache
def refined(dynamics: str, every: int, freedom: str) -> tuple[Instance, Plan, RefinedPlan]:
    """A plan with tows in true dynamics."""
    instance = field(dynamics, every)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    return instance, plan, refine(instance, plan, freedom=freedom)


REFINED = [
    (dynamics, every, freedom)
    for dynamics in ("two-body", "j2")
    for every in (1, 2)
    for freedom in ("free", "planned")
]


@pytest.mark.parametrize("case", REFINED)
def test_refined_legs_begin_where_tows_lead(case):
    """Flown by another integrator all legs arrive that begin where tows end, and so do the tows."""
    instance, plan, one = refined(*case)
    assert len(plan.tows_before) >= 2
    flight = fly_refined(instance, one)
    assert flight.holds
    assert flight.worst_miss_m < 0.1
    assert max(leg.departure_miss_m for leg in flight.legs) < 0.1
    for leg, planned, flown in zip(one.legs, plan.legs, flight.legs, strict=True):
        assert (leg.tow is None) == (planned.tow is None) == (flown.tow_miss_m is None)
        before = plan.tows_before.get(leg.leg)
        assert (leg.tow_before is None) == (before is None)
        if before is not None:
            assert leg.states[0].time_s == pytest.approx(before.end_s, abs=1e-6)
        if leg.tow is not None:
            assert flown.tow_miss_m < 0.1
            assert leg.towing_m_s == pytest.approx(planned.tow.delta_v_m_s)


@pytest.mark.parametrize("case", REFINED)
def test_refined_tows_are_paid_for(case):
    """Tanks and totals hold legs and tows, and with the plan's own burns about what it states."""
    instance, plan, one = refined(*case)
    towing = math.fsum(leg.tow.delta_v_m_s for leg in plan.legs if leg.tow)
    assert one.planned_delta_v_m_s == pytest.approx(plan.delta_v_m_s)
    legs = math.fsum(leg.flown_delta_v_m_s for leg in one.legs)
    assert one.flown_delta_v_m_s == pytest.approx(legs + towing)
    assert one.retargeted_delta_v_m_s == pytest.approx(plan.delta_v_m_s, rel=0.005)
    flight = fly_refined(instance, one)
    assert flight.flown_delta_v_m_s == pytest.approx(one.flown_delta_v_m_s)
    assert math.fsum(tank.flown_delta_v_m_s for tank in flight.tanks) == pytest.approx(
        one.flown_delta_v_m_s
    )
    flown = [(leg.destination, leg.flown_delta_v_m_s) for leg in one.legs]
    left = followed(instance, instance.chaser, flown)[-1].left_m_s
    tank = flight.tanks[-1]
    assert tank.budget_m_s - tank.flown_delta_v_m_s == pytest.approx(left)


@pytest.mark.parametrize("case", REFINED)
def test_objects_are_released_where_they_are_disposed_of(case):
    """They end on circles at the disposal altitude, under J2 up to its short periods."""
    instance, _, one = refined(*case)
    near_m = 1e-3 if instance.dynamics == "two-body" else 15e3
    for tow in (leg.tow for leg in one.legs if leg.tow is not None):
        radius = math.hypot(*tow.released.position_m)
        axis = 1.0 / (2.0 / radius - math.hypot(*tow.released.velocity_m_s) ** 2 / MU_M3_S2)
        for length in (radius, axis):
            disposal = instance.mission.disposal_altitude_m + EARTH_RADIUS_M
            assert abs(length - disposal) < near_m


def test_the_ephemeris_of_tows_has_no_gaps():
    """Arcs of a refined flight with tows join each other in time and place."""
    _, _, one = refined("j2", 2, "free")
    arcs = [track.arc for track in tracks(one)]
    assert sum(arc.phase == "tow" for arc in arcs) == sum(leg.tow is not None for leg in one.legs)
    for first, second in pairwise(arcs):
        assert second.times_s[0] == pytest.approx(first.times_s[-1], abs=1e-3)
        assert np.linalg.norm(second.positions_m[0] - first.positions_m[-1]) < 10.0


def test_a_refined_file_says_its_tows():
    """A refined plan with tows is read as it is written; spoiled tows are refused in a sentence."""
    _, _, one = refined("j2", 2, "free")
    assert RefinedPlan.from_json(one.to_json()) == one
    towed = next(leg for leg in one.legs if leg.tow is not None)
    first, second = towed.tow.burns
    with pytest.raises(ValueError, match="two in time order"):
        towed.tow.replace(burns=(second, first))
    with pytest.raises(ValueError, match="not that of the second burn"):
        towed.tow.replace(released=towed.tow.released.replace(time_s=first.time_s))
    with pytest.raises(ValueError, match="begins before arrival_s"):
        towed.replace(arrival_s=second.time_s, end_s=second.time_s)
    following = next(leg for leg in one.legs if leg.tow_before is not None)
    first, second = following.tow_before.burns
    late = following.tow_before.replace(
        burns=(first, second.replace(time_s=following.arrival_s)),
        released=following.tow_before.released.replace(time_s=following.arrival_s),
    )
    with pytest.raises(ValueError, match="ends after the first burn"):
        following.replace(tow_before=late)


@pytest.mark.parametrize("field_name", ["tow", "tow_before"])
def test_a_refined_plan_without_its_tows_is_refused(field_name):
    """Whoever leaves a tow out of a refined plan, or adds one, is told so before it is flown."""
    instance, _, one = refined("j2", 2, "free")
    at, lost = next((k, leg) for k, leg in enumerate(one.legs) if getattr(leg, field_name))
    without = lost.replace(**{field_name: None})
    spoiled = one.replace(legs=(*one.legs[:at], without, *one.legs[at + 1 :]))
    with pytest.raises(InputError, match="is towed, and the leg has no tow of it"):
        fly_refined(instance, spoiled)
    tow = getattr(lost, field_name)
    other, bare = next((k, leg) for k, leg in enumerate(one.legs) if not getattr(leg, field_name))
    legs = list(one.legs)
    # Its times are those of another leg, which nobody looks at before.
    legs[other] = bare.model_copy(update={field_name: tow})
    spoiled = one.model_copy(update={"legs": tuple(legs)})
    with pytest.raises(InputError, match="is not towed"):
        fly_refined(instance, spoiled)


def test_a_plan_with_tows_is_planned_until_it_holds():
    """Rounds of planning and refining know tows, and what is left of a plan keeps its own."""
    instance = field("j2")
    found = adr_opt.solve_refined(instance, "greedy", rounds=2, time_limit=5.0)
    assert found.holds
    assert fly_refined(instance, found.refined).holds
    mission = Mission(instance)
    _, plan, one = refined("j2", 2, "free")
    broken = one.replace(
        status="incomplete", legs=one.legs[:-1],
        missing=({"leg": len(plan.legs), "reason": "lost"},),
    )  # fmt: skip
    shorter, kept = beginning(mission, plan, broken)
    assert len(shorter.legs) == len(kept.legs) == len(plan.legs) - 1
    assert adr_opt.check(instance, shorter) == ()
    assert fly_refined(instance, kept).holds
    assert kept.legs[-1].tow is not None
    assert kept.legs[-1].tow.burns[0].time_s == shorter.legs[-1].end_s


def test_flights_with_errors_pay_for_tows():
    """What a flight with errors takes holds the tows, and no leg is late for them alone."""
    instance, _, one = refined("j2", 2, "free")
    found = sample_flights(instance, one, flights=20)
    towing = math.fsum(leg.towing_m_s for leg in one.legs)
    assert found.refined_delta_v_m_s == pytest.approx(one.flown_delta_v_m_s)
    assert found.delta_v_m_s.value > towing + 0.9 * (one.flown_delta_v_m_s - towing)
    assert [tank.refined_delta_v_m_s for tank in found.tanks] == pytest.approx(
        [one.flown_delta_v_m_s]
    )
