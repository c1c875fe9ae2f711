"""Drag in an atmosphere of exponential layers: time until re-entry, and orbit after a time.

Perigee and apogee change at rates averaged over a revolution, in a still, spherical atmosphere
(D. G. King-Hele, Satellite Orbits in an Atmosphere, 1987, chapter 4).
"""

import math

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ..core.compile import inlined, kernel

POINTS = 24
"""Points of half a revolution in eccentric anomaly, denser towards perigee."""

STEP = 0.08
"""Largest change in a step: of the perigee in scale heights, of the width of the orbit."""

MOST_STEPS = 5000


@kernel
def log_density(altitude, altitudes, logs):
    """Logarithm of the density of the air [ln kg/m³] by a table, and the scale height [m]."""
    last = altitudes.size - 2
    low, high = 0, last
    while low < high:
        middle = (low + high + 1) // 2
        if altitudes[middle] <= altitude:
            low = middle
        else:
            high = middle - 1
    slope = (logs[low + 1] - logs[low]) / (altitudes[low + 1] - altitudes[low])
    return logs[low] + slope * (altitude - altitudes[low]), -1.0 / slope


@inlined
def _step(perigee, apogee, altitudes, logs):
    """A step under drag.

    Returns
    -------
    perigee_change, apogee_change : float
        [m].
    step : float
        Time that it would take in air as dense as at its beginning [s m²/kg].
    layers : float
        Growth of the logarithm of the density within it.
    """
    axis, half = 0.5 * (apogee + perigee), 0.5 * (apogee - perigee)
    eccentricity = half / axis
    falls, shrinks = 0.0, 0.0
    for point in range(POINTS):
        share = (point + 0.5) / POINTS
        part = eccentricity * math.cos(math.pi * share**2)
        altitude = axis * (1.0 - part) - EARTH_RADIUS_M
        weight = 2.0 * share / POINTS * math.exp(log_density(altitude, altitudes, logs)[0])
        speed = math.sqrt((1.0 + part) / (1.0 - part))
        # Gauss's equations under drag along the track
        falls += weight * speed * (1.0 + part)
        shrinks += weight * speed * (1.0 - eccentricity**2) * math.cos(math.pi * share**2)
    root = math.sqrt(MU_M3_S2 * axis)
    axis_rate, eccentricity_rate = -falls * root, -shrinks * root / axis
    perigee_rate = axis_rate * (1.0 - eccentricity) - axis * eccentricity_rate
    apogee_rate = axis_rate * (1.0 + eccentricity) + axis * eccentricity_rate
    scale = log_density(perigee - EARTH_RADIUS_M, altitudes, logs)[1]
    step = STEP * min(
        scale / max(-perigee_rate, 1e-300), (2.0 * half + scale) / max(-apogee_rate, 1e-300)
    )
    # The air becomes denser within a step.
    layers = max(-perigee_rate * step / scale, 1e-9)
    return perigee_rate * step, apogee_rate * step, step, layers


@kernel
def drag_time(perigee, apogee, altitudes, logs, most):
    """Time until re-entry, times the ballistic coefficient.

    Parameters
    ----------
    perigee, apogee : float
        Radii [m].
    altitudes, logs : (row,) float64
        Table of the air: altitudes [m], logarithms of densities [ln kg/m³]. The orbit is down
        where its perigee falls below the lowest.
    most : float
        Result beyond which the orbit need not be followed.

    Returns
    -------
    float
        Time × drag coefficient × area / mass [s m²/kg]; at most about ``most``.
    """
    floor = EARTH_RADIUS_M + altitudes[0]
    total = 0.0
    for _ in range(MOST_STEPS):
        if perigee <= floor or total >= most:
            break
        perigee_change, apogee_change, step, layers = _step(perigee, apogee, altitudes, logs)
        perigee += perigee_change
        apogee = max(apogee + apogee_change, perigee)
        total += step * -math.expm1(-layers) / layers
    return total


@kernel
def after_drag(shells, ballistic, altitudes, logs, time):
    """Orbits after some time under drag, each in place.

    Parameters
    ----------
    shells : (object, 2) float64
        Radii of perigee and apogee [m], changed. Below the lowest altitude of the table an object
        is down, and is not followed further.
    ballistic : (object,) float64
        Drag coefficient × area / mass [m²/kg].
    altitudes, logs : (row,) float64
        As of :func:`drag_time`.
    time : float
        [s].
    """
    floor = EARTH_RADIUS_M + altitudes[0]
    for at in range(ballistic.size):
        perigee, apogee, left = shells[at, 0], shells[at, 1], time * ballistic[at]
        for _ in range(MOST_STEPS):
            if perigee <= floor or left <= 0.0:
                break
            perigee_change, apogee_change, step, layers = _step(perigee, apogee, altitudes, logs)
            part, whole = 1.0, step * -math.expm1(-layers) / layers
            if whole > left:
                # The share of the step after which its time, equally weighed, is the rest.
                part = -math.log1p(-layers * left / step) / layers
            perigee += part * perigee_change
            apogee = max(apogee + part * apogee_change, perigee)
            left -= whole
        shells[at, 0], shells[at, 1] = perigee, apogee
