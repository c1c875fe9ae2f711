"""What eccentric ends add to a leg: nothing between circles, and enough to fly it at its best."""

from __future__ import annotations

import math

import numpy as np
import pytest
import rows

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.judge.check.eccentric import StatedSequence, short_cost
from adr_opt.kernels.legs import co_elliptic, precession
from adr_opt.kernels.orbits import columns, eccentricity, ephemeris
from adr_opt.kernels.orbits.eccentricity import matchings
from adr_opt.problem.orbit import Orbit


def drawn(rng: np.random.Generator, most: float, spread: float = 2.0) -> Orbit:
    """An orbit near others, with an eccentricity of at most ``most``."""
    return Orbit(
        semi_major_axis_m=EARTH_RADIUS_M + rng.uniform(7e5, 9e5),
        eccentricity=rng.uniform(0.0, most),
        inclination_deg=rng.uniform(70.0, 70.0 + spread),
        raan_deg=rng.uniform(0.0, spread),
        argument_of_perigee_deg=rng.uniform(0.0, 360.0),
        true_anomaly_deg=rng.uniform(0.0, 360.0),
    )


def pair_of(first: Orbit, second: Orbit, oblateness: float = 0.0) -> co_elliptic.Pair:
    bodies = np.array([first.row(oblateness), second.row(oblateness)])
    law = rows.rule()._replace(oblateness=oblateness)
    return co_elliptic.prepare(bodies[0], bodies[1], matchings(bodies, 0.0)[0, 1], law, 0.0)


def test_a_leg_costs_no_less_than_its_sequence_and_than_its_ends_ask_for() -> None:
    """ΔV is the larger of the sequence between circles and of matching with the turn."""
    rng = np.random.default_rng(0)
    law, dearer = rows.rule(), 0
    for _ in range(2000):
        pair = pair_of(drawn(rng, 0.02, 0.5), drawn(rng, 0.02, 0.5))
        r, k = rng.uniform(law.min_radius, law.max_radius), int(rng.integers(0, 5))
        if rng.random() < 0.5:
            r = pair.radius_i + (pair.radius_j - pair.radius_i) * rng.random()
        _, _, _, square = co_elliptic.burn_parts(pair, law, k, r)
        circles = co_elliptic.turned_delta_v(pair, law, k, r, pair.turn, 0.0)
        least = math.hypot(pair.matching, math.sqrt(square * pair.turn)) + pair.fixed_delta_v
        found = co_elliptic.turned_delta_v(pair, law, k, r, pair.turn, pair.matching)
        assert found == pytest.approx(max(circles, least), rel=1e-14)
        assert pair.floor_delta_v <= found * (1.0 + 1e-14)
        dearer += found > circles + 1.0
    assert 200 < dearer < 1800


def test_circles_cost_what_they_did_to_the_last_digit() -> None:
    """Without eccentricity nothing is added, not even by rounding, whatever the sequence."""
    rng = np.random.default_rng(1)
    law = rows.rule()
    for _ in range(2000):
        pair = pair_of(drawn(rng, 0.0), drawn(rng, 0.0))
        r, k = rng.uniform(law.min_radius, law.max_radius), int(rng.integers(0, 5))
        r = rng.choice([r, pair.radius_i, pair.radius_j])
        climb, rest, chord, square = co_elliptic.burn_parts(pair, law, k, r)
        turning = math.sqrt(chord * chord + square * pair.turn)
        expected = abs(climb) + abs(rest) + turning + pair.fixed_delta_v
        assert co_elliptic.turned_delta_v(pair, law, k, r, pair.turn, pair.matching) == expected


def test_the_share_grows_steadily_from_nothing() -> None:
    """With all eccentricities times s, the share is 0 at s = 0, never falls, and never jumps."""
    rng = np.random.default_rng(2)
    law, grown = rows.rule(), 0
    for _ in range(50):
        pair = pair_of(drawn(rng, 0.02, 0.2), drawn(rng, 0.02, 0.2))
        r = 0.5 * (pair.radius_i + pair.radius_j)
        scales = np.linspace(0.0, 1.0, 201)
        shares = np.array(
            [
                co_elliptic.turned_delta_v(pair, law, 2, r, pair.turn, scale * pair.matching)
                for scale in scales
            ]
        )
        shares -= shares[0]
        assert np.all(np.diff(shares) >= -1e-12)
        assert np.all(np.diff(shares) <= pair.matching / 200 + 1e-9)
        grown += shares[-1] > 0.0
    assert grown > 10


def test_matching_costs_the_same_there_and_back_and_from_any_node() -> None:
    """v·|Δe|/2 is that of vectors in space, once one plane is turned into the other; symmetric."""
    rng = np.random.default_rng(3)
    for spread in (1e-7, 0.1, 3.0, 40.0):
        for _ in range(100):
            ends = [drawn(rng, 0.02, spread) for _ in range(2)]
            bodies = np.array([end.row(0.0) for end in ends])
            costs = matchings(bodies, 0.0)
            assert costs[0, 1] == costs[1, 0]
            normals = [
                ephemeris.frame(body[columns.INCLINATION], body[columns.RAAN])[2] for body in bodies
            ]
            cross = np.cross(normals[1], normals[0])
            sine, cosine = float(np.linalg.norm(cross)), float(normals[0] @ normals[1])
            vector = ends[1].eccentricity_vector()
            if sine > 0.0:
                axis = cross / sine
                vector = (
                    vector * cosine
                    + np.cross(axis, vector) * sine
                    + axis * (axis @ vector) * (1.0 - cosine)
                )
            apart = np.linalg.norm(vector - ends[0].eccentricity_vector())
            speed = math.sqrt(ephemeris.mean_motion(bodies[0, 0]) * bodies[0, 0])
            speed *= math.sqrt(ephemeris.mean_motion(bodies[1, 0]) * bodies[1, 0])
            assert costs[0, 1] == pytest.approx(0.5 * speed * apart, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("oblateness", [0.0, OBLATENESS_M2])
def test_the_checker_states_the_same_on_its_own(oblateness: float) -> None:
    """What `check` works out with vectors is what planners count with, in both dynamics."""
    rng = np.random.default_rng(4)
    law = rows.rule()._replace(oblateness=oblateness)
    for _ in range(300):
        ends = [drawn(rng, 0.02) for _ in range(2)]
        bodies = np.array([end.row(oblateness) for end in ends])
        pair = pair_of(*ends, oblateness)
        time, k = rng.uniform(0.0, 30.0 * DAY_S), int(rng.integers(0, 3))
        r = rng.uniform(law.min_radius, law.max_radius)
        _, _, theta = precession.line(pair, pair.lag + pair.lag_rate * time)
        matching = eccentricity.matching(pair, time) if oblateness else pair.matching
        assert matching > 0.0
        _, _, _, square = co_elliptic.burn_parts(pair, law, k, r)
        expected = math.hypot(matching, 2.0 * math.sqrt(square) * math.sin(0.5 * theta))
        stated = StatedSequence(time, time, k, r, theta)
        found = short_cost((bodies[0], bodies[1]), law, time, stated, 0.0)
        assert found == pytest.approx(expected + pair.fixed_delta_v, rel=1e-9)


def test_plans_state_the_share_and_no_more() -> None:
    """A leg's share is its ΔV less its burns, and never negative."""
    cloud = adr_opt.generate("cloud", 0, targets=16)
    plan = adr_opt.solve(cloud, "greedy-guarded").plan
    assert plan is not None
    assert adr_opt.check(cloud, plan) == ()
    for leg in plan.legs:
        burned = sum(math.hypot(*burn.delta_v_m_s) for burn in leg.burns)
        assert leg.eccentricity_delta_v_m_s >= 0.0
        assert leg.delta_v_m_s == pytest.approx(burned + leg.eccentricity_delta_v_m_s, abs=1e-6)
