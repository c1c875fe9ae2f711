"""Check of low-thrust legs: their arcs, and the cost of the closed form, solved once more.

The form of :mod:`adr_opt.kernels.legs.low_thrust`. Rates are integrated over the ramps. For the
optimum, which ``verify`` asks for, golden sections search, and the times of thrust are repeated
until they stay.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2
from ...kernels.core.compile import kernel
from ...kernels.legs.co_elliptic import TransferRule
from ...kernels.orbits import ephemeris
from ...plan.plan import Leg, LowThrustArc
from ...problem.drives import Drive, since_j2000_s
from ...problem.instance import Instance
from .drift_ends import GOLDEN, Ends, check_times, ends_of
from .violation import LOW_THRUST_TOLERANCE_M_S, TIME_TOLERANCE_S, Violation

FloatArray = npt.NDArray[np.float64]

WINDOWS_DEG = (30.0, 60.0, 90.0)

LONGER_S = 150.0 * DAY_S
"""Legs that are longer may turn the node by a whole turn more or less [s]."""

PER_ECCENTRICITY = 0.6485
"""ΔV of a change of the eccentricity vector, over speed and change."""

ROUNDS, FURTHER = 400, 3
"""Maximum number of rounds in which times of thrust settle, and number of laps beyond the two about
the optimum of free phase that are tried."""

FIGURE_M_S, NODE_M_S, LAPS = 1e-3, 2e-2, 1e-3
"""Tolerances on changes of size and inclination, of the node [m/s], and on laps."""

ROUNDED_M_S = 0.02
"""Rounding of the tips of both arcs' parts in the optimum of free phase: where many splits cost the
same, it is in their middle [m/s]."""

SPEEDS, TILTS = 40, 24
"""Number of intervals of speeds and of inclinations that are searched for the optimum."""

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
    extra : float
        ΔV of each arc for the eccentricity vectors [m/s].
    acceleration, exhaust : float
        [m/s²], [m/s].
    rounded : float
        Rounding of tips [m/s].
    """

    turn: float
    shares: tuple[float, float]
    extra: float
    acceleration: float
    exhaust: float
    rounded: float


def sun_at(since_j2000: float) -> FloatArray:
    """Unit vector to the Sun, in the frame of the equator."""
    days = since_j2000 / DAY_S
    anomaly = math.radians(357.528 + 0.9856003 * days)
    longitude = 280.460 + 0.9856474 * days
    longitude += 1.915 * math.sin(anomaly) + 0.020 * math.sin(2.0 * anomaly)
    along, tilt = math.radians(longitude), math.radians(23.439)
    return np.array(
        [
            math.cos(along),
            math.cos(tilt) * math.sin(along),
            math.sin(tilt) * math.sin(along),
        ]
    )


def shadow_of(
    radius: float, inclination: float, node: float, since_j2000: float
) -> tuple[float, float]:
    """Argument of latitude of the shadow's middle, and half its width [rad]."""
    sun = sun_at(since_j2000)
    toward = np.array([math.cos(node), math.sin(node), 0.0])
    beyond = np.array(
        [
            -math.sin(node) * math.cos(inclination),
            math.cos(node) * math.cos(inclination),
            math.sin(inclination),
        ]
    )
    x, y = float(sun @ toward), float(sun @ beyond)
    # In shadow where the Sun is behind and the distance to its axis is below the Earth's radius.
    least = math.sqrt(max(1.0 - (EARTH_RADIUS_M / radius) ** 2, 0.0)) / math.hypot(x, y)
    return math.atan2(-y, -x), math.acos(least) if least < 1.0 else 0.0


def steering_of(window: float, place: float, middle: float, half: float) -> tuple[float, float]:
    """κ and share of windows about a place and its opposite, without the shadow.

    The circle is cut where a window or the shadow begins or ends, and summed up piece by piece.
    """
    cuts = {0.0, 2.0 * math.pi}
    for centre, width in ((place, window), (place + math.pi, window), (middle, half)):
        for edge in (centre - width, centre + width):
            cuts.add(edge % (2.0 * math.pi))
    share = mean = 0.0
    edges = sorted(cuts)
    for low, high in pairwise(edges):
        inside = 0.5 * (low + high)
        away = abs(math.remainder(inside - place, math.pi))
        dark = abs(math.remainder(inside - middle, 2.0 * math.pi)) < half
        if away < window and not dark:
            share += high - low
            mean += abs(math.sin(high - place) - math.sin(low - place))
    return share / mean, share / (2.0 * math.pi)


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
        held = min(max(float(first[1]), low), high)
        others = np.array([0, 2])
        less = wanted - held * carried[:, 1]
        part = carried[:, others]
        solved = np.linalg.solve(np.eye(2) + part.T @ part, part.T @ less)
        first = np.array([solved[0], held, solved[1]])
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
    """Laps gained beyond those that meet the target: whole where it is met."""
    start, end = math.sqrt(MU_M3_S2 / ends.radius_i), math.sqrt(MU_M3_S2 / ends.radius_j)
    coasting = ends.span - ends.approach - times[0] - times[1]
    gained = times[0] * ramp(ends, start, speed, 0.0, 0.0)[1]
    gained += coasting * ramp(ends, speed, speed, 0.0, 0.0)[1]
    gained += times[1] * ramp(ends, speed, end, 0.0, 0.0)[1]
    return float((gained - ends.ahead) / (2.0 * math.pi))


@kernel
def node_to_turn(ends: Ends, times: tuple[float, float], speed: float, tilt: float) -> float:
    """What the arcs have to turn of the node, beyond its motion on ramps and drift [rad]."""
    start, end = math.sqrt(MU_M3_S2 / ends.radius_i), math.sqrt(MU_M3_S2 / ends.radius_j)
    turned = ends.inclination_i + tilt / ends.speed
    coasting = ends.span - ends.approach - times[0] - times[1]
    node = ends.node - ends.target_rate * ends.approach
    node -= times[0] * ramp(ends, start, speed, ends.inclination_i, turned)[0]
    node -= coasting * ramp(ends, speed, speed, turned, turned)[0]
    node -= times[1] * ramp(ends, speed, end, turned, ends.inclination_j)[0]
    return float(node)


@kernel
def parts(
    ends: Ends, steered: Steered, times: tuple[float, float], speed: float, tilt: float
) -> tuple[float, float, float]:
    """What is least, and ΔV of both arcs with eccentricities [m/s].

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
    form = math.hypot(steered.turn * along, both)
    total = 4.0 * ends.speed * math.sin(min(0.25 * form / ends.speed, 0.5 * math.pi))
    first = total * (one / both if both > 0.0 else 0.5)
    return form, first + steered.extra, total - first + steered.extra


@kernel
def least_tilt(
    ends: Ends, steered: Steered, times: tuple[float, float], speed: float, about: float, far: float
) -> float:
    """The best change of inclination by the first arc, from some about one to golden section."""
    step, best, least = 2.0 * far / TILTS, 0, math.inf
    for number in range(TILTS + 1):
        found = parts(ends, steered, times, speed, about - far + number * step)[0]
        if found < least:
            best, least = number, found
    low, high = about - far + (best - 1) * step, about - far + (best + 1) * step
    one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_one = parts(ends, steered, times, speed, one)[0]
    at_other = parts(ends, steered, times, speed, other)[0]
    while high - low > 1e-4:
        if at_one < at_other:
            high, other, at_other = other, one, at_one
            one = high - GOLDEN * (high - low)
            at_one = parts(ends, steered, times, speed, one)[0]
        else:
            low, one, at_one = one, other, at_other
            other = low + GOLDEN * (high - low)
            at_other = parts(ends, steered, times, speed, other)[0]
    return 0.5 * (low + high)


@kernel
def settled(times: tuple[float, float], steered: Steered, first: float, second: float):  # type: ignore[no-untyped-def]
    """Times of thrust for the ΔV of both arcs, and how far they are from those before [s]."""
    flow = steered.exhaust / steered.acceleration
    lighter = math.exp(-first / steered.exhaust)
    one = flow * (1.0 - lighter) / steered.shares[0]
    other = flow * lighter * (1.0 - math.exp(-second / steered.exhaust)) / steered.shares[1]
    return (one, other), abs(one + other - times[0] - times[1])


@kernel
def best_speed(
    ends: Ends, steered: Steered, times: tuple[float, float], low: float, high: float, about: float,
    far: float,
) -> tuple[float, float]:  # fmt: skip
    """Speed and change of inclination of the cheapest drift orbit with a free phase [m/s]."""
    step, best, least = (high - low) / SPEEDS, 0, math.inf
    for number in range(SPEEDS + 1):
        speed = low + number * step
        tilt = least_tilt(ends, steered, times, speed, about, far)
        found = parts(ends, steered, times, speed, tilt)[0]
        if found < least:
            best, least = number, found
    low, high = max(low, low + (best - 1) * step), min(high, low + (best + 1) * step)
    while high - low > 1e-3:
        one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        at_one = least_tilt(ends, steered, times, one, about, far)
        at_other = least_tilt(ends, steered, times, other, about, far)
        if (
            parts(ends, steered, times, one, at_one)[0]
            < parts(ends, steered, times, other, at_other)[0]
        ):
            high = other
        else:
            low = one
    speed = 0.5 * (low + high)
    return speed, least_tilt(ends, steered, times, speed, about, far)


@kernel
def cost_of(ends: Ends, steered: Steered, sharp: Steered, slowest: float, fastest: float) -> float:
    """ΔV of the leg with given places of thrust; infinite if there is no time for it [m/s].

    Parameters
    ----------
    steered, sharp : Steered
        With rounded tips and without.
    slowest, fastest : float
        Circular speeds at the altitude limits [m/s].
    """
    room, end = ends.span - ends.approach, math.sqrt(MU_M3_S2 / ends.radius_j)
    close = 1e-6 * ends.span
    times, speed, tilt = (0.0, 0.0), end, 0.0
    far, low, high = 0.5 * ends.speed, slowest, fastest
    for _ in range(ROUNDS):
        speed, tilt = best_speed(ends, steered, times, low, high, tilt, far)
        _, first, second = parts(ends, steered, times, speed, tilt)
        times, change = settled(times, steered, first, second)
        if times[0] + times[1] > room:
            return math.inf
        if change < 10.0 * close:
            break
        # From here on it is near.
        far = 100.0
        low, high = max(slowest, speed - 60.0), min(fastest, speed + 60.0)
    least = math.inf
    about = math.floor(laps_at(ends, times, speed))
    for laps in range(about - FURTHER, about + FURTHER + 2):
        these, there = times, tilt
        for _ in range(ROUNDS):
            below, above = slowest, fastest
            if not laps_at(ends, these, below) <= laps <= laps_at(ends, these, above):
                break
            while above - below > 1e-8:
                middle = 0.5 * (below + above)
                if laps_at(ends, these, middle) > laps:
                    above = middle
                else:
                    below = middle
            there = least_tilt(ends, sharp, these, below, there, 100.0)
            _, first, second = parts(ends, sharp, these, below, there)
            these, change = settled(these, sharp, first, second)
            if these[0] + these[1] > room:
                break
            if change < close:
                least = min(least, first + second)
                break
    return least


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


def low_thrust_cost(
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    since_j2000: float,
    thrust: tuple[float, float],
    departure: float,
    arrival: float,
) -> float:
    """ΔV of a low-thrust leg between two times, by the best of its windows [m/s].

    Parameters
    ----------
    ends : (columns + 1,) float64, (columns,) float64
        The origin as it is left, with the rate of its node after that, and the destination.
    since_j2000 : float
        The epoch [s].
    thrust : (float, float)
        Acceleration at departure [m/s²] and exhaust speed [m/s].
    """
    nearer = ends_of(*ends, rule, departure, arrival)
    slowest, fastest = (
        math.sqrt(MU_M3_S2 / radius) for radius in (rule.max_radius, rule.min_radius)
    )
    extra = PER_ECCENTRICITY * 2.0 * nearer.shape
    shadows, rates = shadows_of(ends, nearer, since_j2000, departure, arrival)
    least = math.inf
    turns = (0.0, -1.0, 1.0) if arrival - departure > LONGER_S else (0.0,)
    for turn in turns:
        more = 2.0 * math.pi * turn
        leg = nearer._replace(
            node=nearer.node + more, ahead=nearer.ahead + nearer.cosine * more, shape=0.0
        )
        places, part = places_of(leg, rates, (rule.min_radius, rule.max_radius))
        for window in WINDOWS_DEG:
            ways = [
                steering_of(math.radians(window), float(place), *shadow)
                for place, shadow in zip(places, shadows, strict=True)
            ]
            turning = part * ways[0][0] + (1.0 - part) * ways[1][0]
            steered = Steered(turning, (ways[0][1], ways[1][1]), extra, *thrust, ROUNDED_M_S)
            sharp = steered._replace(rounded=0.0)
            found = float(cost_of(leg, steered, sharp, slowest, fastest))
            if found == math.inf:  # there may be an optimum on either side, and no leg with one
                there = math.sqrt(MU_M3_S2 / leg.radius_i)
                found = min(
                    float(cost_of(leg, steered, sharp, slowest, there)),
                    float(cost_of(leg, steered, sharp, there, fastest)),
                )
            least = min(least, found)
    return least


def check_low_thrust(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    drive: Drive | None,
    number: int,
    leg: Leg,
    free: float,
) -> Generator[Violation, None, tuple[float, float]]:
    """Check that the arcs of a low-thrust leg lead to its target, for the heaviest chaser.

    A leg need not be the cheapest of all laps; it has to take what its arcs do.

    Parameters
    ----------
    ends : (columns + 1,) float64, (columns,) float64
        The origin as it is left, with the rate of its node after that, and the destination.
    drive : Drive or None
        Of the chaser.
    """
    as_stated = leg.arrival_s, leg.delta_v_m_s
    if drive is None:
        yield Violation(number, "kind", "is of low thrust, but its chaser has none")
        return as_stated
    if not (yield from check_times(instance, number, leg, free)):
        return as_stated
    yield from _check_arcs(instance, ends, rule, drive, number, leg)
    return as_stated


def _check_arcs(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    drive: Drive,
    number: int,
    leg: Leg,
) -> Iterator[Violation]:
    """Check that the arcs of a leg lead to its target, with the ΔV and in the time of the leg."""
    arcs = leg.manoeuvres or ()
    if len(arcs) != 2:
        yield Violation(number, "manoeuvres", "must have two arcs")
        return
    for off, most, what in _errors(instance, ends, rule, drive, leg, (arcs[0], arcs[1])):
        if not abs(off) <= most:
            yield Violation(number, "manoeuvres", f"{what} {off:.6g}")
            return


def _errors(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    drive: Drive,
    leg: Leg,
    arcs: tuple[LowThrustArc, LowThrustArc],
) -> Iterator[tuple[float, float, str]]:
    """Errors of a leg's arcs, how large they may be, and what they are of."""
    nearer = ends_of(*ends, rule, leg.departure_s, leg.arrival_s)
    one, other = arcs
    yield one.start_s - leg.departure_s, TIME_TOLERANCE_S, "the first arc begins late by [s]"
    met = leg.arrival_s - nearer.approach
    yield other.end_s - met, TIME_TOLERANCE_S, "the second arc ends late by [s]"
    yield min(other.start_s - one.end_s, 0.0), TIME_TOLERANCE_S, "the arcs overlap by [s]"
    start, end = math.sqrt(MU_M3_S2 / nearer.radius_i), math.sqrt(MU_M3_S2 / nearer.radius_j)
    sizes = start - end - one.size_m_s - other.size_m_s
    yield sizes, FIGURE_M_S, "of the size is left [m/s]"
    tilts = [math.radians(arc.inclination_deg) for arc in arcs]
    left = nearer.inclination_j - nearer.inclination_i - sum(tilts)
    yield nearer.speed * left, FIGURE_M_S, "of the inclination is left [m/s]"
    nodes = [math.radians(arc.raan_deg) for arc in arcs]
    times = one.end_s - one.start_s, other.end_s - other.start_s
    speed, tilt = start - one.size_m_s, nearer.speed * tilts[0]
    wanted = float(node_to_turn(nearer, times, speed, tilt))
    turns = round((sum(nodes) - wanted) / (2.0 * math.pi))
    still = wanted + 2.0 * math.pi * turns - sum(nodes)
    yield nearer.speed * nearer.sine * still, NODE_M_S, "of the node is left [m/s]"
    whole = nearer._replace(
        node=nearer.node + 2.0 * math.pi * turns,
        ahead=nearer.ahead + nearer.cosine * 2.0 * math.pi * turns,
    )
    laps = float(laps_at(whole, times, speed))
    yield laps - round(laps), LAPS, "laps from a whole number:"
    steered = _steered(instance, ends, rule, drive, leg, whole, one.window_deg)
    forms = [
        math.hypot(
            arc.size_m_s, steered.turn * nearer.speed * math.hypot(tilted, nearer.sine * turned)
        )
        for arc, tilted, turned in zip(arcs, tilts, nodes, strict=True)
    ]
    form = sum(forms)
    total = 4.0 * nearer.speed * math.sin(min(0.25 * form / nearer.speed, 0.5 * math.pi))
    costs = [
        total * (part / form if form > 0.0 else 0.5) + PER_ECCENTRICITY * 2.0 * nearer.shape
        for part in forms
    ]
    for arc, cost in zip(arcs, costs, strict=True):
        yield arc.delta_v_m_s - cost, LOW_THRUST_TOLERANCE_M_S, "ΔV of an arc is off by [m/s]"
    stated = one.delta_v_m_s + other.delta_v_m_s - leg.delta_v_m_s
    yield stated, FIGURE_M_S, "the arcs' ΔV is more than that of the leg by [m/s]"
    (first, second), _ = settled(times, steered, costs[0], costs[1])
    for time, needed in zip(times, (first, second), strict=True):
        yield time - needed, 1e-5 * nearer.span, "an arc takes longer than its thrust by [s]"


def _steered(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    drive: Drive,
    leg: Leg,
    whole: Ends,
    window_deg: float,
) -> Steered:
    """Places of thrust of a leg with one width of windows."""
    shadows, rates = shadows_of(
        ends, whole, since_j2000_s(instance.epoch), leg.departure_s, leg.arrival_s
    )
    places, part = places_of(whole, rates, (rule.min_radius, rule.max_radius))
    ways = [
        steering_of(math.radians(window_deg), float(place), *shadow)
        for place, shadow in zip(places, shadows, strict=True)
    ]
    turn = part * ways[0][0] + (1.0 - part) * ways[1][0]
    return Steered(
        turn, (ways[0][1], ways[1][1]), 0.0, drive.thrust_n / drive.heaviest_kg, drive.exhaust_m_s,
        0.0,
    )  # fmt: skip


def cost_between(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    drive: Drive,
    departure: float,
    arrival: float,
    mass_kg: float | None = None,
) -> float:
    """ΔV of a low-thrust leg between two times, of the heaviest chaser or one of a mass [m/s]."""
    mass_kg = drive.heaviest_kg if mass_kg is None else mass_kg
    return low_thrust_cost(
        ends, rule, since_j2000_s(instance.epoch), (drive.thrust_n / mass_kg, drive.exhaust_m_s),
        departure, arrival,
    )  # fmt: skip
