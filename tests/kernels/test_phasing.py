"""Sequences at many flight times at once: as cheap as each one solved for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rows import row

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.kernels.legs import co_elliptic, phasing


def random_pairs(highest_m: float, count: int, free: bool = False):
    """Pairs, some of them in one plane, with altitudes from 300 km to a limit."""
    rng = np.random.default_rng(1)
    for number in range(count):
        rule = (
            adr_opt.generate("tiny", 0)
            .transfer_rule()
            ._replace(
                first_leg_fraction=float(rng.choice([0.0, 0.75, 1.0])),
                max_phasing_revolutions=9,
                max_radius=EARTH_RADIUS_M + highest_m,
                free=free,
            )
        )
        inclination = rng.uniform(0.0, math.pi)
        (radius, node, latitude), (other, beside, ahead) = (
            (EARTH_RADIUS_M + rng.uniform(350e3, 1900e3), *rng.uniform(-math.pi, math.pi, 2))
            for _ in range(2)
        )
        if number % 3 == 0:
            beside = node + rng.uniform(-0.02, 0.02)
        if number % 5 == 0:
            beside = node
        shapes = [
            {"eccentricity": rng.uniform(0.0, 0.02), "perigee": rng.uniform(-3.0, 3.0)}
            for _ in range(2 * free)
        ] or [{}, {}]
        orbits = (
            row(radius, inclination, node, latitude, **shapes[0]),
            row(other, inclination, beside, ahead, **shapes[1]),
        )
        yield co_elliptic.prepare(orbits[0], orbits[1], 2.0, rule, 0.0), rule, rng


@pytest.mark.parametrize(
    ("highest_m", "tolerance"), [(900e3, 5e-11), (2000e3, 5e-11), (3000e3, 2e-10), (9000e3, 1e-12)]
)
@pytest.mark.parametrize("free", [False, True])
def test_interpolation_costs_what_a_solved_sequence_costs(highest_m, tolerance, free):
    """Whatever the limits of altitude and the burns, the least is that of trying every k."""
    found = 0
    for pair, rule, rng in random_pairs(highest_m, 30, free):
        curves, leaves = phasing.curves_of(pair, rule), 1e4 * rng.random()
        lap = math.pi / pair.rate_i
        most = rule.max_phasing_revolutions
        longest = pair.longest + most * pair.longest_lap
        times = rng.uniform(0.9 * pair.shortest, 1.02 * longest, 50)
        cost, revolutions = np.full(50, math.inf), np.full(50, -1)
        expected, fewest = np.full(50, math.inf), np.full(50, -1)
        for k in range(most + 1):
            phasing.lower(
                pair, rule, curves, k, phasing.Flights(leaves, times, 49), cost, revolutions
            )
            for t, time in enumerate(times):
                low = pair.shortest + k * pair.shortest_lap
                if low <= time <= pair.longest + k * pair.longest_lap:
                    radius = co_elliptic.phasing_radius(pair, rule, k, time)
                    delta_v = co_elliptic.leg_delta_v(
                        pair, rule, k, radius, leaves + t * lap, time, pair.turn
                    )
                    if delta_v < expected[t]:
                        expected[t], fewest[t] = delta_v, k
        assert cost[49] == math.inf  # beyond the size
        np.testing.assert_allclose(
            cost[:49], expected[:49], rtol=4e-16 if free else 0.0, atol=tolerance
        )
        np.testing.assert_array_equal(revolutions[:49], fewest[:49])
        found += int(np.isfinite(cost).sum())
    assert found > 750


def test_wide_limits_are_not_interpolated():
    """The usual limits of altitude have curves; limits that are too wide for them have none."""
    usual, wide = (
        phasing.curves_of(*next(random_pairs(highest_m, 1))[:2]) for highest_m in (2000e3, 9000e3)
    )
    assert usual.time.shape == (10, phasing.NODES)
    assert wide.time.shape == (0, phasing.NODES)
