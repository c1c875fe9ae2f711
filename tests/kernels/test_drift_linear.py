"""Drift legs to first order: least squares by matrices, limits, floors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rows import HIGHEST_M, LOWEST_M, FloatArray, drawn_body, row

from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2, OBLATENESS_M2
from adr_opt.kernels.legs import drift_linear as drift
from adr_opt.kernels.orbits import columns

CASES = 4000


def drawn(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Two bodies: of any inclination, equatorial, polar, retrograde, near each other or not."""
    inclination = float(rng.choice([rng.uniform(0.0, math.pi), 0.0, 0.5 * math.pi, math.pi]))
    apart = float(rng.choice([0.0, 1e-9, rng.normal() * 0.01, rng.normal() * 0.3]))
    other = min(math.pi, max(0.0, inclination + apart))
    return (
        drawn_body(rng, inclination, rng.uniform(-10.0, 10.0)),
        drawn_body(rng, other, rng.uniform(-10.0, 10.0)),
    )


def prepared(first: FloatArray, second: FloatArray) -> drift.LinearPair:
    return drift.prepare(first, second, LOWEST_M, HIGHEST_M, OBLATENESS_M2, 0.0)


def by_matrices(
    first: FloatArray, second: FloatArray, departure: float, arrival: float
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """v, M, the b₁ of least squares within the limits, and E, as docs/model.md section 3 has them.

    The least squares over b_x and b_z alone where b_y is at a limit.
    """
    span = arrival - departure
    ri, rj = first[columns.RADIUS], second[columns.RADIUS]
    radius = 0.5 * (ri + rj)
    tilt = second[columns.INCLINATION] - first[columns.INCLINATION]
    inclination = first[columns.INCLINATION] + 0.5 * tilt
    speed = math.sqrt(MU_M3_S2 / radius)
    nodes, perigees = (
        [b[at] + b[rate] * arrival for b in (first, second)]
        for at, rate in ((columns.RAAN, columns.RAAN_RATE), (columns.PERIGEE, columns.PERIGEE_RATE))
    )
    lag = math.remainder(nodes[1] - nodes[0], 2.0 * math.pi)
    v = speed * np.array([lag * math.sin(inclination), (rj - ri) / (2.0 * radius), tilt])
    rate = 0.5 * (first[columns.RAAN_RATE] + second[columns.RAAN_RATE])
    m = 7.0 * rate * math.sin(inclination) * span
    per_cosine = -1.5 * OBLATENESS_M2 / radius**2 * math.sqrt(MU_M3_S2 / radius**3)
    if abs(math.cos(inclination)) > 1e-3:
        per_cosine = rate / math.cos(inclination)
    q = per_cosine * math.sin(inclination) ** 2 * span
    matrix = np.array([[1.0, -m, -q], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    every, wanted = np.vstack([np.eye(3), matrix]), np.concatenate([np.zeros(3), v])
    b1 = np.linalg.lstsq(every, wanted, rcond=None)[0]
    low, high = (speed * (limit - ri) / (2.0 * radius) for limit in (LOWEST_M, HIGHEST_M))
    if not low <= b1[1] <= high:
        b1[1] = min(max(b1[1], low), high)
        wanted -= every[:, 1] * b1[1]
        b1[[0, 2]] = np.linalg.lstsq(every[:, [0, 2]], wanted, rcond=None)[0]
    chord = abs(
        second[columns.ECCENTRICITY] * np.exp(1j * perigees[1])
        - first[columns.ECCENTRICITY] * np.exp(1j * perigees[0])
    )
    return v, matrix, b1, 0.25 * speed * float(chord)


def test_the_closed_form_is_what_the_matrices_give():
    """ΔV agrees with solving for b₁, at the altitude limits too, from hours to years."""
    rng = np.random.default_rng(0)
    at_limits = 0
    for _ in range(CASES):
        first, second = drawn(rng)
        departure, span = rng.uniform(0.0, 700.0) * DAY_S, 10 ** rng.uniform(-1.0, 3.0) * DAY_S
        arrival = departure + span
        v, matrix, b1, shape = by_matrices(first, second, departure, arrival)
        b2 = v - matrix @ b1
        expected = math.hypot(np.linalg.norm(b1), shape) + math.hypot(np.linalg.norm(b2), shape)
        pair = prepared(first, second)
        found = drift.delta_v(pair, departure, arrival)
        case = (first, second, departure, arrival)
        assert found == pytest.approx(expected, rel=1e-8, abs=1e-6), case
        node = drift.node_left(pair, arrival)
        climb = drift.climb_of(pair, span, node)
        along, tilt = drift.split_at(pair, span, node, climb)
        assert np.array([along, climb, tilt]) == pytest.approx(b1, rel=1e-6, abs=1e-6), case
        at_limits += climb in (pair.least_climb, pair.most_climb)
    assert 200 < at_limits < CASES - 200


def test_the_drift_orbit_is_within_the_limits():
    """The radius that b_y leads to is between the altitude limits."""
    rng = np.random.default_rng(1)
    for _ in range(CASES):
        first, second = drawn(rng)
        pair = prepared(first, second)
        span, arrival = 10 ** rng.uniform(-1.0, 3.0) * DAY_S, rng.uniform(0.0, 1e8)
        climb = drift.climb_of(pair, span, drift.node_left(pair, arrival))
        radius = pair.radius_i + climb * (pair.radius_i + pair.radius_j) / pair.speed
        assert LOWEST_M - 1e-3 <= radius <= HIGHEST_M + 1e-3, (first, second, span, arrival)


def test_what_is_left_of_the_node_is_the_nearer_way():
    """v_x belongs to a difference of nodes in (−π, π], whichever turn they are counted in."""
    rng = np.random.default_rng(4)
    for _ in range(CASES):
        first, second = drawn(rng)
        pair, arrival = prepared(first, second), rng.uniform(0.0, 1e9)
        node = drift.node_left(pair, arrival)
        worth = pair.speed * pair.sine
        assert abs(node) <= math.pi * worth
        lag = pair.lag + pair.lag_rate * arrival
        if worth > 1.0:
            assert math.remainder(node / worth - lag, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
    straight = prepared(
        row(7e6, 1.0, 0.0, 0.0, oblateness=OBLATENESS_M2),
        row(7e6, 1.0, math.pi, 0.0, oblateness=OBLATENESS_M2),
    )
    assert drift.node_left(straight, 0.0) == math.pi * straight.speed * straight.sine


def test_around_polar_orbits_nothing_jumps():
    """Where q is taken by its limit and where it is not, ΔV is the same but for a share of 1e-4.

    That much lies between the mean of two rates and the rate at the mean radius.
    """
    for side in (-1.0, 1.0):
        costs = []
        for cosine in (drift.POLAR * (1.0 - 1e-9), drift.POLAR * (1.0 + 1e-9)):
            first, second = (
                row(
                    radius,
                    0.5 * math.pi + side * math.asin(cosine),
                    node,
                    0.0,
                    oblateness=OBLATENESS_M2,
                )
                for radius, node in ((7.1e6, 0.0), (7.15e6, 0.02))
            )
            costs.append(drift.delta_v(prepared(first, second), 0.0, 60.0 * DAY_S))
        assert costs[0] == pytest.approx(costs[1], rel=1e-4)


def test_a_retrograde_drift_is_the_mirror_image_of_a_prograde_one():
    """Seen from below the equator inclinations are 180° less and nodes run the other way."""
    rng = np.random.default_rng(5)
    for _ in range(CASES):
        first, second = drawn(rng)
        mirrored = []
        for orbit in (first, second):
            shape = {"eccentricity": orbit[columns.ECCENTRICITY], "perigee": orbit[columns.PERIGEE]}
            mirrored.append(
                row(orbit[0], math.pi - orbit[1], -orbit[2], 0.0, oblateness=OBLATENESS_M2, **shape)
            )
        departure, span = rng.uniform(0.0, 700.0) * DAY_S, 10 ** rng.uniform(-1.0, 3.0) * DAY_S
        costs = [
            drift.delta_v(prepared(*bodies), departure, departure + span)
            for bodies in ((first, second), mirrored)
        ]
        assert costs[1] == pytest.approx(costs[0], rel=1e-6, abs=1e-6), (first, second)


@pytest.mark.parametrize(
    ("altitude_m", "inclination_deg", "expected"),
    [(750e3, 96.0, (0.892, 0.418, 0.152)), (840e3, 71.0, (0.736, 0.246, 0.084))],
)
def test_a_change_of_node_costs_what_the_page_on_drift_says(altitude_m, inclination_deg, expected):
    """After 7, 30 and 90 days a change of the node alone costs the shares of docs/drift.md."""
    orbit = row(
        EARTH_RADIUS_M + altitude_m,
        math.radians(inclination_deg),
        0.0,
        0.0,
        oblateness=OBLATENESS_M2,
    )
    other = row(orbit[0], orbit[1], math.radians(0.5), 0.0, oblateness=OBLATENESS_M2)
    pair = prepared(orbit, other)
    direct = pair.speed * pair.sine * math.radians(0.5)
    found = [drift.delta_v(pair, 0.0, days * DAY_S) / direct for days in (7.0, 30.0, 90.0)]
    assert found == pytest.approx(expected, abs=0.0006)
