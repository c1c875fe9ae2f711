"""Drift legs to first order: rates linear in radius and inclination, without phase.

The start of :mod:`.drift`, which prices drift legs with exact rates and whole laps. In components
along the node, the orbit and the inclination, all in m/s, let v be what is left to do on arrival if
nothing is done at departure. A change b₁ made at departure has become M b₁ on arrival, since
another semi-major axis and another inclination drift otherwise:

    v = V̄ ( ΔΩ(t_f) sin ī , Δa / (2 ā) , Δi ),    M = [[1, −m, −q], [0, 1, 0], [0, 0, 1]],
    m = 7 R̄ sin ī · T,    q = R̄ tan ī sin ī · T .

The sum of squares of b₁ and b₂ = v − M b₁ is least where (I + MᵀM) b₁ = Mᵀ v. With ρ = (−m, −q) and
v⊥, b⊥ the parts of v and b₁ besides the node, that system has the solution

    w = (2 ρ·v⊥ + |ρ|² v_x) / (4 + |ρ|²),    b_x = (v_x − w) / 2,    b⊥ = (v⊥ + ρ b_x) / 2 ,

and b₂ = (b_x, v⊥ − b⊥): half of the node is turned at either end. Where the drift orbit would leave
the altitude limits its radius is held at the limit, and the rest solved for.

After Shen and Casalino, J. Spacecraft and Rockets 58(2), 2021, 575–580; derived anew.
"""

import math
from typing import NamedTuple

from ...common.constants import MU_M3_S2
from ..core.compile import inlined, kernel
from ..orbits import eccentricity, ephemeris

POLAR = 1e-3
"""Cosine of the mean inclination below which q is replaced by its limit."""


class LinearPair(NamedTuple):
    """Data of a long transfer i → j that do not depend on its times.

    Attributes
    ----------
    speed : float
        V̄, circular speed at the mean radius [m/s].
    sine : float
        sin ī.
    lag, lag_rate, lag_by_departure : float
        ΔΩ at t = 0 [rad], how fast it grows if nothing is done [rad/s], and how much it is more for
        every second that the departure is later: 0 but where the chaser leaves from another orbit
        than its body's, whose node moves otherwise.
    climb, tilt : float
        v_y and v_z [m/s].
    by_radius, by_inclination : float
        m and q over T [1/s].
    radius_i, radius_j : float
        [m].
    least_climb, most_climb : float
        Between which b_y keeps the drift orbit within the altitude limits [m/s].
    eccentricity_i, eccentricity_j : float
    perigee_lag, perigee_lag_rate : float
        ω_j − ω_i at t = 0 [rad], and how fast it grows [rad/s].
    """

    speed: float
    sine: float
    lag: float
    lag_rate: float
    lag_by_departure: float
    climb: float
    tilt: float
    by_radius: float
    by_inclination: float
    radius_i: float
    radius_j: float
    least_climb: float
    most_climb: float
    eccentricity_i: float
    eccentricity_j: float
    perigee_lag: float
    perigee_lag_rate: float


@kernel
def prepare(orbit_i, orbit_j, min_radius, max_radius, oblateness, time):
    """Compute the data of long transfers i → j that do not depend on their times.

    Parameters
    ----------
    orbit_i, orbit_j : (columns,) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`, the first one of a body as
        it is left.
    min_radius, max_radius : float
        Limits of the drift orbit [m].
    oblateness : float
        J2 R² [m²].
    time : float
        About which elements and rates are taken: they hold for all departures and arrivals [s].

    Returns
    -------
    LinearPair
    """
    ri, rj = ephemeris.radius_at(orbit_i, time), ephemeris.radius_at(orbit_j, time)
    mean_radius = 0.5 * (ri + rj)
    inclination_i = ephemeris.inclination_at(orbit_i, time)
    inclination_j = ephemeris.inclination_at(orbit_j, time)
    inclination = 0.5 * (inclination_i + inclination_j)
    speed = math.sqrt(MU_M3_S2 / mean_radius)
    sine, cosine = math.sin(inclination), math.cos(inclination)
    node_i, body_rate_i = ephemeris.node_tangent(orbit_i, time)
    node_j, rate_j = ephemeris.node_tangent(orbit_j, time)
    perigee_i, perigee_rate_i = ephemeris.perigee_tangent(orbit_i, time)
    perigee_j, perigee_rate_j = ephemeris.perigee_tangent(orbit_j, time)
    rate_i = ephemeris.coasting_node_rate_at(orbit_i, time)
    mean_rate = 0.5 * (rate_i + rate_j)
    if abs(cosine) > POLAR:
        per_cosine = mean_rate / cosine
    else:
        # The limit: Ω̇ / cos i is the same for every inclination.
        per_cosine = ephemeris.node_rate(mean_radius, 0.0, oblateness)
    reach = 0.5 * speed / mean_radius
    # Linear in radius and inclination: Ω̇ goes with r^(−7/2) cos i, hence 7 and the tangent.
    return LinearPair(
        speed,
        sine,
        node_j - node_i,
        rate_j - rate_i,
        rate_i - body_rate_i,
        reach * (rj - ri),
        speed * (inclination_j - inclination_i),
        7.0 * mean_rate * sine,
        per_cosine * sine * sine,
        ri,
        rj,
        reach * (min_radius - ri),
        reach * (max_radius - ri),
        ephemeris.eccentricity_at(orbit_i, time),
        ephemeris.eccentricity_at(orbit_j, time),
        perigee_j - perigee_i,
        perigee_rate_j - perigee_rate_i,
    )


@kernel
def node_left(pair, arrival):
    """v_x: node difference on arrival if no burn is made before [m/s].

    Whenever the chaser leaves; where that makes a difference ask :func:`node_left_from`.
    """
    return node_left_from(pair, 0.0, arrival)


@kernel
def node_left_from(pair, departure, arrival):
    """v_x for a given departure [m/s]."""
    lag = pair.lag + pair.lag_rate * arrival + pair.lag_by_departure * departure
    lag -= 2.0 * math.pi * math.ceil((lag - math.pi) / (2.0 * math.pi))
    return pair.speed * pair.sine * lag


@kernel
def shape_left(pair, arrival):
    """E: ΔV at either end due to the eccentricity vectors on arrival [m/s]."""
    angle = pair.perigee_lag + pair.perigee_lag_rate * arrival
    return 0.25 * pair.speed * eccentricity.chord(pair.eccentricity_i, pair.eccentricity_j, angle)


@inlined
def climb_of(pair, span, node):
    """b_y of the best split, within the altitude limits [m/s]."""
    m, q = pair.by_radius * span, pair.by_inclination * span
    s = m * m + q * q
    w = (s * node - 2.0 * (m * pair.climb + q * pair.tilt)) / (4.0 + s)
    climb = 0.5 * (pair.climb - 0.5 * m * (node - w))
    return min(max(climb, pair.least_climb), pair.most_climb)


@inlined
def split_at(pair, span, node, climb):
    """b_x and b_z of the best split with a given b_y [m/s]."""
    q = pair.by_inclination * span
    rest = node + pair.by_radius * span * climb
    s = q * q
    along = 0.5 * (rest - (s * rest - 2.0 * q * pair.tilt) / (4.0 + s))
    return along, 0.5 * (pair.tilt - q * along)


@inlined
def cost_of(pair, span, node, shape, climb):
    """ΔV of the best transfer with a given b_y [m/s].

    Parameters
    ----------
    pair : LinearPair
    span, node, shape : float
        T [s]; v_x and E on arrival [m/s].
    climb : float
        b_y [m/s].
    """
    along, tilt = split_at(pair, span, node, climb)
    after = node - along + span * (pair.by_radius * climb + pair.by_inclination * tilt)
    first = along * along + climb * climb + tilt * tilt
    second = after * after + (pair.climb - climb) ** 2 + (pair.tilt - tilt) ** 2
    return math.sqrt(first + shape * shape) + math.sqrt(second + shape * shape)


@kernel
def delta_v(pair, departure, arrival):
    """ΔV of the long transfer between two times [m/s]."""
    span, node = arrival - departure, node_left_from(pair, departure, arrival)
    return cost_of(pair, span, node, shape_left(pair, arrival), climb_of(pair, span, node))
