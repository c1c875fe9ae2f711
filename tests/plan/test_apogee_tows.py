"""Tows from apogee: their burns flown, where chasers go on from, and plans with them."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from seeds import over_seeds
from towed_fields import field

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.fly.flight import fly
from adr_opt.fly.trajectory import sample
from adr_opt.fly.trajectory.bodies import body_states
from adr_opt.fly.trajectory.kepler import propagate
from adr_opt.judge.check.tow import towed_bodies
from adr_opt.kernels.orbits import ephemeris
from adr_opt.plan.after_tows import pieced_of
from adr_opt.plan.plan import Plan
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


@over_seeds(range(40), gate=6)
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


def planned(seed: int, dynamics: str) -> tuple[Instance, Plan]:
    """A plan of a field of eccentric objects, with tows."""
    instance = eccentric(seed, dynamics, 0.01).with_limits(duration_s=4 * 86400.0)
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    return instance, plan


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
def test_plans_with_tows_from_apogee_pass_and_fly(dynamics: str) -> None:
    """`check` finds nothing, legs after such tows arrive as planned, and times follow on."""
    instance, plan = planned(0, dynamics)
    assert adr_opt.check(instance, plan) == ()
    assert len(plan.lead_ins) >= 1
    flight = fly(instance, plan)
    assert flight.worst_miss_m < 0.1
    for leg, following in pairwise(plan.legs):
        if leg.tow is None:
            continue
        begin, end = leg.tow.burns
        assert leg.end_s <= begin.time_s + 1e-6
        assert leg.tow.end_s == pytest.approx(following.departure_s, abs=1e-6)
        assert end.time_s <= following.leaves_s + 1e-6
    arcs = [arc for _, arc in sample(instance, plan).arcs()]
    for one, other in pairwise(arcs):
        assert one.end_s == pytest.approx(other.start_s, abs=1e-3)


def test_check_sees_a_tow_that_begins_elsewhere() -> None:
    """A tow whose burns are moved off the apogee is found, and one by burns between circles."""
    instance, plan = planned(0, "j2")
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
