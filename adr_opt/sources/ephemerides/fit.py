"""Mean elements fitted to an ephemeris over a mission.

States are sampled and freed of the short-period variations of J2. What is left is linear in the
numbers sought: a constant inclination, a node that drifts at its secular rate, an argument of
latitude that is quadratic in time, and an eccentricity vector made of one that turns with the
perigee and of a constant one. The quadratic term is what drag does to the phase, the constant
vector what J3 does: without it 3 km are left at the epoch.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import DAY_S, EARTH_RADIUS_M, J2, MU_M3_S2, OBLATENESS_M2
from ...common.errors import InputError
from ...kernels.orbits import equinoctial
from ...kernels.orbits.ephemeris import frame as frame_of
from ...kernels.orbits.ephemeris import secular_rates
from ...kernels.orbits.gravity import FIELDS, J3
from ...kernels.orbits.short_periods import swing
from ...problem.orbit import LARGEST_DECAY_M_PER_DAY, Fit, Orbit
from .ephemeris import Array, Ephemeris

LEAST_SAMPLES, MOST_SAMPLES = 160, 2000

SAMPLING_S = 0.25 * DAY_S
"""Largest spacing of samples of long missions, so that the phase can be followed [s]."""

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Step of a low-discrepancy sequence modulo 1, so that samples cover all of a revolution."""

ROUNDS = 3
"""Iterations from osculating to mean elements; each gains three digits."""

TRUST = 0.05
"""Weight of the offset due to J3, relative to half the samples, for missions too short to separate
a constant vector from a rotating one."""

ZONALS = FIELDS["j2"]


class FittedOrbit(NamedTuple):
    """A body's orbit for planning, and the fitted numbers beside it."""

    orbit: Orbit
    decay_m_per_day: float
    fit: Fit


def fitted(ephemeris: Ephemeris, duration_s: float, *, decays: bool = True) -> FittedOrbit:
    """Mean elements of a body fitted over a mission.

    Parameters
    ----------
    ephemeris : Ephemeris
        In the frame of the instance.
    duration_s : float
        From the epoch.
    decays : bool
        Whether the phase may be quadratic in time; stations are planned without.

    Raises
    ------
    InputError
        The ephemeris does not cover the mission, or is of no orbit that can be planned with.
    """
    times = sample_times(duration_s)
    means = np.array([_mean(state) for state in ephemeris.state(times)])
    axis, e_node, e_ahead, inclination, node, latitude = means.T
    if not np.isfinite(means).all() or float(np.hypot(e_node, e_ahead).max()) >= 1.0:
        raise InputError(f"{ephemeris.body!r}: its ephemeris is not of a closed orbit")
    tilt = float(inclination.mean())
    size, eccentricity = float(axis.mean()), float(np.hypot(e_node, e_ahead).mean())
    spread = times if duration_s > 0.0 else np.zeros(1)
    shape, offset = np.zeros(2), np.zeros(2)
    start = pace = bend = 0.0
    for _ in range(2):
        _, perigee_rate, anomaly_rate = secular_rates(size, eccentricity, tilt, OBLATENESS_M2)
        shape, offset = _vectors(spread, e_node, e_ahead, perigee_rate, size, tilt)
        eccentricity = float(np.hypot(*shape))
        lead = np.unwrap(latitude - (perigee_rate + anomaly_rate) * spread)
        start, slope, bend = _parabola(spread, lead, decays=decays)
        pace = perigee_rate + anomaly_rate + slope
        size = _axis_of(pace, eccentricity, tilt)
    node_rate, _, anomaly_rate = secular_rates(size, eccentricity, tilt, OBLATENESS_M2)
    ascending = float(np.unwrap(node - node_rate * spread).mean())
    perigee = math.atan2(shape[1], shape[0])
    decay = 2.0 / 3.0 * size / anomaly_rate * bend * DAY_S
    if not abs(decay) <= LARGEST_DECAY_M_PER_DAY:
        raise InputError(
            f"{ephemeris.body!r}: no orbit fits its ephemeris; the nearest one would lose "
            f"{decay:.0f} m a day"
        )
    return FittedOrbit(
        _orbit(ephemeris.body, size, eccentricity, tilt, ascending, perigee, start - perigee),
        round(decay, 6),
        Fit(eccentricity_offset=(round(float(offset[0]), 9), round(float(offset[1]), 9))),
    )


def sample_times(duration_s: float) -> Array:
    """Times of a mission in order, both ends included, that cover all of a revolution."""
    if not duration_s > 0.0:
        return np.zeros(1)
    count = min(max(LEAST_SAMPLES, math.ceil(duration_s / SAMPLING_S)), MOST_SAMPLES)
    within = (np.arange(1, count - 1) + np.modf(np.arange(1, count - 1) * GOLDEN)[0] - 0.5) / (
        count - 1
    )
    times: Array = duration_s * np.concatenate(([0.0], np.clip(within, 0.0, 1.0), [1.0]))
    return times


def _mean(state: Array) -> Array:
    """Mean elements of an osculating state.

    Returns
    -------
    (6,) float64
        Semi-major axis [m], eccentricity towards the node and a quarter of a revolution later,
        inclination, node and mean argument of latitude [rad].
    """
    own = equinoctial.own_frame(state)
    osculating = equinoctial.elements(state, own)
    mean = osculating
    for _ in range(ROUNDS):
        # The swing is that in the plane of the mean orbit, nearly that of the osculating one.
        moved = equinoctial.state_of(mean, own)
        plane = equinoctial.own_frame(moved)
        elements = equinoctial.elements(moved, plane)
        reached = equinoctial.elements(
            equinoctial.state_of(elements + swing(elements, plane, ZONALS), plane), own
        )
        change = osculating - reached
        change[5] = math.remainder(change[5], math.tau)
        mean = mean + change
    moved = equinoctial.state_of(mean, own)
    normal = equinoctial.own_frame(moved)[2]
    inclination = math.atan2(math.hypot(normal[0], normal[1]), normal[2])
    node = math.atan2(normal[0], -normal[1])
    found = equinoctial.elements(moved, np.array(frame_of(inclination, node)))
    return np.array([found[0], found[1], found[2], inclination, node, found[5]])


def _vectors(
    times: Array, e_node: Array, e_ahead: Array, rate: float, axis: float, tilt: float
) -> tuple[Array, Array]:
    """The rotating eccentricity vector at t = 0, and the constant one."""
    theory = 1j * j3_offset(axis, tilt)
    turning = np.exp(1j * rate * times)
    weight = TRUST * math.sqrt(times.size)
    matrix = np.column_stack((turning, np.ones_like(turning)))
    matrix = np.vstack((matrix, [0.0, weight]))
    values = np.append(e_node + 1j * e_ahead, weight * theory)
    (free, constant), *_ = np.linalg.lstsq(matrix, values, rcond=None)
    return np.array([free.real, free.imag]), np.array([constant.real, constant.imag])


def j3_offset(axis_m: float, inclination: float) -> float:
    """Constant part of the eccentricity vector by J3, a quarter of a revolution past the node."""
    return -0.5 * J3 / J2 * EARTH_RADIUS_M / axis_m * math.sin(inclination)


def _parabola(times: Array, values: Array, *, decays: bool) -> tuple[float, float, float]:
    """Value and slope at t = 0, and second derivative, of the parabola nearest to values."""
    if times.size == 1:
        return float(values[0]), 0.0, 0.0
    span = float(times[-1])
    found = np.polyfit(times / span, values, 2 if decays else 1)
    square, linear, constant = found if decays else (0.0, *found)
    return float(constant), float(linear) / span, 2.0 * float(square) / span**2


def _axis_of(pace: float, eccentricity: float, tilt: float) -> float:
    """Semi-major axis whose argument of latitude advances at a pace [m]."""
    axis = float((MU_M3_S2 / pace**2) ** (1.0 / 3.0))
    for _ in range(20):
        _, perigee_rate, anomaly_rate = secular_rates(axis, eccentricity, tilt, OBLATENESS_M2)
        step = 2.0 / 3.0 * axis * ((perigee_rate + anomaly_rate) / pace - 1.0)
        axis += step
        if abs(step) < 1e-7:
            break
    return axis


def _orbit(
    body: str, axis: float, e: float, tilt: float, node: float, perigee: float, mean: float
) -> Orbit:
    """The orbit of mean elements, rounded far below the precision of a fit."""
    from pydantic import ValidationError

    from ...common.sentences import sentence
    from ..catalogue.propagation import true_anomaly

    true = float(true_anomaly(np.array([mean]), np.array([e]))[0])
    degrees = [round(math.degrees(angle) % 360.0, 8) % 360.0 for angle in (node, perigee, true)]
    try:
        return Orbit(
            semi_major_axis_m=round(axis, 3),
            eccentricity=round(e, 9),
            inclination_deg=round(math.degrees(tilt), 8),
            raan_deg=degrees[0],
            argument_of_perigee_deg=degrees[1],
            true_anomaly_deg=degrees[2],
        )
    except ValidationError as error:
        raise InputError(f"{body!r}: no orbit fits its ephemeris: {sentence(error)}") from None
