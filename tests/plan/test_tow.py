"""Towing: what is refused, what it takes, where it leads, and plans against enumeration."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from against_enumeration import held, held_costs, optimal
from plain_world import tow_of
from plans import unjudged
from random_rules import drifting_mission, towing
from seeds import over_kinds
from towed_fields import drawn, field

import adr_opt
from adr_opt.common.constants import SLACK_M_S
from adr_opt.common.errors import InputError
from adr_opt.export.flights import write_plan
from adr_opt.export.tables import write_matrix
from adr_opt.fly.flight import fly
from adr_opt.fly.trajectory import sample
from adr_opt.judge.check.tank import TankLevel
from adr_opt.kernels.legs import drift_linear
from adr_opt.kernels.orbits import columns, ephemeris
from adr_opt.kernels.rules.loads import after_service
from adr_opt.learning.episodes import check_playable
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.plan.after_tows import leaving_orbits
from adr_opt.plan.cargo import followed, loads_of
from adr_opt.plan.plan import Plan
from adr_opt.plan.planes import Plane, ahead, outward
from adr_opt.plan.tows import removals_of
from adr_opt.ui.plot.gantt import segments


@cache
def planned(dynamics: str = "two-body") -> Plan:
    """A plan of it with several tows."""
    plan = adr_opt.solve(field(dynamics), "exact", time_limit=60.0).plan
    assert plan is not None
    assert len(plan.lead_ins) > 0
    return plan


some_seeds = over_kinds("seeds", drawn=(range(96), 2))


@some_seeds
@pytest.mark.parametrize("method", ["auto", "least cost", "greedy"])
def test_plans_pass_and_bounds_hold(method, seeds):
    """What is planned passes `check`, and enumeration knows nothing above what is proven."""
    margins = (0.0, 0.0 if method == "least cost" else 0.2, 0.0)  # no cost is proven with one
    campaigns = (Problem(drawn(seed), margin=margins[seed % 3]) for seed in seeds)
    results = held_costs(campaigns) if method == "least cost" else held(campaigns, method)
    towed = sum(leg.tow is not None for _, result in results for leg in result.plan.legs)
    # Greedy orders visit less than others, so that they have fewer tows as well.
    assert towed > (0.25 if method == "greedy" else 0.3) * len(seeds)
    if method != "greedy":
        assert optimal(results) >= 0.8 * len(results) > 0.4 * len(seeds)


def test_what_a_tow_takes_is_half_an_ellipse():
    """Time, ΔV and mass of a tow are those of a Hohmann transfer, written down once more."""
    for seed in range(30):
        instance = drawn(seed)
        first = instance.first_target
        for body, tow in removals_of(instance, None).items():
            wanted = tow_of(instance.targets[body - first], instance)
            made = tow.time_s, tow.delta_v_m_s, tow.object_kg, tow.back_m_s
            assert made == pytest.approx(wanted, rel=1e-9)


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
        judged, left, spent = TankLevel(chaser, 0), float(loads.full[0]), []
        for body, tow in removals_of(instance, None).items():
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
    for removed, said in (("tow", "no tow of it"), ("visit", "has a tow of it")):
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
            fly(asked, unjudged(asked, other))


@pytest.mark.slow
def test_drifts_out_of_a_disposal_orbit_can_be_flown():
    """Under J2 chasers drift away from disposal orbits, as `check` says, and meet their targets."""
    flown = 0
    for seed in range(0, 40, 2):
        instance = towing(drifting_mission(seed), seed)
        plan = adr_opt.solve(instance, "greedy").plan
        if plan is None or not plan.lead_ins:
            continue
        assert adr_opt.check(instance, plan) == (), seed
        legs = fly(instance, plan).legs
        for number in plan.lead_ins:
            assert legs[number - 1].miss_m < 0.1, (seed, number)
            flown += legs[number - 1].kind == "drift"
    assert flown > 4


def test_nodes_drift_as_the_disposal_orbit_does_after_the_departure():
    """What is left of a node counts the object's rate before, and the lower orbit's after it."""
    instance = field("j2", every=1)
    leaving, rows, first = leaving_orbits(instance, None), instance.orbits(), instance.first_target
    ends = leaving[first], rows[first + 1]
    pair = drift_linear.prepare(*ends, 6.7e6, 8.3e6, instance.oblateness_m2, 0.0)
    tow, i = removals_of(instance, None)[first], rows[first]
    lower = ephemeris.node_rate(tow.radius_m, i[columns.INCLINATION], instance.oblateness_m2)
    assert abs(lower) > 1.05 * abs(i[columns.RAAN_RATE])
    for departure, arrival in ((0.0, 1e6), (3e5, 2e6), (1e6, 1e7)):
        node = ephemeris.node_at(i, departure - tow.time_s) + tow.shift_rad
        node += lower * (arrival - departure)
        lag = math.remainder(ephemeris.node_at(rows[first + 1], arrival) - node, 2.0 * math.pi)
        left = drift_linear.node_left_from(pair, departure, arrival)
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
        radius_m = 6378137.0 + instance.mission.disposal.circle_m
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
    leg, tow = plan.legs[at], removals_of(instance, None)[instance.names.index(order[-1])]

    def made(last_s: float, **changes) -> int:
        targets = tuple(
            target.replace(**changes) if target.name == order[-1] else target
            for target in instance.targets
        )
        limited = instance.with_limits(duration_s=last_s).replace(targets=targets)
        return Problem(limited).missions[0].time(order).made

    enough = leg.end_s + tow.time_s + 1.0
    assert made(enough) == at + 1
    assert made(enough, window_s=(0.0, leg.end_s + 1.0)) == at + 1
    soonest = Problem(instance.replace(objective={"cost": "duration"})).missions[0].time(order)
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
        plane = Plane(row[columns.INCLINATION], ephemeris.node_at(row, burn.time_s))
        motion = ahead(plane, outward(plane, ephemeris.latitude_at(row, burn.time_s)))
        assert np.array(burn.delta_v_m_s) / burn.size_m_s == pytest.approx(-motion, abs=1e-9)
        sizes = [burn.size_m_s for burn in leg.tow.burns]
        assert math.fsum(sizes) == pytest.approx(leg.tow.delta_v_m_s)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda i: {"mission": i.mission.replace(disposal=None)}, "mission.disposal"),
        (lambda i: {"mission": i.mission.replace(disposal={"circle_m": 100e3})}, "altitude limits"),
        (
            lambda i: {"targets": (i.targets[0].replace(mass_kg=None), *i.targets[1:])},
            r"targets\[0\].mass_kg: missing",
        ),
        (
            lambda i: {"chasers": (i.chaser.replace(tank={"delta_v_m_s": 900.0}),)},
            "give its dry_mass_kg",
        ),
        (
            lambda i: {"keep_out_zones": adr_opt.generate("tiny", 0, zones=1).keep_out_zones},
            "keep_out_zones",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(change, words):
    """Towing without a mass, an altitude below, tanks by mass, or with zones: one sentence."""
    instance = field()
    with pytest.raises(InputError, match=words):
        instance.replace(**change(instance))


def test_given_connections_know_no_tows():
    """A tow is refused with given connections, which do not say where it leads."""
    instance = field()
    costs = np.ones((1, len(instance.names), len(instance.names)))
    with pytest.raises(InputError, match="given connections hold no costs"):
        adr_opt.Timetable.from_matrices(instance, [0.0], costs, costs)


def test_who_knows_no_tows_says_so():
    """Methods and verbs that do not know tows refuse them in a sentence."""
    instance = field()
    with pytest.raises(InputError, match="does not follow tows"):
        adr_opt.solve(instance, "ortools")
    with pytest.raises(InputError, match=r"the environment .* does not follow tows.*auto, exact"):
        check_playable(Mission(instance))


def test_what_is_exported_has_the_burns_of_tows(tmp_path):
    """Messages and scripts fly tows; a script of a leg that leaves a disposal orbit is refused."""
    instance, plan = field(), planned()
    tows = sum(leg.tow is not None for leg in plan.legs)
    message, script = tmp_path / "a.opm", tmp_path / "a.script"
    write_plan(instance, plan, message)
    write_plan(instance, plan, script)
    burns = sum(len(leg.all_impulses) for leg in plan.legs)
    assert message.read_text().count("MAN_EPOCH_IGNITION") == burns
    assert script.read_text().count("Maneuver 'tow'") == 2 * tows
    number = next(iter(plan.lead_ins))
    write_plan(instance, plan, tmp_path / "leg.oem", leg=number)
    with pytest.raises(InputError, match="leaves a disposal orbit"):
        write_plan(instance, plan, tmp_path / "leg.script", leg=number)
    with pytest.raises(InputError, match="does not follow tows"):
        write_matrix(Mission(instance), tmp_path / "a.vrp", [0.0])


def test_targets_may_have_disposal_orbits_of_their_own():
    """Their tows lead to those circles; a plan of others is no plan of theirs."""
    instance = field()
    own = instance.replace(
        targets=tuple(each.replace(disposal={"circle_m": 400e3}) for each in instance.targets[:3])
        + instance.targets[3:]
    )
    radii = {body: tow.radius_m - 6378137.0 for body, tow in removals_of(own, None).items()}
    first = own.first_target
    assert radii == pytest.approx({first: 400e3, first + 2: 400e3, first + 4: 450e3})
    plan = adr_opt.solve(own, "exact", time_limit=60.0).plan
    assert plan is not None
    assert any(leg.tow is not None for leg in plan.legs)
    assert adr_opt.check(own, plan) == ()
    found = adr_opt.check(instance, plan.replace(instance=planned().instance))
    assert "tow" in {each.rule for each in found}
