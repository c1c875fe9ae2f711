"""The closed form of low-thrust legs, stated once more for the judge.

That of :mod:`adr_opt.kernels.legs.low_thrust_split`, with rates that are integrated over the ramps.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import MU_M3_S2
from ...kernels.core.compile import kernel
from ...kernels.orbits import ephemeris
from .drift_ends import Ends
from .low_thrust_windows import Shape, shadow_of, with_shape

FloatArray = npt.NDArray[np.float64]

WINDOWS_DEG = (30.0, 60.0, 90.0)

NODES, WEIGHTS = (
    tuple(float(value) for value in values) for values in np.polynomial.legendre.leggauss(6)
)


class Steered(NamedTuple):
    """A leg with its places of thrust.

    Attributes
    ----------
    turn : float
        κ.
    shares : (float, float)
        Of a revolution in which thrust is on.
    shape : Shape
    acceleration, exhaust : float
        [m/s²], [m/s].
    rounded : float
        Rounding of tips [m/s].
    """

    turn: float
    shares: tuple[float, float]
    shape: Shape
    acceleration: float
    exhaust: float
    rounded: float


def places_of(
    ends: Ends, rates: tuple[float, float], limits: tuple[float, float]
) -> tuple[FloatArray, float]:
    """Arguments of latitude at which both arcs turn the plane, to first order [rad].

    And the first arc's part of that.

    Parameters
    ----------
    rates : (float, float)
        Of the nodes of the chaser and of the target [rad/s].
    limits : (float, float)
        Of the drift orbit, as radii [m].
    """
    mean_radius = 0.5 * (ends.radius_i + ends.radius_j)
    inclination = 0.5 * (ends.inclination_i + ends.inclination_j)
    mean = 0.5 * (rates[0] + rates[1])
    by_size = 7.0 * mean * ends.sine * ends.span
    if abs(ends.cosine) > 1e-3:
        by_tilt = mean * math.tan(inclination) * ends.sine * ends.span
    else:
        per_cosine = -1.5 * ends.oblateness * math.sqrt(MU_M3_S2 / mean_radius**7)
        by_tilt = per_cosine * ends.sine**2 * ends.span
    per_radius = 0.5 * ends.speed / mean_radius
    wanted = np.array(
        [
            ends.speed * ends.sine * (ends.node - rates[0] * ends.span),
            per_radius * (ends.radius_j - ends.radius_i),
            ends.speed * (ends.inclination_j - ends.inclination_i),
        ]
    )
    carried = np.array([[1.0, -by_size, -by_tilt], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    first = np.linalg.solve(np.eye(3) + carried.T @ carried, carried.T @ wanted)
    low, high = (per_radius * (limit - ends.radius_i) for limit in limits)
    if not low <= first[1] <= high:
        clamped = min(max(float(first[1]), low), high)
        others = np.array([0, 2])
        less = wanted - clamped * carried[:, 1]
        part = carried[:, others]
        solved = np.linalg.solve(np.eye(2) + part.T @ part, part.T @ less)
        first = np.array([solved[0], clamped, solved[1]])
    second = wanted - carried @ first
    places = np.array([math.atan2(first[0], first[2]), math.atan2(second[0], second[2])])
    turned = [math.hypot(change[0], change[2]) for change in (first, second)]
    return places, turned[0] / sum(turned) if sum(turned) > 0.0 else 0.5


@kernel
def ramp(ends: Ends, one: float, other: float, i_one: float, i_other: float) -> tuple[float, float]:
    """Mean rates of node and longitude on a ramp between two speeds and inclinations [rad/s]."""
    node = longitude = 0.0
    for at in range(len(NODES)):
        share = 0.5 * (1.0 + NODES[at])
        speed, inclination = one + share * (other - one), i_one + share * (i_other - i_one)
        radius = MU_M3_S2 / (speed * speed)
        motion = speed / radius
        pull = 1.5 * ends.oblateness / (radius * radius)
        node -= 0.5 * WEIGHTS[at] * pull * motion * math.cos(inclination)
        longitude += 0.5 * WEIGHTS[at] * motion * (1.0 + pull * (3.0 * ends.cosine**2 - 1.0))
    return node, longitude


@kernel
def laps_at(ends: Ends, times: tuple[float, float], speed: float) -> float:
    """Laps gained relative to the target: a whole number where the chaser meets it."""
    start, end = math.sqrt(MU_M3_S2 / ends.radius_i), math.sqrt(MU_M3_S2 / ends.radius_j)
    coasting = ends.span - ends.approach - times[0] - times[1]
    gained = times[0] * ramp(ends, start, speed, 0.0, 0.0)[1]
    gained += coasting * ramp(ends, speed, speed, 0.0, 0.0)[1]
    gained += times[1] * ramp(ends, speed, end, 0.0, 0.0)[1]
    return float((gained - ends.ahead) / (2.0 * math.pi))


@kernel
def node_to_turn(ends: Ends, times: tuple[float, float], speed: float, tilt: float) -> float:
    """Change of the node that the arcs have to make, beyond its own drift during the leg [rad]."""
    start, end = math.sqrt(MU_M3_S2 / ends.radius_i), math.sqrt(MU_M3_S2 / ends.radius_j)
    turned = ends.inclination_i + tilt / ends.speed
    coasting = ends.span - ends.approach - times[0] - times[1]
    node = ends.node - ends.target_rate * ends.approach
    node -= times[0] * ramp(ends, start, speed, ends.inclination_i, turned)[0]
    node -= coasting * ramp(ends, speed, speed, turned, turned)[0]
    node -= times[1] * ramp(ends, speed, end, turned, ends.inclination_j)[0]
    return float(node)


@kernel
def arc_costs(
    ends: Ends, steered: Steered, times: tuple[float, float], speed: float, tilt: float
) -> tuple[float, float, float]:
    """The quantity to minimise, and the ΔV of both arcs [m/s].

    Parameters
    ----------
    speed, tilt : float
        Circular speed on the drift orbit, and change of inclination by the first arc [m/s].
    """
    start, end = math.sqrt(MU_M3_S2 / ends.radius_i), math.sqrt(MU_M3_S2 / ends.radius_j)
    node = node_to_turn(ends, times, speed, tilt)
    along = ends.speed * ends.sine * node
    climb, rest = start - speed, speed - end
    left = ends.speed * (ends.inclination_j - ends.inclination_i) - tilt
    round_off = steered.rounded * steered.rounded
    one = math.sqrt(climb**2 + (steered.turn * tilt) ** 2 + round_off)
    other = math.sqrt(rest**2 + (steered.turn * left) ** 2 + round_off)
    both = one + other
    form = with_shape(math.hypot(steered.turn * along, both), steered.shape, climb, rest)
    total = 4.0 * ends.speed * math.sin(min(0.25 * form / ends.speed, 0.5 * math.pi))
    first = total * (one / both if both > 0.0 else 0.5)
    return form, first, total - first


@kernel
def settled(times: tuple[float, float], steered: Steered, first: float, second: float):  # type: ignore[no-untyped-def]
    """Times of thrust for the ΔV of both arcs, and their change from the previous round [s]."""
    flow = steered.exhaust / steered.acceleration
    lighter = math.exp(-first / steered.exhaust)
    one = flow * (1.0 - lighter) / steered.shares[0]
    other = flow * lighter * (1.0 - math.exp(-second / steered.exhaust)) / steered.shares[1]
    return (one, other), abs(one + other - times[0] - times[1])


def shadows_of(
    ends: tuple[FloatArray, FloatArray],
    leg: Ends,
    since_j2000: float,
    departure: float,
    arrival: float,
) -> tuple[tuple[tuple[float, float], tuple[float, float]], tuple[float, float]]:
    """Shadows a sixteenth of the leg from its ends, and rates of nodes of both ends [rad/s]."""
    rates = (
        float(ephemeris.coasting_node_rate_at(ends[0], departure)),
        float(ephemeris.node_rate_at(ends[1], arrival)),
    )
    sixteenth = (arrival - departure) / 16.0
    node_i = float(ephemeris.node_at(ends[0], departure)) + rates[0] * sixteenth
    node_j = float(ephemeris.node_at(ends[1], arrival)) - rates[1] * sixteenth
    early, late = since_j2000 + departure + sixteenth, since_j2000 + arrival - sixteenth
    return (
        shadow_of(leg.radius_i, leg.inclination_i, node_i, early),
        shadow_of(leg.radius_j, leg.inclination_j, node_j, late),
    ), rates
