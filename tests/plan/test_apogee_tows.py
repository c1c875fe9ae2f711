"""Tows from apogee: their burns flown, where chasers go on from, and plans with them."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from random_rules import disposing
from seeds import over_seeds
from towed_fields import field

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.common.errors import InputError
from adr_opt.fly.flight import fly, fly_refined
from adr_opt.fly.refine import refine
from adr_opt.fly.refine.bodies import state_of
from adr_opt.fly.refine.tow import lowest_m
from adr_opt.fly.trajectory import sample
from adr_opt.fly.trajectory.bodies import body_states
from adr_opt.fly.trajectory.kepler import propagate
from adr_opt.judge.check.connections import sample_connections
from adr_opt.judge.check.towed import towed_bodies
from adr_opt.judge.refined.flight import released
from adr_opt.judge.refined.verdict import check_refined
from adr_opt.kernels.orbits import ephemeris
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.plan.after_tows import pieced_of
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import RefinedPlan, reference
from adr_opt.plan.tows import APOGEE_M_S, burn_vectors, removals_of
from adr_opt.problem.instance import Instance


def eccentric(seed: int, dynamics: str = "two-body", most: float = 0.05) -> Instance:
    """A tiny field of eccentric objects, all of which are towed."""
    rng, drawn = np.random.default_rng(seed), field(dynamics, 1)
    targets = []
    for target in drawn.targets:
        orbit = target.orbit
        e = float(rng.uniform(1e-3, most))
        raised = max(orbit.semi_major_axis_m, (EARTH_RADIUS_M + 350e3) / (1.0 - e))
        turned = orbit.replace(
            semi_major_axis_m=raised,
            eccentricity=e,
            argument_of_perigee_deg=float(rng.uniform(0.0, 360.0)),
            true_anomaly_deg=float(rng.uniform(0.0, 360.0)),
        )
        targets.append(target.replace(orbit=turned))
    return drawn.replace(targets=tuple(targets))


def apsides(position: np.ndarray, velocity: np.ndarray) -> tuple[float, float]:
    """Radii of perigee and apogee of a state [m]."""
    radius, square = math.hypot(*position), float(velocity @ velocity)
    axis = 1.0 / (2.0 / radius - square / MU_M3_S2)
    momentum = np.cross(position, velocity)
    e = math.sqrt(max(1.0 - float(momentum @ momentum) / (MU_M3_S2 * axis), 0.0))
    return axis * (1.0 - e), axis * (1.0 + e)


@over_seeds(range(40), gate=3)
def test_burns_from_apogee_lead_onto_the_circle(*, seed: int) -> None:
    """Flown by Kepler's equation from the true orbit, both burns leave the object on its circle."""
    instance = eccentric(seed, most=0.3)
    rows = instance.orbits()
    for body, tow in removals_of(instance, None).items():
        begins_s = tow.begins_s(float(instance.mission.duration_s))
        vectors = burn_vectors(rows[body], tow, begins_s)
        name = instance.names[body]
        (position,), (velocity,) = body_states(instance, name, begins_s, true_orbits=True)
        assert math.hypot(*position) == pytest.approx(apsides(position, velocity)[1], rel=1e-12)
        velocity = velocity + vectors[0]
        (position,), (velocity,) = propagate(position, velocity, tow.flight_s)
        assert apsides(position, velocity + vectors[1]) == pytest.approx(tow.released_m, abs=1.0)
        sizes = math.fsum(np.linalg.norm(vector) for vector in vectors)
        assert tow.delta_v_m_s == pytest.approx(sizes, rel=1e-12)


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
def test_chasers_leave_once_the_tow_has_ended(dynamics: str) -> None:
    """A chaser leaves from where the burns led, a revolution ago at most, as the judge says."""
    instance = eccentric(1, dynamics)
    tows = removals_of(instance, None)
    towed = towed_bodies(instance, instance.orbits(), None)
    for body, pieced in pieced_of(instance, tows).items():
        tow = tows[body]
        assert tow.apogees is not None
        for leaves_s in np.random.default_rng(2).uniform(0.0, 3e5, 20):
            begins_s = tow.begins_s(leaves_s)
            assert 0.0 <= leaves_s - begins_s - tow.flight_s <= tow.apogees.period_s
            row = pieced.row_at(leaves_s)
            judged = towed[instance.names[body]]
            assert judged.begins_s(leaves_s) == pytest.approx(begins_s, abs=1e-5)
            assert judged.left_at(leaves_s) == pytest.approx(row, rel=1e-9, abs=1e-9)
            ended_s = begins_s + tow.flight_s
            position = ephemeris.state_at(row, ended_s)[0]
            before = ephemeris.perigee_at(pieced.row, begins_s)
            node = ephemeris.node_at(pieced.row, begins_s) + tow.shift_rad
            tilt = ephemeris.inclination_at(pieced.row, begins_s)
            ascending, ahead, _ = ephemeris.frame(tilt, node)
            there = math.cos(before) * ascending + math.sin(before) * ahead
            assert position / tow.radius_m == pytest.approx(there, abs=1e-9)


DISPOSALS = {
    "circle": {"circle_m": 450e3},
    "raised": {"circle_m": 900e3},
    "perigee": {"perigee_m": 340e3},
    "re-entry": {"perigee_m": 50e3},
}


@cache
def planned(dynamics: str, disposal: str = "circle") -> tuple[Instance, Plan]:
    """A plan of a field of eccentric objects, with tows."""
    instance = eccentric(0, dynamics, 0.01).with_limits(duration_s=4 * 86400.0)
    instance = instance.replace(targets=instance.targets[:3])
    instance = instance.replace(mission=instance.mission.replace(disposal=DISPOSALS[disposal]))
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    return instance, plan


@cache
def flown(disposal: str) -> RefinedPlan:
    """That under J2 refined."""
    return refine(*planned("j2", disposal), jobs=1)


@over_seeds(range(40), gate=3)
def test_a_burn_at_apogee_leads_to_the_perigee(*, seed: int) -> None:
    """One burn leaves the object with its perigee there, a second one the chaser with its own."""
    instance = eccentric(seed, most=0.3)
    wanted = float(np.random.default_rng([3, seed]).uniform(-100e3, 500e3))
    mission = instance.mission.replace(disposal={"perigee_m": max(wanted, 1.0)})
    instance = instance.replace(mission=mission)
    rows, least = instance.orbits(), EARTH_RADIUS_M + instance.transfer.min_altitude_m
    for body, tow in removals_of(instance, None).items():
        begins_s = tow.begins_s(float(instance.mission.duration_s))
        first, *back = burn_vectors(rows[body], tow, begins_s)
        name = instance.names[body]
        (position,), (velocity,) = body_states(instance, name, begins_s, true_orbits=True)
        low, high = apsides(position, velocity)
        due = min(EARTH_RADIUS_M + max(wanted, 1.0), low)
        assert apsides(position, velocity + first) == pytest.approx((due, high), abs=1.0)
        assert (len(back) == 1) == (due < least) == (tow.back_m_s > 0.0)
        ended = velocity + np.sum([first, *back], axis=0)
        assert apsides(position, ended) == pytest.approx((max(due, least), high), abs=1.0)
        assert tow.back_m_s == pytest.approx(math.fsum(map(np.linalg.norm, back)), abs=1e-9)


@pytest.mark.parametrize("disposal", DISPOSALS)
@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
def test_plans_with_tows_from_apogee_pass_and_fly(dynamics: str, disposal: str) -> None:
    """`check` finds nothing, legs after such tows arrive as planned, and times follow on."""
    instance, plan = planned(dynamics, disposal)
    assert adr_opt.check(instance, plan) == ()
    assert len(plan.lead_ins) >= 1
    flight = fly(instance, plan)
    assert flight.worst_miss_m < 0.1
    for leg, following in pairwise(plan.legs):
        if leg.tow is None:
            continue
        begin, end = leg.tow.burns[0], leg.tow.burns[-1]
        assert leg.end_s <= begin.time_s + 1e-6
        assert leg.tow.end_s == pytest.approx(following.departure_s, abs=1e-6)
        assert end.time_s <= following.leaves_s + 1e-6
    arcs = [arc for _, arc in sample(instance, plan).arcs()]
    for one, other in pairwise(arcs):
        assert one.end_s == pytest.approx(other.start_s, abs=1e-3)


@pytest.mark.parametrize("disposal", DISPOSALS)
def test_refined_tows_end_where_they_should(disposal: str) -> None:
    """Flown under J2 circles and perigees are met, the chaser comes back, and the judge agrees."""
    instance, plan = planned("j2", disposal)
    one = flown(disposal)
    assert one.status == "complete"
    assert check_refined(instance, plan, one) == ()
    assert fly_refined(instance, one).holds
    least = EARTH_RADIUS_M + instance.transfer.min_altitude_m
    for leg in one.legs:
        for tow in leg.removals:
            lowest = lowest_m(state_of(tow.released), one.gravity)
            if "perigee_m" in DISPOSALS[disposal]:
                due = EARTH_RADIUS_M + DISPOSALS[disposal]["perigee_m"]
                assert lowest == pytest.approx(due, abs=20.0)
            else:
                orbit = released(state_of(tow.released), FIELDS[one.gravity])
                assert orbit.altitude_m == pytest.approx(DISPOSALS[disposal]["circle_m"], abs=2e3)
                assert orbit.eccentricity < 5e-4
            assert lowest_m(state_of(tow.onward), one.gravity) > least


def test_the_judge_of_refined_plans_sees_another_perigee() -> None:
    """A refined tow that leads elsewhere than to the perigee of its target is found."""
    instance, plan = planned("j2", "re-entry")
    one = flown("re-entry")
    for perigee_m, seen in ((50e3 + 9e3, False), (50e3 + 11e3, True)):
        mission = instance.mission.replace(disposal={"perigee_m": perigee_m})
        other = instance.replace(mission=mission)
        told = plan.replace(instance=plan.instance.replace(sha256=other.sha256))
        again = one.replace(instance=told.instance, plan=reference(told))
        found = {each.rule for each in check_refined(other, told, again)}
        assert ("release" in found) == seen


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
@over_seeds(range(20), gate=1)
def test_whoever_verifies_finds_the_same_connections(dynamics: str, *, seed: int) -> None:
    """Connections from such tows can be flown, and none that should be there is missing."""
    instance = disposing(eccentric(seed, dynamics, 0.02).with_limits(duration_s=2 * 86400.0), seed)
    sampled = sample_connections(instance, ConnectionFinder(instance), 300, seed)
    assert sampled.faults == ()
    assert min(sampled.connections, sampled.departures) > 20


def test_check_sees_a_tow_that_begins_elsewhere() -> None:
    """A tow whose burns are moved off the apogee is found, and one by burns between circles."""
    instance, plan = planned("j2")
    at = next(n for n, leg in enumerate(plan.legs) if leg.tow is not None)
    tow = plan.legs[at].tow
    assert tow is not None
    late = tuple(burn.replace(time_s=burn.time_s + 60.0) for burn in tow.burns)
    legs = list(plan.legs)
    legs[at] = legs[at].replace(tow=tow.replace(burns=late))
    moved = plan.replace(routes=(plan.routes[0].replace(legs=tuple(legs)),))
    assert ("tow", at + 1) in {(one.rule, one.leg) for one in adr_opt.check(instance, moved)}


def test_only_what_costs_is_towed_from_apogee() -> None:
    """Objects whose eccentricity costs less than 1 m/s are towed between circles, from anywhere."""
    instance = field("j2", 1)
    target = instance.targets[0]
    speed = math.sqrt(MU_M3_S2 / target.orbit.semi_major_axis_m)
    for share in (0.99, 1.01):
        e = share * 2.0 * APOGEE_M_S / speed
        changed = target.replace(orbit=target.orbit.replace(eccentricity=e))
        other = instance.replace(targets=(changed, *instance.targets[1:]))
        tow = removals_of(other, None)[other.first_target]
        assert (tow.apogees is None) == (share < 1.0)


@pytest.mark.parametrize(
    ("disposal", "words"),
    [
        ({"perigee_m": 60e3}, "low thrust tows to circles only"),
        ({"circle_m": 1500e3}, "low thrust tows from"),
    ],
)
def test_low_thrust_tows_down_to_circles(disposal: dict[str, float], words: str) -> None:
    """Spirals to a perigee, or upwards, are refused in a sentence."""
    instance = adr_opt.generate("electric", 0, targets=4)
    with pytest.raises(InputError, match=words):
        instance.replace(mission=instance.mission.replace(disposal=disposal))
