"""Data of drift legs: those independent of their times, and the task between two times."""

import math
from typing import NamedTuple

from ...common.constants import MU_M3_S2, TURN_RAD
from ..core.compile import inlined, kernel
from ..orbits import ephemeris
from . import drift_linear
from .drift_linear import LinearPair

MARGIN_M, MARGIN_SHARE = 60e3, 0.3
"""Constants of :func:`margin`."""


class DriftPair(NamedTuple):
    """Data of a drift leg i → j that do not depend on its times.

    Attributes
    ----------
    linear : LinearPair
        The same to first order, which holds radii, speed and what is to change.
    speed_i, climb, least_climb, most_climb : float
        Circular speed at the origin; v_y, and between which y keeps the drift orbit within the
        altitude limits [m/s].
    inclination_i, inclination_j : float
        [rad].
    cosine, cosine_i, sine_i, cosine_j : float
        cos ī, cos i_i, sin i_i and cos i_j.
    node_rate_i, node_rate_j : float
        Of the chaser that has left and stays, and of the target [rad/s].
    latitude, latitude_rate_i, latitude_rate_j : float
        u_j − u_i at t = 0 [rad], and the rates of both [rad/s].
    acceleration_i, acceleration_j : float
        Second derivatives of both where orbits decay [rad/s²].
    lead : float
        How far the stand-off is behind the target [rad].
    approach : float
        Time from the stand-off to the target [s].
    half : float
        Time of half a turn halfway between both orbits [s].
    fraction : float
        f: share of r_j − r that is closed on the way to the co-elliptic orbit.
    oblateness : float
        J2 R² [m²].
    free : bool
        Whether a leg has the price of free burns (:mod:`.drift_free`).
    perigee_i, perigee_rate_i : float
        ω_i at t = 0 [rad], and its rate [rad/s].
    """

    linear: LinearPair
    speed_i: float
    climb: float
    least_climb: float
    most_climb: float
    inclination_i: float
    inclination_j: float
    cosine: float
    cosine_i: float
    sine_i: float
    cosine_j: float
    node_rate_i: float
    node_rate_j: float
    latitude: float
    latitude_rate_i: float
    latitude_rate_j: float
    lead: float
    approach: float
    half: float
    fraction: float
    oblateness: float
    acceleration_i: float
    acceleration_j: float
    free: bool
    perigee_i: float
    perigee_rate_i: float


class Task(NamedTuple):
    """A drift leg between two times, to be split.

    Attributes
    ----------
    span : float
        T [s].
    lag : float
        What is left of the node on arrival if nothing is done before, by the turn taken [rad].
    ahead : float
        λ_j(t_f − approach) − lead − λ_i(t_s) [rad].
    shape, shape_x, shape_y : float
        E, and by free burns V̄ Δe / 2 in the plane, from the node on [m/s].
    """

    span: float
    lag: float
    ahead: float
    shape: float
    shape_x: float
    shape_y: float


ALIKE = (0.0, 0.0, 0.0)
"""Shape between circles."""


@kernel
def prepare(orbit_i, orbit_j, rule, time):
    """Compute the data of drift legs i → j that do not depend on their times.

    Parameters
    ----------
    orbit_i, orbit_j : (columns,) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`, the first one of a body as
        it is left.
    rule : TransferRule
    time : float
        About which elements and rates are taken: they hold for all departures and arrivals [s].

    Returns
    -------
    DriftPair
    """
    low, high = rule.min_radius, rule.max_radius
    if rule.free:
        # Apsides of the drift orbit, whose eccentricity vector is half way (docs/model.md 2.7).
        middle = ephemeris.eccentricity_at(orbit_i, time) + ephemeris.eccentricity_at(orbit_j, time)
        low /= 1.0 - 0.5 * middle
        high = max(low, high / (1.0 + 0.5 * middle))
    return within(orbit_i, orbit_j, rule, (low, high), rule.free, time)


@kernel
def within(orbit_i, orbit_j, rule, limits, free, time):
    """A copy with given limits on the radius of the drift orbit [m]."""
    low, high = limits
    linear = drift_linear.prepare(orbit_i, orbit_j, low, high, rule.oblateness, time)
    ri, rj = linear.radius_i, linear.radius_j
    inclination_i = ephemeris.inclination_at(orbit_i, time)
    inclination_j = ephemeris.inclination_at(orbit_j, time)
    inclination = 0.5 * (inclination_i + inclination_j)
    latitude_i, latitude_rate_i = ephemeris.latitude_tangent(orbit_i, time)
    latitude_j, latitude_rate_j = ephemeris.latitude_tangent(orbit_j, time)
    speed_i = math.sqrt(MU_M3_S2 / ri)
    # Arcs beside the drift orbit are taken at the mean of both radii for the first guess only: legs
    # are priced with their own times (:func:`.drift_arcs.coast`).
    return DriftPair(
        linear,
        speed_i,
        speed_i - math.sqrt(MU_M3_S2 / rj),
        speed_i - math.sqrt(MU_M3_S2 / low),
        speed_i - math.sqrt(MU_M3_S2 / high),
        inclination_i,
        inclination_j,
        math.cos(inclination),
        math.cos(inclination_i),
        math.sin(inclination_i),
        math.cos(inclination_j),
        ephemeris.coasting_node_rate_at(orbit_i, time),
        ephemeris.node_rate_at(orbit_j, time),
        latitude_j - latitude_i,
        latitude_rate_i,
        latitude_rate_j,
        rule.standoff / rj,
        rule.approach_revolutions * ephemeris.revolution_at(orbit_j, time),
        math.pi / ephemeris.latitude_rate(0.5 * (ri + rj), inclination, rule.oblateness),
        rule.first_leg_fraction,
        rule.oblateness,
        ephemeris.latitude_acceleration_at(orbit_i, time),
        ephemeris.latitude_acceleration_at(orbit_j, time),
        free,
        *ephemeris.perigee_tangent(orbit_i, time),
    )


@inlined
def shape_on(pair, arrival):
    """E, and by free burns V̄ Δe / 2 in the plane, from the node on [m/s].

    Parameters
    ----------
    pair : DriftPair
    arrival : float
        t_f, until which perigees turn [s].

    Returns
    -------
    shape, shape_x, shape_y : float
        As :class:`Task` has them.
    """
    linear, x, y = pair.linear, 0.0, 0.0
    if pair.free:
        half = 0.5 * linear.speed
        perigee_i = pair.perigee_i + pair.perigee_rate_i * arrival
        perigee_j = perigee_i + linear.perigee_lag + linear.perigee_lag_rate * arrival
        e_i, e_j = half * linear.eccentricity_i, half * linear.eccentricity_j
        x = e_j * math.cos(perigee_j) - e_i * math.cos(perigee_i)
        y = e_j * math.sin(perigee_j) - e_i * math.sin(perigee_i)
    return drift_linear.shape_left(linear, arrival), x, y


@inlined
def task_of(pair, departure, arrival, shape):
    """The task between two times, with the shape that :func:`shape_on` returns.

    The node is turned the nearer way, as it is if half of size and inclination is changed at either
    end.
    """
    linear, span = pair.linear, arrival - departure
    lag = linear.lag + linear.lag_rate * arrival + linear.lag_by_departure * departure
    worth = linear.speed * linear.sine
    if worth > 0.0:
        half = linear.by_radius * linear.climb + linear.by_inclination * linear.tilt
        left = lag + 0.5 * span * half / worth
        lag -= TURN_RAD * math.ceil((left - math.pi) / TURN_RAD)
    met = arrival - pair.approach
    ahead = pair.latitude + pair.latitude_rate_j * met - pair.latitude_rate_i * departure
    if pair.acceleration_i != 0.0 or pair.acceleration_j != 0.0:
        ahead += 0.5 * pair.acceleration_j * met * met
        ahead -= 0.5 * pair.acceleration_i * departure * departure
    ahead += pair.cosine * (lag + pair.node_rate_i * span - pair.node_rate_j * pair.approach)
    return Task(span, lag, ahead - pair.lead, shape[0], shape[1], shape[2])


@kernel
def task(pair, departure, arrival):
    """The task between two times [s]."""
    return task_of(pair, departure, arrival, shape_on(pair, arrival))


@inlined
def radius_of(pair, climb):
    """Radius of the drift orbit reached by y [m]."""
    speed = pair.speed_i - climb
    return MU_M3_S2 / (speed * speed)


@inlined
def climb_to(pair, radius):
    """The y that reaches a radius [m/s]."""
    return pair.speed_i - math.sqrt(MU_M3_S2 / radius)


@inlined
def margin(change):
    """Largest error of the planned radius of a drift orbit, by its change [m].

    The flight may take another tooth, and leave or arrive at another crossing.
    """
    return MARGIN_M + MARGIN_SHARE * abs(change)
