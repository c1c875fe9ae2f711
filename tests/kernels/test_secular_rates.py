"""Secular rates of J2, against their derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rows import row

from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, J2, MU_M3_S2, OBLATENESS_M2
from adr_opt.kernels.legs import drift_linear as drift
from adr_opt.kernels.orbits import ephemeris

CASES = 3000
INCLINATIONS_DEG = (0.0, 1e-7, 30.0, 63.4349488, 71.0, 90.0 - 1e-7, 90.0, 98.0, 116.6, 150.0, 180.0)


def drawn(rng: np.random.Generator) -> tuple[float, float]:
    """A radius and an inclination, the special ones well represented."""
    inclination = rng.choice([math.degrees(rng.uniform(0.0, math.pi)), *INCLINATIONS_DEG])
    return EARTH_RADIUS_M + rng.uniform(300e3, 2000e3), math.radians(inclination)


def test_rates_of_a_circle_are_those_of_an_orbit_without_eccentricity():
    """Node and latitude of a circle advance as elements do for e = 0 (docs/model.md section 1)."""
    rng = np.random.default_rng(0)
    for _ in range(CASES):
        radius, inclination = drawn(rng)
        node, perigee, anomaly = ephemeris.secular_rates(radius, 0.0, inclination, OBLATENESS_M2)
        n = math.sqrt(MU_M3_S2 / radius**3)
        strength = J2 * n * (EARTH_RADIUS_M / radius) ** 2
        cosine = math.cos(inclination)
        assert node == pytest.approx(-1.5 * strength * cosine, rel=1e-12)
        assert node == ephemeris.node_rate(radius, inclination, OBLATENESS_M2)
        assert perigee == pytest.approx(0.75 * strength * (5.0 * cosine**2 - 1.0), abs=1e-18)
        latitude = ephemeris.latitude_rate(radius, inclination, OBLATENESS_M2)
        assert perigee + anomaly == pytest.approx(latitude, rel=1e-13)
        assert latitude == pytest.approx(n + 1.5 * strength * (4.0 * cosine**2 - 1.0), rel=1e-13)


def test_without_oblateness_nothing_but_the_latitude_moves():
    """With J2 = 0 planes and perigees stand still, and the latitude advances at the mean motion."""
    rng = np.random.default_rng(1)
    for _ in range(CASES):
        radius, inclination = drawn(rng)
        eccentricity = rng.uniform(0.0, 0.3)
        node, perigee, anomaly = ephemeris.secular_rates(radius, eccentricity, inclination, 0.0)
        assert (abs(node), abs(perigee)) == (0.0, 0.0)
        assert anomaly == ephemeris.mean_motion(radius)
        assert ephemeris.latitude_rate(radius, inclination, 0.0) == anomaly


def test_what_a_change_drifts_to_is_the_derivative_of_the_drift():
    """The drift of the node by radius and by inclination is the m and q of docs/model.md section 3.

    By central differences, at every inclination, a polar one too, where q is a limit.
    """
    rng = np.random.default_rng(2)
    for _ in range(CASES):
        radius, inclination = drawn(rng)
        orbit = row(radius, inclination, 0.0, 0.0, oblateness=OBLATENESS_M2)
        pair = drift.prepare(orbit, orbit, radius - 1e5, radius + 1e5, OBLATENESS_M2, 0.0)
        speed = math.sqrt(MU_M3_S2 / radius)
        dr, di = 10.0, 1e-5
        by_radius = ephemeris.node_rate(radius + dr, inclination, OBLATENESS_M2)
        by_radius -= ephemeris.node_rate(radius - dr, inclination, OBLATENESS_M2)
        by_inclination = ephemeris.node_rate(radius, inclination + di, OBLATENESS_M2)
        by_inclination -= ephemeris.node_rate(radius, inclination - di, OBLATENESS_M2)
        # A change of radius of 2 r b/V for b m/s, of the inclination b/V; a node is worth V sin i.
        sine = math.sin(inclination)
        expected_m = -sine * speed * by_radius / (2.0 * dr) * 2.0 * radius / speed
        expected_q = -sine * by_inclination / (2.0 * di)
        assert pair.by_radius == pytest.approx(expected_m, rel=1e-7, abs=1e-15)
        assert pair.by_inclination == pytest.approx(expected_q, rel=2e-6, abs=1e-15)


def test_a_sun_synchronous_node_turns_once_a_year():
    """At 800 km and 98.603° the node advances by a turn in a tropical year."""
    rate = ephemeris.node_rate(EARTH_RADIUS_M + 800e3, math.radians(98.603), OBLATENESS_M2)
    assert rate * 365.2422 * DAY_S == pytest.approx(2.0 * math.pi, rel=1e-3)
