"""Positions of the station and the targets: on planning circles, or on true orbits."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...common.constants import MU_M3_S2
from ...common.errors import InputError
from ...kernels.orbits import elements, ephemeris
from ...kernels.orbits.ephemeris import EPOCH_S
from ...plan.after_tows import left_row
from ...plan.plan import Burn, Leg
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from .kepler import Array, drift, propagate, turned


def body_states(
    instance: Instance, body: str, times_s: npt.ArrayLike, *, true_orbits: bool = False
) -> tuple[Array, Array]:
    """States of the station or of a target.

    Parameters
    ----------
    instance : Instance
    body : str
        Its name.
    times_s : (n,) array_like
        Times since the epoch [s].
    true_orbits : bool
        False: on the circle that the plan is made with (docs/model.md section 1), where the chaser
        meets it. True: on the ellipse of its elements. The same for circles. Both drift where the
        dynamics of the instance do.

    Returns
    -------
    positions_m, velocities_m_s : (n, 3) float64
        In the inertial frame of the elements.

    Raises
    ------
    InputError
        The instance has no such body.
    """
    times = np.atleast_1d(np.asarray(times_s, dtype=float))
    try:
        orbit = instance.body_orbits[instance.names.index(body)]
    except ValueError:
        raise InputError(f"{body!r} is not a body of the instance") from None
    row = np.array(orbit.row(instance.oblateness_m2, instance.decay_of(body)))
    if true_orbits and orbit.eccentricity > 0.0:
        return _on_ellipse(orbit, row, instance.oblateness_m2, times)
    return _on_circle(orbit, row, times)


def leaving_state(
    instance: Instance, leg: Leg, lead_in: Sequence[Burn] = ()
) -> tuple[Array, Array]:
    """State at a leg's departure, before its first burn: position [m], velocity [m/s], shape (3,).

    Where the tow before it leads to an ellipse, on the circle that legs from there are planned on.

    Parameters
    ----------
    instance : Instance
    leg : Leg
    lead_in : sequence of Burn
        Those that lead there from the orbit of its origin, as of :attr:`.Plan.lead_ins`.
    """
    if not lead_in:
        position, velocity = (s[0] for s in body_states(instance, leg.origin, leg.leaves_s))
        return position, velocity
    row = left_row(instance, leg.origin, leg.departure_s)
    if row is not None and float(ephemeris.eccentricity_at(row, EPOCH_S)):
        position, velocity = ephemeris.state_at(row, leg.leaves_s)
        return position, velocity
    now, position, velocity = after_burns(instance, leg.origin, lead_in)
    if row is None:
        return position, velocity
    positions, velocities = drift(position, velocity, leg.leaves_s - now, instance.oblateness_m2)
    return positions[0], velocities[0]


def after_burns(
    instance: Instance, body: str, lead_in: Sequence[Burn]
) -> tuple[float, Array, Array]:
    """Time of the last burn of a tow [s], and position [m] and velocity [m/s] after it, (3,).

    One that begins at an apogee does so on the true orbit of the object.
    """
    now = lead_in[0].time_s
    true = left_row(instance, body, now) is not None
    position, velocity = (s[0] for s in body_states(instance, body, now, true_orbits=true))
    for burn in lead_in:
        span_s, now = burn.time_s - now, burn.time_s
        if span_s:
            positions, velocities = drift(position, velocity, span_s, instance.oblateness_m2)
            position, velocity = positions[0], velocities[0]
        velocity = velocity + np.array(burn.delta_v_m_s)
    return now, position, velocity


def body_secular(instance: Instance, body: str) -> tuple[float, float]:
    """Pace and node rate of a body, as from :func:`.kepler.secular`."""
    orbit = instance.body_orbits[instance.names.index(body)]
    row = np.array(orbit.row(instance.oblateness_m2))
    motion = ephemeris.mean_motion(ephemeris.radius_at(row, EPOCH_S))
    pace = ephemeris.latitude_rate_at(row, EPOCH_S) / motion
    return float(pace), float(ephemeris.node_rate_at(row, EPOCH_S))


def body_positions(
    instance: Instance, times_s: npt.ArrayLike, *, true_orbits: bool = False
) -> Array:
    """Positions of all bodies, stations first, shape (bodies, n, 3) [m]."""
    return np.stack(
        [
            body_states(instance, name, times_s, true_orbits=true_orbits)[0]
            for name in instance.names
        ]
    )


def true_state_at_epoch(orbit: Orbit) -> tuple[Array, Array]:
    """Position [m] and velocity [m/s] on the true Kepler orbit, at the epoch."""
    e = orbit.eccentricity
    true = math.radians(orbit.true_anomaly_deg)
    latitude = math.radians(orbit.argument_of_perigee_deg) + true
    perigee = math.radians(orbit.argument_of_perigee_deg)
    parameter = orbit.semi_major_axis_m * (1.0 - e * e)
    radius = parameter / (1.0 + e * math.cos(true))
    speed = math.sqrt(MU_M3_S2 / parameter)
    node, ahead = _axes(orbit)
    # The velocity is that of a circle turned by the latitude, plus e times that of the perigee.
    return (
        radius * (math.cos(latitude) * node + math.sin(latitude) * ahead),
        speed
        * (
            -(math.sin(latitude) + e * math.sin(perigee)) * node
            + (math.cos(latitude) + e * math.cos(perigee)) * ahead
        ),
    )


def _on_circle(orbit: Orbit, row: Array, times: Array) -> tuple[Array, Array]:
    u = elements.latitudes(row, times)[:, None]
    node, ahead = _axes(orbit)
    radius = float(ephemeris.radius_at(row, EPOCH_S))
    speed = math.sqrt(MU_M3_S2 / radius)
    positions = radius * (np.cos(u) * node + np.sin(u) * ahead)
    velocities = speed * (np.cos(u) * ahead - np.sin(u) * node)
    return _precessed(positions, velocities, float(ephemeris.node_rate_at(row, EPOCH_S)) * times)


def _on_ellipse(
    orbit: Orbit, row: Array, oblateness_m2: float, times: Array
) -> tuple[Array, Array]:
    """Kepler motion at the pace of the mean anomaly, with moving perigee and node."""
    perigee_rate = float(ephemeris.perigee_rate_at(row, EPOCH_S))
    anomaly_rate = float(ephemeris.latitude_rate_at(row, EPOCH_S)) - perigee_rate
    motion = float(ephemeris.mean_motion(ephemeris.radius_at(row, EPOCH_S)))
    flown = anomaly_rate / motion * times
    faster = float(ephemeris.latitude_acceleration_at(row, EPOCH_S))
    if faster:
        flown = flown + 0.5 * faster / motion * times * times
    positions, velocities = propagate(*true_state_at_epoch(orbit), flown)
    if not ephemeris.planes_drift(oblateness_m2):
        return positions, velocities
    node, ahead = _axes(orbit)
    # Within its plane the whole orbit turns with the perigee.
    c, s = np.cos(perigee_rate * times)[:, None], np.sin(perigee_rate * times)[:, None]
    for vectors in (positions, velocities):
        x, y = (vectors @ node)[:, None], (vectors @ ahead)[:, None]
        vectors[:] = (c * x - s * y) * node + (s * x + c * y) * ahead
    return _precessed(positions, velocities, float(ephemeris.node_rate_at(row, EPOCH_S)) * times)


def _precessed(positions: Array, velocities: Array, angles: Array) -> tuple[Array, Array]:
    if not angles.any():
        return positions, velocities
    return turned(positions, angles), turned(velocities, angles)


def _axes(orbit: Orbit) -> tuple[Array, Array]:
    """Unit vectors towards the ascending node, and a quarter revolution later."""
    i, o = math.radians(orbit.inclination_deg), math.radians(orbit.raan_deg)
    return (
        np.array([math.cos(o), math.sin(o), 0.0]),
        np.array([-math.sin(o) * math.cos(i), math.cos(o) * math.cos(i), math.sin(i)]),
    )
