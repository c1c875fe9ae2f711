"""The burns of long transfers: flown in the mean dynamics, whatever the planes and the length."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
import pytest
from drift_cases import Met, Pair, drawn, fly, pair_of
from rows import FloatArray, oblate_rule

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2, OBLATENESS_M2
from adr_opt.common.errors import InputError
from adr_opt.fly.flight.mean_flight import MeanDynamics
from adr_opt.fly.trajectory.kepler import drift as coast
from adr_opt.kernels.legs import drift, drift_pair
from adr_opt.kernels.orbits import columns, ephemeris
from adr_opt.legs.families.drift_burns import DriftBurns, flown
from adr_opt.mission.problem import Problem

LIMITS = EARTH_RADIUS_M + 400e3, EARTH_RADIUS_M + 1300e3
INCLINATIONS_DEG = (71.0, 98.0, 45.0, 110.0, 89.5)


class Drifted(NamedTuple):
    """A drift, its burns and where they lead.

    Attributes
    ----------
    planned : float
        ΔV of the closed form without eccentricities [m/s].
    """

    pair: Pair
    departure: float
    arrival: float
    planned: float
    flight: DriftBurns
    met: Met


@pytest.fixture(scope="module")
def truth() -> MeanDynamics:
    pytest.importorskip("boinor")
    return MeanDynamics()


def drifts(
    truth: MeanDynamics, seed: int, number: int, days: tuple[float, float]
) -> tuple[list[Drifted], int]:
    """Random drifts between two lengths, flown; and of how many no phase was met."""
    rng = np.random.default_rng(seed)
    law = oblate_rule(limits=LIMITS)
    found, none = [], 0
    for case in range(number):
        inclination = INCLINATIONS_DEG[case % len(INCLINATIONS_DEG)]
        span = math.exp(rng.uniform(*np.log(days))) * DAY_S
        departure, raan = rng.uniform(0.0, 300.0) * DAY_S, rng.uniform(0.0, 360.0)
        spread = 1.0 + 0.1 * span / DAY_S
        pair = pair_of(
            *(
                drawn(
                    rng,
                    inclination + rng.normal(0.0, 0.2),
                    raan + rng.normal(0.0, spread),
                    case % 4 == 0,
                )
                for _ in range(2)
            )
        )
        # Planes drift apart until the departure; most drifts that are flown are cheap ones.
        ahead = (pair.i[columns.RAAN_RATE] - pair.j[columns.RAAN_RATE]) * (departure + span)
        raan = pair.orbit_j.raan_deg + math.degrees(ahead)
        pair = pair_of(pair.orbit_i, pair.orbit_j.replace(raan_deg=raan))
        arrival = departure + span
        try:
            flight = flown(pair.i, pair.j, law, departure, arrival)
        except InputError:
            none += 1
            continue
        circles = [orbit.copy() for orbit in (pair.i, pair.j)]
        for circle in circles:
            circle[columns.ECCENTRICITY] = 0.0
        planned = float(drift.delta_v(drift_pair.prepare(*circles, law, 0.0), departure, arrival))
        met = fly(truth, pair, flight.times, flight.vectors, law.standoff)
        found.append(Drifted(pair, departure, arrival, planned, flight, met))
    return found, none


def assert_flies(case: Drifted) -> None:
    """It stays between its times and within the limits of altitude, and meets the target."""
    assert case.flight.times[0] >= case.departure, case
    assert case.flight.times[-1] <= case.arrival + 1e-6, case
    assert np.all(np.diff(case.flight.times) >= 0.0), case
    assert case.met.behind < 0.5, case
    assert case.met.tilted < 1e-9, case
    assert case.met.lowest > LIMITS[0] - 1e-3, case
    assert case.met.highest < LIMITS[1] + 1e-3, case


def test_random_drifts_arrive(truth):
    """Drifts from two days to a year reach the stand-off, in the target's plane."""
    found, none = drifts(truth, 1, 80, (2.0, 365.0))
    for case in found:
        assert_flies(case)
    assert none <= 0.04 * 80
    off = np.array([case.flight.delta_v / case.planned - 1.0 for case in found])
    assert abs(np.median(off)) < 0.008  # with the last burn in one plane 0.014
    assert off.max() < 0.15
    assert off.min() > -0.05


@pytest.mark.slow
def test_thousands_of_random_drifts_arrive(truth):
    """The same for thousands, of every length in number."""
    lengths = (2.0, 5.0, 10.0, 30.0, 90.0, 365.0)
    for seed, days in enumerate(itertools.pairwise(lengths)):
        found, none = drifts(truth, 10 + seed, 500, days)
        for case in found:
            assert_flies(case)
        assert none <= 0.04 * 500, days


def energy_and_tilt(position: FloatArray, velocity: FloatArray) -> tuple[float, float]:
    """Two-body energy [m²/s²], and the cosine of the inclination."""
    momentum = np.cross(position, velocity)
    energy = 0.5 * float(velocity @ velocity) - MU_M3_S2 / float(np.linalg.norm(position))
    return energy, float(momentum[2] / np.linalg.norm(momentum))


def test_arcs_keep_energy_and_inclination(truth):
    """Along an arc energy, momentum and inclination stay, and only the node moves, at its rate.

    For the coasts that are drawn and for those that are flown, which agree.
    """
    rng = np.random.default_rng(3)
    for _ in range(300):
        orbit = drawn(rng, math.degrees(rng.uniform(0.01, 3.13)), rng.uniform(0.0, 360.0))
        position, velocity = truth.body(orbit, 0.0)
        velocity = velocity * rng.uniform(0.99, 1.01) + rng.normal(size=3)
        energy, cosine = energy_and_tilt(position, velocity)
        axis = -0.5 * MU_M3_S2 / energy
        rate = ephemeris.node_rate(axis, math.acos(cosine), OBLATENESS_M2)
        times = np.sort(rng.uniform(0.0, 30.0 * DAY_S, 4))
        positions, velocities = coast(position, velocity, times, OBLATENESS_M2)
        momentum = np.cross(position, velocity)
        for time, r, v in zip(times, positions, velocities, strict=True):
            assert energy_and_tilt(r, v) == pytest.approx((energy, cosine), rel=1e-11, abs=1e-12)
            other = np.cross(r, v)
            assert np.linalg.norm(other) == pytest.approx(np.linalg.norm(momentum), rel=1e-11)
            before, after = (math.atan2(h[0], -h[1]) for h in (momentum, other))
            turned = math.remainder(after - before - rate * time, 2.0 * math.pi)
            assert turned == pytest.approx(0.0, abs=1e-9 / math.sqrt(1.0 - cosine**2))
            flown_r, flown_v = truth.coast((position, velocity), float(time))
            assert math.dist(r, flown_r) < 0.05
            assert math.dist(v, flown_v) < 1e-4


def test_what_cannot_be_met_is_said(truth):
    """Hours are too short for a drift: the sentence says what to change."""
    rng = np.random.default_rng(4)
    pair = pair_of(drawn(rng, 71.0, 0.0), drawn(rng, 71.0, 30.0))
    with pytest.raises(InputError, match="raise drift_step_s"):
        flown(pair.i, pair.j, oblate_rule(), 0.0, 3600.0)


def test_the_target_is_met_where_its_last_crossings_are_too_late():
    """A cheap drift of twelve days is flown although its first dozen ways arrive after the end."""
    mission = Problem(adr_opt.generate("removal", 12)).missions[0]
    orbits_of, *_, law = mission.transfer_inputs
    one, other = mission.numbers(["debris-001", "debris-016"])
    flight = flown(orbits_of[one], orbits_of[other], law, 154_483_200.0, 155_520_000.0)
    assert flight.delta_v < 17.0
    assert 154_483_200.0 <= flight.times[0] < flight.times[-1] <= 155_520_000.0
