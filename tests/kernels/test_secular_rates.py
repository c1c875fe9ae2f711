"""Secular rates of J2: against their derivatives, and against J2 motion integrated step by step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rows import row
from seeds import first_of

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


def elements(state: np.ndarray) -> np.ndarray:
    """Semi-major axis, inclination, node and argument of latitude of states, shape (4, n)."""
    r, v = state[:3].T, state[3:].T
    h = np.cross(r, v)
    distance = np.linalg.norm(r, axis=1)
    axis = 1.0 / (2.0 / distance - np.sum(v * v, axis=1) / MU_M3_S2)
    inclination = np.arctan2(np.hypot(h[:, 0], h[:, 1]), h[:, 2])
    node = np.unwrap(np.arctan2(h[:, 0], -h[:, 1]))
    ascending = np.stack([np.cos(node), np.sin(node), np.zeros_like(node)], axis=1)
    ahead = np.cross(h, ascending) / np.linalg.norm(h, axis=1)[:, None]
    latitude = np.unwrap(np.arctan2(np.sum(r * ahead, axis=1), np.sum(r * ascending, axis=1)))
    return np.stack([axis, inclination, node, latitude])


def perigees(state: np.ndarray) -> np.ndarray:
    """Eccentricity and argument of perigee of states, shape (2, n)."""
    r, v = state[:3].T, state[3:].T
    h = np.cross(r, v)
    vector = np.cross(v, h) / MU_M3_S2 - r / np.linalg.norm(r, axis=1)[:, None]
    node = np.arctan2(h[:, 0], -h[:, 1])
    ascending = np.stack([np.cos(node), np.sin(node), np.zeros_like(node)], axis=1)
    ahead = np.cross(h, ascending) / np.linalg.norm(h, axis=1)[:, None]
    angle = np.arctan2(np.sum(vector * ahead, axis=1), np.sum(vector * ascending, axis=1))
    return np.stack([np.linalg.norm(vector, axis=1), np.unwrap(angle)])


def integrated(radius, eccentricity, inclination, revolutions, samples):
    """States at equal times over whole revolutions, by Cowell's method with boinor's J2."""
    perturbations = pytest.importorskip("boinor.core.perturbations")
    integrate = pytest.importorskip("scipy.integrate")
    _, perigee, anomaly = ephemeris.secular_rates(radius, eccentricity, inclination, OBLATENESS_M2)
    period = 2.0 * math.pi / (perigee + anomaly)
    distance = radius * (1.0 - eccentricity)
    speed = math.sqrt(MU_M3_S2 * (2.0 / distance - 1.0 / radius))
    ascending, ahead, _ = ephemeris.frame(inclination, 0.3)
    start = np.concatenate([distance * ascending, speed * ahead])

    def pull(time, state):
        acceleration = -MU_M3_S2 * state[:3] / np.linalg.norm(state[:3]) ** 3
        oblate = perturbations.J2_perturbation(time, state, MU_M3_S2, J2, EARTH_RADIUS_M)
        return np.concatenate([state[3:], acceleration + oblate])

    times = np.linspace(0.0, revolutions * period, revolutions * samples + 1)
    solved = integrate.solve_ivp(
        pull, (0.0, times[-1]), start, "DOP853", times, rtol=1e-11, atol=1e-5
    )
    return times, solved.y


@pytest.mark.parametrize(
    "inclination_deg", first_of([20.0, 71.0, 98.0, 165.0, 51.6, 90.0, 120.0], gate=4)
)
def test_circles_drift_as_integrated_motion_does(inclination_deg):
    """Averaged over revolutions, node and latitude advance at the rates of the averaged orbit.

    Both to a share of the effect of J2 that is of the order of J2 itself.
    """
    samples, revolutions = 64, 15
    times, states = integrated(
        EARTH_RADIUS_M + 750e3, 0.0, math.radians(inclination_deg), revolutions, samples
    )
    axis, inclination, node, latitude = elements(states)
    last = revolutions * samples
    mean_axis, mean_inclination = axis[:last].mean(), inclination[:last].mean()
    # From the average of the first revolution to that of the last.
    span = (revolutions - 1) * samples * times[1]
    turned, gone = (
        (angle[last - samples : last].mean() - angle[:samples].mean()) / span
        for angle in (node, latitude)
    )
    expected = ephemeris.node_rate(mean_axis, mean_inclination, OBLATENESS_M2)
    scale = abs(ephemeris.node_rate(mean_axis, 0.0, OBLATENESS_M2))
    assert turned == pytest.approx(expected, abs=4e-3 * scale)
    expected = ephemeris.latitude_rate(mean_axis, mean_inclination, OBLATENESS_M2)
    assert gone == pytest.approx(expected, abs=4e-3 * 3.0 * scale)


@pytest.mark.parametrize("inclination_deg", [30.0, 63.4349488, 71.0, 98.0])
def test_perigees_turn_as_integrated_ones_do(inclination_deg):
    """The argument of perigee of an eccentric orbit advances at its secular rate."""
    samples, revolutions, eccentricity = 200, 15, 0.1
    times, states = integrated(
        EARTH_RADIUS_M + 1700e3, eccentricity, math.radians(inclination_deg), revolutions, samples
    )
    axis, inclination, _, _ = elements(states)
    shape, perigee = perigees(states)
    last = revolutions * samples
    span = (revolutions - 1) * samples * times[1]
    turned = (perigee[last - samples : last].mean() - perigee[:samples].mean()) / span
    mean = axis[:last].mean(), shape[:last].mean(), inclination[:last].mean()
    expected = ephemeris.secular_rates(*mean, OBLATENESS_M2)[1]
    scale = abs(ephemeris.secular_rates(mean[0], mean[1], 0.0, OBLATENESS_M2)[1])
    assert turned == pytest.approx(expected, abs=0.01 * scale)


def test_a_sun_synchronous_node_turns_once_a_year():
    """At 800 km and 98.603° the node advances by a turn in a tropical year."""
    rate = ephemeris.node_rate(EARTH_RADIUS_M + 800e3, math.radians(98.603), OBLATENESS_M2)
    assert rate * 365.2422 * DAY_S == pytest.approx(2.0 * math.pi, rel=1e-3)
