"""Encounter rates: symmetry, limits, integrals, and moved points."""

from __future__ import annotations

import math

import numpy as np
import pytest
from harness import moving_points as moving
from scipy.integrate import quad
from scipy.special import ellipkm1

from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.kernels.orbits.encounters import (
    BLUR_M,
    blurred,
    encounter_rate,
    quarter_period,
    shell_factor,
    tilt_factor,
)
from adr_opt.sources.worth.pairs import mean_speeds


def drawn(seed: int, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shells, inclinations and radii of objects in low orbits."""
    random = np.random.default_rng(seed)
    perigees = EARTH_RADIUS_M + random.uniform(500e3, 1000e3, count)
    shells = np.column_stack((perigees, perigees + random.uniform(5e3, 300e3, count)))
    return shells, np.radians(random.uniform(1.0, 179.0, count)), random.uniform(0.1, 4.0, count)


def rate_of(shells: np.ndarray, tilts: np.ndarray, widths: np.ndarray, i: int, j: int) -> float:
    """Rate of a pair [1/s]."""
    return float(encounter_rate(shells, tilts, widths, mean_speeds(), i, j)[0])


def test_the_elliptic_integral_is_that_of_scipy() -> None:
    """K agrees with SciPy's from 0 to 1 − 10⁻¹²."""
    for part in np.geomspace(1e-12, 1.0, 400):
        assert quarter_period(part) == pytest.approx(ellipkm1(part), rel=1e-12)


def test_rates_are_symmetric() -> None:
    """The rate of i with j is that of j with i."""
    objects = drawn(1, 60)
    for i in range(60):
        for j in range(i):
            assert rate_of(*objects, i, j) == pytest.approx(rate_of(*objects, j, i), rel=1e-12)


def test_shells_that_do_not_meet_have_no_encounters() -> None:
    """The rate is 0 if and only if one perigee is above the other apogee."""
    objects = drawn(2, 80)
    shells = objects[0]
    seen = set()
    for i in range(80):
        for j in range(i):
            apart = max(shells[i, 0], shells[j, 0]) >= min(shells[i, 1], shells[j, 1])
            assert (rate_of(*objects, i, j) == 0.0) == apart
            seen.add(apart)
    assert seen == {True, False}


def test_rates_grow_with_the_square_of_the_radii() -> None:
    """Objects twice as large meet four times as often."""
    shells, tilts, widths = drawn(3, 20)
    for i in range(20):
        for j in range(i):
            once = rate_of(shells, tilts, widths, i, j)
            assert rate_of(shells, tilts, 2.0 * widths, i, j) == pytest.approx(4.0 * once)


def test_the_shell_factor_is_the_integral_of_both_densities() -> None:
    """Where ends are apart, the factor is the integral of the densities of both radii."""
    random = np.random.default_rng(4)
    for _ in range(30):
        lowest, third, second, highest = 7e6 + 1e3 * np.cumsum(random.uniform(8.0, 90.0, 4))
        for one, other in (
            ((lowest, second), (third, highest)),
            ((lowest, highest), (third, second)),
        ):

            def product(
                angle: float,
                low: float = third,
                high: float = second,
                ends: tuple[float, float] = (lowest, highest),
            ) -> float:
                radius = 0.5 * (low + high) - 0.5 * (high - low) * math.cos(angle)
                return 1.0 / math.sqrt((radius - ends[0]) * (ends[1] - radius)) / math.pi**2

            expected = quad(product, 0.0, math.pi)[0]
            assert shell_factor(*one, *other)[0] == pytest.approx(expected, rel=1e-9)


def test_the_tilt_factor_is_the_integral_over_latitudes() -> None:
    """K(k₁²) / cos((i − j)/2) times V / π³ r² is the flux integral over latitudes."""
    random = np.random.default_rng(5)
    for _ in range(30):
        tilt, other = np.radians(random.uniform(5.0, 175.0, 2))
        low, high = sorted((math.sin(tilt), math.sin(other)))

        def flux(
            angle: float,
            low: float = low,
            high: float = high,
            tilts: tuple[float, float] = (tilt, other),
        ) -> float:
            square = (low * math.sin(angle)) ** 2
            along = math.cos(tilts[0]) * math.cos(tilts[1]) / (1.0 - square)
            across = math.sqrt(
                max(1.0 - math.cos(tilts[0]) ** 2 / (1.0 - square), 0.0)
                * max(1.0 - math.cos(tilts[1]) ** 2 / (1.0 - square), 0.0)
            )
            speeds = sum(
                math.sqrt(max(2.0 - 2.0 * (along + sign * across), 0.0)) for sign in (1.0, -1.0)
            )
            return 0.5 * speeds / math.sqrt(high**2 - square)

        # Both densities in latitude, 1 / 2πr² of longitudes, and the speeds of both senses.
        expected = quad(flux, -0.5 * math.pi, 0.5 * math.pi, limit=400)[0] / (2.0 * math.pi**3)
        assert tilt_factor(tilt, other) / math.pi**3 == pytest.approx(expected, rel=1e-6)


def test_a_circular_pair_is_a_particle_in_a_box() -> None:
    """For near-circular shells the rate is the textbook's: πs² V K / (π³ a²), times the factor."""
    middle = EARTH_RADIUS_M + 800e3
    shells = np.array([[middle - 1e4, middle + 2e4], [middle - 2e4, middle + 1e4]])
    tilts, widths = np.radians([70.0, 98.0]), np.array([1.0, 2.0])
    expected = (
        math.pi
        * 9.0
        * math.sqrt(MU_M3_S2 / middle)
        / (math.pi**3 * middle**2)
        * tilt_factor(*tilts)
        * shell_factor(*shells[0], *shells[1])[0]
    )
    assert rate_of(shells, tilts, widths, 0, 1) == pytest.approx(expected, rel=2e-3)


def test_equal_inclinations_are_a_limit() -> None:
    """Rates approach that of equal inclinations, which is finite and the same for both senses."""
    for degrees in (20.0, 71.0, 98.0, 150.0):
        tilt = math.radians(degrees)
        assert tilt_factor(tilt, tilt + 1e-7) == pytest.approx(tilt_factor(tilt, tilt), rel=1e-5)
        assert tilt_factor(tilt, tilt) == pytest.approx(
            tilt_factor(math.pi - tilt, math.pi - tilt), rel=1e-12
        )


def test_rates_stay_finite_at_singular_pairs() -> None:
    """Two polar orbits, and two shells with the same ends, meet at a finite rate."""
    shells = np.full((2, 2), EARTH_RADIUS_M + 850e3) + np.array([-2500.0, 2500.0])
    tilts, widths = np.full(2, 0.5 * math.pi), np.full(2, 1.0)
    assert 0.0 < rate_of(shells, tilts, widths, 0, 1) < 1e-12
    assert blurred(0.0) == pytest.approx(BLUR_M * math.exp(-1.5))
    random = np.random.default_rng(6)
    for apart in (0.0, 300.0, 900.0, 2500.0):
        spread = BLUR_M * (random.uniform(size=400_000) - random.uniform(size=400_000))
        mean = math.exp(np.log(np.abs(apart + spread)).mean())
        assert blurred(apart) == pytest.approx(mean, rel=0.01)


PAIRS = [
    ((700, 800, 98.0), (750, 900, 71.0)),
    ((847.5, 852.5, 71.0), (847.5, 852.5, 71.0)),
    ((840, 850, 71.0), (840, 860, 82.0)),
    ((250, 35786, 28.0), (850, 855, 71.0)),
]


@pytest.mark.parametrize("pair", PAIRS[:2])
def test_rates_are_those_of_moved_points(
    pair: tuple[tuple[float, float, float], tuple[float, float, float]],
) -> None:
    """The closed form is within 3 % and four standard errors of points moved on the orbits."""
    compare(pair, 60_000)


@pytest.mark.slow
@pytest.mark.parametrize(
    "pair",
    [
        *PAIRS[2:],
        ((847.5, 852.5, 71.0), (847.5, 852.5, 82.0)),
        ((840, 850, 89.9), (842, 860, 89.9)),
        ((840, 850, 80.0), (842, 860, 99.9)),
    ],
)
def test_rates_are_those_of_moved_points_near_singular_pairs(
    pair: tuple[tuple[float, float, float], tuple[float, float, float]],
) -> None:
    """So it does at equal altitudes, perigees and near the poles."""
    compare(pair, 1_600_000)


def compare(
    pair: tuple[tuple[float, float, float], tuple[float, float, float]], points: int
) -> None:
    """Compare both rates of a pair."""
    orbits = [
        moving.MovingOrbit(
            EARTH_RADIUS_M + 1e3 * low, EARTH_RADIUS_M + 1e3 * high, math.radians(tilt)
        )
        for low, high, tilt in pair
    ]
    shells = np.array([[orbit.perigee, orbit.apogee] for orbit in orbits])
    closed = rate_of(shells, np.array([orbit.tilt for orbit in orbits]), np.full(2, 0.5), 0, 1)
    near = 0.001 if abs(pair[0][2] + pair[1][2] - 180.0) < 1.0 else moving.NEAR_RAD
    rate, error = moving.moving_rate(*orbits, points, BLUR_M, np.random.default_rng(7), near)
    assert abs(closed / rate - 1.0) < 0.03 + 4.0 * error / rate
    assert error / rate < 0.02
