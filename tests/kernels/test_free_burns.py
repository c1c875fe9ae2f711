"""The price of free burns: a bound to first order, steady, symmetric, and restated by the judge."""

from __future__ import annotations

import math

import numpy as np
import pytest
import rows

from adr_opt.common.constants import DAY_S, OBLATENESS_M2, TURN_RAD
from adr_opt.judge.check.eccentric import StatedSequence, short_cost
from adr_opt.kernels.legs import co_elliptic, free_burns, precession
from adr_opt.kernels.legs.free_burns import DUALS, MARGIN, MOST_REVOLUTIONS

SPEED = 7500.0


def price(k: int, changes: np.ndarray, turn: float = 0.0) -> float:
    """F of changes (c, d, Δe along, Δe across), and 4 sin²(θ/2)."""
    return float(free_burns.delta_v(free_burns.faces_of(k), SPEED, *changes.tolist(), turn))


def drawn_changes(rng: np.random.Generator) -> np.ndarray:
    """Changes of a leg, every other time with one of them small."""
    changes = 0.02 * rng.standard_normal(4)
    if rng.random() < 0.5:
        changes[rng.integers(4)] *= 1e-3 * rng.random()
    return changes


@pytest.mark.parametrize("k", range(MOST_REVOLUTIONS + 1))
def test_no_primer_is_longer_than_one(k: int) -> None:
    """What a unit impulse adds to a dual vector's function is at most 1 all along the way."""
    swept = (2 * k + 3) * math.pi
    u = np.linspace(0.0, swept, 2001 * (k + 1))
    for climb, swing, along, across in DUALS[k]:
        ahead = 2.0 * (climb + swing * (1.0 - 2.0 * u / swept))
        ahead += 2.0 * (along * np.cos(u) + across * np.sin(u))
        outward = 8.0 / (3.0 * swept) * swing + along * np.sin(u) - across * np.cos(u)
        assert np.hypot(ahead, outward).max() <= 1.0


def test_no_impulses_within_a_plane_take_less_to_first_order() -> None:
    """Whatever impulses are drawn, the changes that they make have no greater price."""
    rng, nearest = np.random.default_rng(0), 0.0
    for _ in range(4000):
        k, count = int(rng.integers(MOST_REVOLUTIONS + 1)), int(rng.integers(1, 5))
        swept = (2 * k + 3) * math.pi
        u = rng.uniform(0.0, swept, count)
        t, r = rng.standard_normal((2, count)) * [[1.0], [rng.choice([0.0, 0.3])]]
        changes = np.array(
            [
                (2.0 * t).sum(),
                (2.0 * t * (1.0 - 2.0 * u / swept) + 8.0 / (3.0 * swept) * r).sum(),
                (2.0 * t * np.cos(u) + r * np.sin(u)).sum(),
                (2.0 * t * np.sin(u) - r * np.cos(u)).sum(),
            ]
        )
        least, taken = price(k, changes) / MARGIN, SPEED * np.hypot(t, r).sum()
        assert least <= taken * (1.0 + 1e-9)
        nearest = max(nearest, least / taken)
    assert nearest > 0.99


def test_the_price_is_symmetric_and_above_its_floor() -> None:
    """The other node, the way backwards and mirrored cost as much, and none less than the floor."""
    rng = np.random.default_rng(1)
    for _ in range(4000):
        k, changes = int(rng.integers(MOST_REVOLUTIONS + 1)), drawn_changes(rng)
        turn = float(rng.choice([0.0, 1e-3, 0.02, 0.3]) * rng.random()) ** 2
        found = price(k, changes, turn)
        for signs in ((-1, -1, -1, -1), (-1, 1, 1, -1), (1, -1, -1, 1)):
            assert price(k, changes * signs, turn) == pytest.approx(found, rel=1e-12)
        floor = free_burns.floor(SPEED, changes[0], math.hypot(*changes[2:]), turn)
        assert floor <= found * (1.0 + 1e-12)
        # A larger turn, and larger changes, never cost less; and there is no leap.
        assert price(k, changes, 1.01 * turn) >= found * (1.0 - 1e-12)
        assert price(k, 1.001 * changes, turn) <= 1.001 * found * (1.0 + 1e-12)
        side = np.add(changes, [0.0, 0.0, 0.0, 1e-9])
        assert abs(price(k, side, turn) - found) <= 1e-4


def pair_of(
    rng: np.random.Generator, oblateness: float, shape: float
) -> tuple[co_elliptic.Pair, co_elliptic.TransferRule, np.ndarray]:
    """Two bodies near each other, and the rule by which their legs are priced by free burns."""
    law = rows.rule(oblateness=oblateness)._replace(free=True)
    first = rows.drawn_body(rng, rng.uniform(0.9, 1.8), rng.uniform(-3.0, 3.0), (7e5, 9e5), shape)
    second = rows.changed(
        first,
        radius=rng.uniform(-5e4, 5e4),
        inclination=rng.uniform(-0.02, 0.02),
        raan=rng.uniform(-0.03, 0.03),
        latitude=rng.uniform(0.0, TURN_RAD),
        oblateness=oblateness,
    )
    bodies = np.array([first, second])
    for body in bodies:
        body[rows.columns.ECCENTRICITY] = rng.uniform(0.0, shape)
        body[rows.columns.PERIGEE] = rng.uniform(-3.0, 3.0)
    return co_elliptic.prepare(bodies[0], bodies[1], 0.0, law, 0.0), law, bodies


def test_circles_take_no_more_than_their_sequence() -> None:
    """Between circles F is at most the sequence's ΔV, whose burns are free ones, too."""
    rng, nearest = np.random.default_rng(2), math.inf
    for _ in range(2000):
        pair, law, _ = pair_of(rng, 0.0, 0.0)
        k = int(rng.integers(law.max_phasing_revolutions + 1))
        r = pair.reference + rng.uniform(-1e5, 1e5)
        time = co_elliptic.flight_time(pair.radius_i, pair.radius_j, 0.0, 0.0, 0.75, r)[0]
        time += k * co_elliptic.lap_time(r, 0.0)[0]
        found = co_elliptic.leg_delta_v(pair, law, k, r, 0.0, time, pair.turn)
        circles = co_elliptic.turned_delta_v(pair, law, k, r, pair.turn, 0.0)
        assert pair.floor_delta_v <= found
        # Second orders of some hundredths of the radius.
        assert found <= MARGIN * 1.01 * circles + 0.01
        nearest = min(nearest, circles / found)
    assert nearest < 1.1


@pytest.mark.parametrize("oblateness", [0.0, OBLATENESS_M2])
def test_the_judges_state_the_same_on_their_own(oblateness: float) -> None:
    """What they work out with vectors is what planners count with, in both dynamics."""
    rng = np.random.default_rng(3)
    for _ in range(1000):
        pair, law, bodies = pair_of(rng, oblateness, 0.02)
        k = int(rng.integers(law.max_phasing_revolutions + 1))
        departure = rng.uniform(0.0, 30.0 * DAY_S)
        low, high = pair.shortest + k * pair.shortest_lap, pair.longest + k * pair.longest_lap
        time = rng.uniform(low, high)
        _, _, theta = precession.line(pair, pair.lag + pair.lag_rate * departure)
        turn = 4.0 * math.sin(0.5 * theta) ** 2
        r = co_elliptic.phasing_radius(pair, law, k, time)
        expected = co_elliptic.leg_delta_v(pair, law, k, r, departure, time, turn)
        arrival = departure + time + law.approach_revolutions * TURN_RAD / pair.rate_j
        stated = StatedSequence(departure, arrival, k, r, theta)
        found = short_cost((bodies[0], bodies[1]), law, departure, stated, 0.0)
        assert found == pytest.approx(expected, rel=1e-8)


def test_the_orbit_between_both_ends_stays_within_the_limits_of_altitude() -> None:
    """Legs that would phase with a perigee below the floor, or an apogee above, are none."""
    rng = np.random.default_rng(4)
    for _ in range(200):
        pair, law, _ = pair_of(rng, 0.0, 0.02)
        between = 0.5 * (pair.eccentricity_i + pair.eccentricity_j)
        for time, apsis, limit in (
            (pair.shortest, 1.0 - between, law.min_radius),
            (pair.longest, 1.0 + between, law.max_radius),
        ):
            r = co_elliptic.phasing_radius(pair, law, 0, time)
            assert r * apsis == pytest.approx(limit, abs=100.0)
