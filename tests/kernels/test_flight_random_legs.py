"""Thousands of random transfers, each flown burn by burn in two-body motion.

The burns come from the kernels; where they lead is worked out without them: states by rotation
matrices, coasts by boinor's solution in universal variables, called directly and in metres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
import rows
from one_window import one_window

from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.kernels.legs import burns as burn_kernels
from adr_opt.kernels.legs import co_elliptic, sequences
from adr_opt.kernels.orbits.ephemeris import COPLANAR_RAD

propagation = pytest.importorskip("boinor.core.propagation")

WEEK_S = 7 * 86400.0

MISS_M = 1e-4
"""Rounding over a week, and the tolerance of the propagator: measured 2e-5 m."""

# The Clohessy–Wiltshire equations leave out terms of the order L²/r; they add up lap by lap.
APPROACH_ERROR = 0.45


@dataclass(frozen=True)
class Flown:
    """What the assertions look at; its repr is the failing input."""

    orbit_i: tuple[float, ...]
    orbit_j: tuple[float, ...]
    rule: co_elliptic.TransferRule
    ready: float
    theta: float
    revolutions: int
    phasing_radius: float
    lost_delta_v: float
    miss: float
    speed: float
    arrival_miss: float


def state(orbit, time):
    """Position and velocity on a circular orbit: rotations by node, inclination and latitude."""
    radius, inclination, raan, latitude = orbit[:4]
    rate = math.sqrt(MU_M3_S2 / radius**3)

    def turn(angle, a, b):
        matrix = np.eye(3)
        matrix[a, a] = matrix[b, b] = math.cos(angle)
        matrix[b, a], matrix[a, b] = math.sin(angle), -math.sin(angle)
        return matrix

    axes = turn(raan, 0, 1) @ turn(inclination, 1, 2) @ turn(latitude + rate * time, 0, 1)
    return axes @ (radius, 0.0, 0.0), axes @ (0.0, radius * rate, 0.0)


def coast(position, velocity, time):
    """State after some time of free motion."""
    if time == 0.0:
        return position, velocity
    f, g, f_dot, g_dot = propagation.vallado(MU_M3_S2, position, velocity, time, 100)
    return f * position + g * velocity, f_dot * position + g_dot * velocity


def draw(rng, opposite=False):
    """Two orbits, transfer settings and a ready time, with the special cases well represented."""
    low, high = EARTH_RADIUS_M + 400e3, EARTH_RADIUS_M + 1500e3
    radius_i, radius_j = rng.uniform(low, high, 2)
    if rng.random() < 0.3:  # equal or nearly equal radii
        radius_j = radius_i + rng.choice([0.0, 1.0, -1.0]) * 10 ** rng.uniform(-6, 3)
    # every inclination, and the singular ones of Keplerian elements
    inclination_i = rng.choice([*rng.uniform(0, math.pi, 6), 0.0, 1e-9, 0.5 * math.pi, math.pi])
    raan_i = rng.uniform(-10, 10)
    kind = rng.choice(["any", "any", "near", "same", "calibration"])
    small = 10 ** rng.uniform(-12, -1)
    if opposite:
        inclination_j = math.pi - inclination_i + rng.choice([0.0, small]) * rng.normal()
        raan_j = raan_i + math.pi + rng.choice([0.0, small]) * rng.normal()
    elif kind == "any":
        inclination_j, raan_j = rng.uniform(0, math.pi), rng.uniform(-10, 10)
    elif kind == "near":
        inclination_j = inclination_i + small * rng.normal()
        raan_j = raan_i + small * rng.normal()
    elif kind == "same":
        inclination_j, raan_j = inclination_i, raan_i
    else:
        inclination_i, inclination_j = np.radians(rng.uniform(95, 97, 2))
        raan_i, raan_j = np.radians(rng.uniform(-1, 1, 2))
    rule = rows.rule(
        fraction=float(rng.choice([0.75, 0.75, 0.0, 1.0, rng.uniform(0, 1)])),
        standoff=float(rng.choice([1000.0, 1000.0, 0.0, rng.uniform(0, 5000)])),
        k_max=int(rng.choice([0, 1, 12, 12])),
        time_value_m_s_per_h=float(rng.choice([0.0, 75.0, 1000.0, 1e5])),
    )
    inclination_j = min(math.pi, max(0.0, inclination_j))
    return (
        rows.row(radius_i, inclination_i, raan_i, rng.uniform(-10, 10)),
        rows.row(radius_j, inclination_j, raan_j, rng.uniform(-10, 10)),
        rule,
        rng.uniform(0, WEEK_S),
    )


def flown(orbit_i, orbit_j, rule, ready):
    """Choose the sequence of the first event after a time and fly it; None if there is none."""
    pair = co_elliptic.prepare(orbit_i, orbit_j, 0.0, rule, 0.0)
    first, half_turns = co_elliptic.first_departure(pair)
    half_period = math.pi / pair.rate_i
    event = max(0, math.ceil((ready - first) / half_period))
    departure = first + event * half_period
    lead = co_elliptic.target_lead(pair, departure, half_turns + event)
    chosen = sequences.best_sequence(pair, rule, departure, lead, one_window(), 0, departure)
    if not math.isfinite(chosen.delta_v):
        return None
    times, vectors, phases = burn_kernels.burns(
        orbit_i, orbit_j, pair, rule, departure, chosen.revolutions, chosen.phasing_radius
    )
    position, velocity = state(orbit_i, departure)
    now, miss, speed = departure, None, None
    for time, vector, phase in zip(times, vectors, phases, strict=True):
        position, velocity = coast(position, velocity, time - now)
        now = time
        if phase == burn_kernels.APPROACH and miss is None:
            behind = rows.changed(orbit_j, latitude=-rule.standoff / orbit_j[0])
            goal_position, goal_velocity = state(behind, now)
            miss = math.dist(position, goal_position)
            speed = math.dist(velocity, goal_velocity)
        velocity = velocity + vector
    return Flown(
        orbit_i=tuple(orbit_i.tolist()),
        orbit_j=tuple(orbit_j.tolist()),
        rule=rule,
        ready=ready,
        theta=pair.theta,
        revolutions=chosen.revolutions,
        phasing_radius=chosen.phasing_radius,
        lost_delta_v=abs(np.linalg.norm(vectors, axis=1).sum() - chosen.delta_v),
        miss=miss,
        speed=speed,
        arrival_miss=math.dist(position, state(orbit_j, now)[0]),
    )


def assert_arrives(leg):
    # Planes closer than COPLANAR_RAD count as one (or as opposite): the leg stays in the first.
    off_plane = min(leg.theta, math.pi - leg.theta)
    allowed = MISS_M + (leg.orbit_j[0] * off_plane if off_plane < COPLANAR_RAD else 0.0)
    assert leg.miss <= allowed, leg
    assert leg.speed <= 1e-6, leg
    linear = APPROACH_ERROR * leg.rule.standoff**2 / leg.orbit_j[0]
    assert leg.arrival_miss <= linear + 2.0 * allowed + 1e-3, leg
    assert leg.lost_delta_v <= 1e-6, leg


def test_random_legs_arrive():
    """Whatever the geometry, the burns lead to the stand-off and their sizes add up to the ΔV."""
    rng = np.random.default_rng(20260101)
    legs = [leg for leg in (flown(*draw(rng)) for _ in range(4000)) if leg is not None]
    for leg in legs:
        assert_arrives(leg)
    # The draw must not have become one-sided: every kind of leg is there in number.
    assert len(legs) >= 2000
    assert sum(leg.revolutions == 0 for leg in legs) >= 300
    assert sum(leg.revolutions > 0 for leg in legs) >= 300
    assert sum(leg.phasing_radius > leg.orbit_j[0] for leg in legs) >= 300
    assert sum(leg.phasing_radius < leg.orbit_j[0] for leg in legs) >= 300
    assert sum(leg.theta < COPLANAR_RAD for leg in legs) >= 300
    assert sum(leg.theta > 0.5 * math.pi for leg in legs) >= 100


def test_legs_between_opposite_planes_arrive():
    """Planes that are opposite, or nearly so, have a line of nodes like any other."""
    rng = np.random.default_rng(20260102)
    legs = [
        leg for leg in (flown(*draw(rng, opposite=True)) for _ in range(600)) if leg is not None
    ]
    assert len(legs) >= 300
    for leg in legs:
        assert_arrives(leg)


def test_a_wrong_burn_would_be_seen():
    """The yardstick itself: a hundredth of a second of delay breaks the assertion."""
    rng = np.random.default_rng(1)
    leg = next(leg for leg in (flown(*draw(rng)) for _ in range(100)) if leg is not None)
    position, velocity = state(np.array(leg.orbit_j), 100.0)
    late = coast(position, velocity, 0.01)[0]
    assert math.dist(late, position) > 1e5 * MISS_M
