"""Windows of thrust of a low-thrust leg, and the Earth's shadow in them.

Of a thrust that is on on a part of the revolution, with the share σ of it and the mean c of
|cos(u − u*)| over that part times σ, a change of the plane about u* costs κ = σ / c. Windows are ±η
about u* and its opposite; thrust is off in the shadow, too.

κ and σ are those of one moment of each arc, a sixteenth of the leg from its end, and of the u* of
the closed solution of first order (:mod:`.drift_linear`): so they depend on nothing that the thrust
decides. κ of a leg is the mean of its arcs, by what that solution turns on each.
"""

import math
from typing import NamedTuple

from ..core.compile import inlined, kernel
from ..orbits import ephemeris, sunlight
from . import drift_linear, drift_pair
from .drift_free import first_guess
from .drift_pair import DriftPair

WINDOWS_RAD = (math.pi / 6.0, math.pi / 3.0, math.pi / 2.0)
"""Half-widths η of the windows of thrust."""

WITHIN = 1.0 / 16.0
"""Part of a leg from either end at which shadows are looked at."""


class LowThrustPair(NamedTuple):
    """Data of a low-thrust leg i → j that do not depend on its times.

    Attributes
    ----------
    drift : DriftPair
    node_i, node_j : float
        At t = 0, of the chaser that has left and stays, and of the target [rad].
    node_by_departure : float
        How much that of the chaser is more for every second that the departure is later [rad/s].
    since_j2000 : float
        The epoch, from J2000 [s]; NaN where thrust is on in the shadow.
    """

    drift: DriftPair
    node_i: float
    node_j: float
    node_by_departure: float
    since_j2000: float


@kernel
def prepare(orbit_i, orbit_j, rule, since_j2000, time):
    """Compute the data of low-thrust legs i → j that do not depend on their times.

    Parameters
    ----------
    orbit_i, orbit_j, rule, time
        As :func:`.drift_pair.prepare` takes them.
    since_j2000 : float
        As in :class:`LowThrustPair` [s].
    """
    node_i, rate_i = ephemeris.node_tangent(orbit_i, time)
    node_j, _ = ephemeris.node_tangent(orbit_j, time)
    return LowThrustPair(
        drift_pair.prepare(orbit_i, orbit_j, rule, time), node_i, node_j,
        rate_i - ephemeris.coasting_node_rate_at(orbit_i, time), since_j2000,
    )  # fmt: skip


@inlined
def lit(window, middle, shadow):
    """κ and σ of windows ±η about a place and its opposite, without the shadow.

    Parameters
    ----------
    window : float
        η [rad].
    middle : float
        u* [rad].
    shadow : Shadow
    """
    share, mean = 4.0 * window, 4.0 * math.sin(window)
    if shadow.half > 0.0:
        away = (shadow.middle - middle) % math.pi
        for turns in range(-1, 3):
            low = max(away - shadow.half - turns * math.pi, -window)
            high = min(away + shadow.half - turns * math.pi, window)
            if high > low:
                share -= high - low
                mean -= math.sin(high) - math.sin(low)
    return share / mean, share / (2.0 * math.pi)


class Steering(NamedTuple):
    """Places of thrust on both arcs of a leg.

    Attributes
    ----------
    turn : float
        κ: ΔV of a change of plane over speed and angle.
    first_share, second_share : float
        Share of a revolution in which thrust is on.
    """

    turn: float
    first_share: float
    second_share: float


class Places(NamedTuple):
    """Where thrust is worth most on both arcs of a leg, and the shadows there.

    Attributes
    ----------
    first, second : float
        u* [rad].
    share : float
        The first arc's part of all changes of plane.
    first_shadow, second_shadow : Shadow
    """

    first: float
    second: float
    share: float
    first_shadow: sunlight.Shadow
    second_shadow: sunlight.Shadow


@inlined
def places(pair, task, departure, arrival):
    """Places of thrust of the leg between two times, to first order.

    Parameters
    ----------
    pair : LowThrustPair
    task : Task
    departure, arrival : float
        [s].
    """
    drift, linear = pair.drift, pair.drift.linear
    climb, tilt = first_guess(drift, task)
    node = linear.speed * linear.sine * task.lag
    along, _ = drift_linear.split_at(linear, task.span, node, climb)
    rest = node - along
    rest += task.span * (linear.by_radius * climb + linear.by_inclination * tilt)
    left = linear.tilt - tilt
    one, other = math.sqrt(along * along + tilt * tilt), math.sqrt(rest * rest + left * left)
    share = one / (one + other) if one + other > 0.0 else 0.5
    first, second = math.atan2(along, tilt), math.atan2(rest, left)
    if math.isnan(pair.since_j2000):
        dark = sunlight.Shadow(0.0, 0.0)
        return Places(first, second, share, dark, dark)
    early, late = departure + WITHIN * task.span, arrival - WITHIN * task.span
    node_i = pair.node_i + pair.node_by_departure * departure + drift.node_rate_i * early
    node_j = pair.node_j + drift.node_rate_j * late
    return Places(
        first, second, share,
        sunlight.shadow(linear.radius_i, drift.inclination_i, node_i, pair.since_j2000 + early),
        sunlight.shadow(linear.radius_j, drift.inclination_j, node_j, pair.since_j2000 + late),
    )  # fmt: skip


@inlined
def steering(at, window):
    """Thrust about places, in windows ±η [rad]."""
    turn_i, share_i = lit(window, at.first, at.first_shadow)
    turn_j, share_j = lit(window, at.second, at.second_shadow)
    return Steering(at.share * turn_i + (1.0 - at.share) * turn_j, share_i, share_j)
