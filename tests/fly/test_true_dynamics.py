"""Numerical flight in the field of the zonal harmonics, and mean orbits turned into true states."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from osculating import from_mean_circle
from scipy.integrate import solve_ivp
from seeds import first_of

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.fly.refine.bodies import _ahead, mean_at, moved, state_at_epoch
from adr_opt.fly.trajectory import propagate
from adr_opt.judge.refined.world import FreeMotion
from adr_opt.kernels.orbits import coast, collocation, equinoctial
from adr_opt.kernels.orbits.gravity import FIELDS, gradient, pull
from adr_opt.kernels.orbits.short_periods import mean_elements, osculating

Array = np.ndarray
DAY_S = 86400.0


def random_state(rng: np.random.Generator, most_eccentric: float = 0.3) -> Array:
    """A state on a closed orbit of any inclination whose perigee is at 7,000 km or more."""
    frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    frame[2] = np.cross(frame[0], frame[1])
    e, perigee = rng.uniform(0.0, most_eccentric), rng.uniform(0.0, math.tau)
    axis = rng.uniform(7.0e6, 9.0e6) / (1.0 - e)
    of = [axis, e * math.cos(perigee), e * math.sin(perigee), 0.0, 0.0, rng.uniform(0.0, math.tau)]
    return np.asarray(equinoctial.state_of(np.array(of), frame))


def planes(inclination: float, node: float) -> Array:
    """The frame of a plane: towards its node, a quarter of a revolution later, and its normal."""
    towards = np.array([math.cos(node), math.sin(node), 0.0])
    ahead = np.array(
        [
            -math.sin(node) * math.cos(inclination),
            math.cos(node) * math.cos(inclination),
            math.sin(inclination),
        ]
    )
    return np.array([towards, ahead, np.cross(towards, ahead)])


def energy(state: Array, gravity: str) -> float:
    """Energy in a field, from its potential [m²/s²]."""
    r = math.hypot(*state[:3])
    legendre = np.polynomial.legendre
    total = -MU_M3_S2 / r
    for n, harmonic in zip((2, 3, 4), FIELDS[gravity], strict=True):
        value = legendre.legval(state[2] / r, [0.0] * n + [1.0])
        total += MU_M3_S2 / r * harmonic * (EARTH_RADIUS_M / r) ** n * value
    return 0.5 * float(state[3:] @ state[3:]) + float(total)


@pytest.mark.parametrize("gravity", ["two-body", "j2", "j3", "j4"])
@pytest.mark.parametrize("inclination", first_of([1.24, math.pi, 0.0, 1.7], gate=2))
def test_the_judge_flies_as_scipy_does(gravity: str, inclination: float) -> None:
    """Forth and back, side by side, the judge is where SciPy's DOP853 is with positions."""
    states = []
    for e, longitude in ((0.0, 1.0), (0.01, 4.0), (0.6, 2.5)):
        of = [7.1e6 / (1.0 - e), 0.3 * e, 0.9 * e, 0.0, 0.0, longitude]
        states.append(np.asarray(equinoctial.state_of(np.array(of), planes(inclination, 2.0))))

    def rates(_: float, state: Array) -> Array:
        return np.r_[state[3:], pull(*state[:3], FIELDS[gravity])]

    for until in (0.25 * DAY_S, -0.25 * DAY_S):
        found = FreeMotion(gravity).coast(np.stack(states, axis=1), 0.0, until)
        for state, there in zip(states, found.T, strict=True):
            flown = solve_ivp(rates, (0.0, until), state, "DOP853", rtol=1e-13, atol=1e-6)
            assert np.linalg.norm((flown.y[:, -1] - there)[:3]) < 5e-3
            assert np.linalg.norm((flown.y[:, -1] - there)[3:]) < 5e-6


@pytest.mark.parametrize("inclination", first_of([98.0, 71.0], gate=1))
def test_two_integrators_agree_after_two_years(inclination: float) -> None:
    """Integrators differ by far less than the metre that legs may miss by."""
    of = [EARTH_RADIUS_M + 840e3, 0.003, 0.001, 0.0, 0.0, 1.0]
    state = np.asarray(equinoctial.state_of(np.array(of), planes(math.radians(inclination), 2.0)))
    there = moved(state, 730.0 * DAY_S, "j2")
    other = FreeMotion("j2").coast(state[:, None], 0.0, 730.0 * DAY_S)[:, 0]
    assert np.linalg.norm((there - other)[:3]) < 0.1
    assert np.linalg.norm((there - other)[3:]) < 1e-4


@pytest.mark.parametrize("seed", range(5))
def test_without_harmonics_motion_is_keplers(seed: int) -> None:
    """With J2 = 0 a day ends where Kepler's equation says, to a millimetre."""
    state = random_state(np.random.default_rng(seed), 0.7)
    there = moved(state, DAY_S, "two-body")
    position, velocity = propagate(state[:3], state[3:], [DAY_S])
    assert np.linalg.norm(there[:3] - position[0]) < 1e-3
    assert np.linalg.norm(there[3:] - velocity[0]) < 1e-6


@pytest.mark.parametrize("gravity", ["j2", "j4"])
def test_energy_and_polar_momentum_do_not_drift(gravity: str) -> None:
    """Over two months energy and polar momentum change by 1e-13 at most; rounding leans nowhere."""
    changes = []
    for seed in range(10):
        state = random_state(np.random.default_rng(seed), 0.05)
        there = moved(state, 60.0 * DAY_S, gravity)
        before, after = (np.cross(each[:3], each[3:]) for each in (state, there))
        changes.append(
            [
                energy(there, gravity) / energy(state, gravity) - 1.0,
                (after[2] - before[2]) / np.linalg.norm(before),
            ]
        )
    assert np.abs(changes).max() < 1e-13
    assert np.abs(np.mean(changes, axis=0)).max() < 3e-14


def test_coefficients_of_the_collocation_are_twice_as_exact_as_a_float() -> None:
    """In both parts they integrate polynomials, once and twice, to 1e-30; the first does not."""

    def exactly(near: Array, short: Array) -> Array:
        return np.array(list(map(Fraction, near.flat))).reshape(near.shape) + np.array(
            list(map(Fraction, short.flat))
        ).reshape(near.shape)

    def worst(off: Array) -> float:
        return max(abs(float(one)) for one in off.flat)

    c = exactly(collocation.NODES, collocation.NODES_SHORT)
    b = exactly(collocation.WEIGHTS, collocation.WEIGHTS_SHORT)
    twice = exactly(collocation.SQUARED, collocation.SQUARED_SHORT)
    ends = exactly(collocation.SQUARED_WEIGHTS, collocation.SQUARED_WEIGHTS_SHORT)
    assert worst(ends - b * (1 - c)) < 1e-30
    for k in range(2 * collocation.STAGES):
        assert worst(np.array([b @ c**k - Fraction(1, k + 1)])) < 1e-30
    for k in range(collocation.STAGES - 1):
        assert worst(twice @ c**k - c ** (k + 2) / ((k + 1) * (k + 2))) < 1e-30
    alone = exactly(collocation.NODES, np.zeros(collocation.STAGES))
    assert worst(np.array([b @ alone**3 - Fraction(1, 4)])) > 1e-18


def test_motion_can_be_turned_round() -> None:
    """A week forwards and a week back is where it began, to a millimetre."""
    state = random_state(np.random.default_rng(3))
    back = moved(moved(state, 7.0 * DAY_S, "j4"), -7.0 * DAY_S, "j4")
    assert np.linalg.norm((back - state)[:3]) < 1e-3


@pytest.mark.parametrize("gravity", ["two-body", "j2", "j3", "j4"])
def test_the_gradient_is_that_of_the_pull(gravity: str) -> None:
    """The matrix is symmetric, and finite differences of the pull give it."""
    place = random_state(np.random.default_rng(11))[:3]
    found, differences = np.empty((3, 3)), np.empty((3, 3))
    gradient(*place, FIELDS[gravity], found)
    for axis in range(3):
        step = np.zeros(3)
        step[axis] = 10.0
        above, below = (np.array(pull(*(place + s * step), FIELDS[gravity])) for s in (1.0, -1.0))
        differences[:, axis] = (above - below) / 20.0
    assert np.allclose(found, differences, rtol=1e-8, atol=1e-8 * np.abs(found).max())
    assert np.array_equal(found, found.T)


def test_transition_matrices_are_symplectic_and_predict() -> None:
    """The matrix of an arc is symplectic, and says where a neighbour ends."""
    state = random_state(np.random.default_rng(5), 0.1)
    matrix, there = np.eye(6), state.copy()
    coast.coast(there, 2e4, FIELDS["j4"], matrix)
    unit = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.eye(3), np.zeros((3, 3))]])
    scale = np.diag([1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3])
    scaled = np.linalg.inv(scale) @ matrix @ scale
    assert np.allclose(scaled.T @ unit @ scaled, unit, atol=1e-6)
    moved_by = np.array([1.0, -2.0, 3.0, 1e-3, 2e-3, -1e-3])
    neighbour = moved(state + moved_by, 2e4, "j4")
    assert np.allclose(neighbour - there, matrix @ moved_by, rtol=1e-3, atol=1e-3)


def test_a_flight_into_the_earth_is_an_error() -> None:
    """An orbit that is open, or falls to the centre, gives no state but an error."""
    state = random_state(np.random.default_rng(1))
    for factor in (3.0, 0.0):
        with pytest.raises(ArithmeticError):
            moved(state * np.array([1.0, 1.0, 1.0, factor, factor, factor]), 1e3, "j2")


@pytest.mark.parametrize("seed", range(10))
def test_elements_and_states_are_each_others_inverse(seed: int) -> None:
    """State to elements and back is the same state, in its own frame and in one nearby."""
    state = random_state(np.random.default_rng(seed), 0.7)
    tilted = equinoctial.own_frame(random_state(np.random.default_rng(seed + 1000)))
    for frame in (equinoctial.own_frame(state), tilted):
        back = equinoctial.state_of(equinoctial.elements(state, frame), frame)
        assert np.allclose(back, state, rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_osculating_states_are_those_of_the_closed_form(seed: int) -> None:
    """On mean circles they are Brouwer's and Lyddane's, to the second order: some metres."""
    rng = np.random.default_rng(seed)
    axis, inclination = rng.uniform(6.9e6, 7.5e6), rng.uniform(0.05, 3.0)
    node, latitude = rng.uniform(0.0, math.tau, 2)
    known = from_mean_circle(axis, inclination, node, latitude)
    mean = np.array([axis, 0.0, 0.0, 0.0, 0.0, latitude])
    found = osculating(mean, planes(inclination, node), FIELDS["j2"])
    assert np.linalg.norm((found - known)[:3]) < 20.0
    assert np.linalg.norm((found - known)[3:]) < 0.02
    # What is compared is kilometres.
    plain = equinoctial.state_of(mean, planes(inclination, node))
    assert np.linalg.norm((found - plain)[:3]) > 200.0


@pytest.mark.parametrize("gravity", ["j2", "j4"])
@pytest.mark.parametrize("eccentricity", [0.0, 0.01, 0.2])
@pytest.mark.parametrize("inclination", [0.0, 0.9, 1.7, math.pi])
def test_mean_and_osculating_are_each_others_inverse(
    gravity: str, eccentricity: float, inclination: float
) -> None:
    """Mean to osculating and back is the same orbit, also where e, sin i or both are zero."""
    frame = planes(inclination, 0.4)
    mean = np.array(
        [7.2e6 / (1.0 - eccentricity), 0.6 * eccentricity, 0.8 * eccentricity, 0.0, 0.0, 2.0]
    )
    back = mean_elements(osculating(mean, frame, FIELDS[gravity]), frame, FIELDS[gravity])
    assert back[0] == pytest.approx(mean[0], abs=1e-5)
    assert np.allclose(back[1:], mean[1:], atol=1e-12)


@pytest.mark.parametrize("eccentricity", [0.0, 0.02, 0.3])
def test_mean_elements_of_a_flight_hardly_swing(eccentricity: float) -> None:
    """Over a revolution osculating elements swing by kilometres, mean ones by their second order.

    The mean elements of a flown revolution are the ones it began with, to the same order.
    """
    frame, axis = planes(1.7, 0.3), 7.2e6 / (1.0 - eccentricity)
    mean = np.array([axis, 0.6 * eccentricity, 0.8 * eccentricity, 0.0, 0.0, 1.0])
    state = osculating(mean, frame, FIELDS["j2"])
    means, osculatings = [], []
    for _ in range(40):
        means.append(mean_elements(state, frame, FIELDS["j2"])[0])
        osculatings.append(equinoctial.elements(state, frame)[0])
        state = moved(state, math.tau * math.sqrt(axis**3 / MU_M3_S2) / 40, "j2")
    assert np.ptp(osculatings) > 1e4
    assert np.ptp(means) < 0.01 * np.ptp(osculatings)
    assert np.mean(means) == pytest.approx(axis, abs=200.0)


@pytest.mark.parametrize("eccentric", first_of([0.02, 0.0], gate=1))
def test_bodies_keep_up_with_their_mean_model(eccentric: float) -> None:
    """Over a week a body stays within 30 m of its mean model along the track; uncorrected, not."""
    instance = adr_opt.generate("nominal", 0)
    strayed = []
    for orbit in instance.body_orbits[:6]:
        orbit = orbit.replace(eccentricity=eccentric)
        for span in (0.0, instance.mission.duration_s):
            state = state_at_epoch(orbit, "j2", span)
            worst = 0.0
            for time in np.linspace(0.0, instance.mission.duration_s, 50):
                model = osculating(*mean_at(orbit, "j2", time), FIELDS["j2"])
                ahead = _ahead(moved(state, time, "j2"), model)
                worst = max(worst, abs(ahead) * orbit.semi_major_axis_m)
            if span:
                assert worst < 30.0
            else:
                strayed.append(worst)
    assert max(strayed) > 1e3
