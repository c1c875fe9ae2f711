"""The closed form of low-thrust legs against optimised transfers, other masses, and its speed."""

from __future__ import annotations

import math
import time
from statistics import median
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize
from tables import head, row

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2, OBLATENESS_M2
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import drift_pair, low_thrust_split, low_thrust_windows
from adr_opt.kernels.legs import low_thrust as split_legs
from adr_opt.kernels.legs.low_thrust_arcs import Thrust, weighted
from adr_opt.kernels.legs.low_thrust_windows import WINDOWS_RAD, prepare
from adr_opt.problem.orbit import Orbit

FloatArray = npt.NDArray[np.float64]

EXHAUST_M_S = 1500.0 * 9.80665

PARTS = 4
"""Parts of constant direction, half of them before the drift."""

STEPS = 24
"""Steps of the integration of each part."""


class Pair(NamedTuple):
    """A drawn transfer.

    Elements of both bodies at departure (radius [m], inclination and node [rad]), span [s], and
    acceleration at departure [m/s²].
    """

    first: tuple[float, float, float]
    second: tuple[float, float, float]
    span: float
    acceleration: float


def drawn(rng: np.random.Generator) -> Pair:
    """A pair whose node is made up for at the end of the span by up to 6°."""
    radius = EARTH_RADIUS_M + rng.uniform(650e3, 950e3)
    inclination = math.radians(rng.choice([71.0, 82.5, 86.4, 98.0]))
    span = rng.uniform(20.0, 160.0) * DAY_S
    other = radius + rng.uniform(-60e3, 60e3), inclination + math.radians(rng.uniform(-0.2, 0.2))
    apart = math.radians(rng.uniform(-6.0, 6.0))
    ends = (radius, inclination, 0.0), (*other, apart)
    return Pair(*ends, span, 10.0 ** rng.uniform(-4.0, math.log10(5e-4)))


def body_row(
    body: tuple[float, float, float],
    latitude_deg: float,
    *,
    eccentricity: float = 0.0,
    perigee_deg: float = 0.0,
) -> FloatArray:
    """The body_row of a body, as kernels take it."""
    radius, inclination, node = body
    orbit = Orbit(
        semi_major_axis_m=radius,
        eccentricity=eccentricity,
        inclination_deg=math.degrees(inclination),
        raan_deg=math.degrees(node) % 360.0,
        argument_of_perigee_deg=perigee_deg,
        true_anomaly_deg=latitude_deg,
    )
    return np.array(orbit.row(OBLATENESS_M2))


@kernel
def rates(speed, inclination, mass, push, yaw, place, turn):
    """Averaged rates of speed, inclination and node; ``push`` is the thrust's share by mass."""
    pulled = -1.5 * OBLATENESS_M2 * speed**7 / MU_M3_S2**3 * math.cos(inclination)
    aside = push / mass * math.sin(yaw) / (turn * speed)
    return (
        -push / mass * math.cos(yaw),
        aside * math.cos(place),
        aside * math.sin(place) / math.sin(inclination) + pulled,
    )


@kernel
def flown(start, span, push, turn, times, yaws, places):
    """Speed, inclination and node at the end of parts of thrust with a drift between them."""
    speed, inclination, node = start
    mass = 1.0
    half = times.size // 2
    for part in range(times.size + 1):
        thrusting = part != half
        number = part if part < half else part - 1
        length = times[number] if thrusting else span - times.sum()
        force = push if thrusting else 0.0
        step = length / STEPS
        for _ in range(STEPS):
            # Of Runge and Kutta, the fourth order.
            state = (speed, inclination, node)
            total = np.zeros(3)
            slope = (0.0, 0.0, 0.0)
            for stage in range(4):
                share = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
                slope = rates(
                    state[0] + share * step * slope[0],
                    state[1] + share * step * slope[1],
                    mass - share * step * force / EXHAUST_M_S,
                    force,
                    yaws[number],
                    places[number],
                    turn,
                )
                weight = (1.0 if stage in (0, 3) else 2.0) / 6.0
                for component in range(3):
                    total[component] += weight * slope[component]
            speed, inclination, node = (
                speed + step * total[0],
                inclination + step * total[1],
                (node + step * total[2]),
            )
            mass -= step * force / EXHAUST_M_S
    return speed, inclination, node, mass


def optimum(
    pair: Pair, thrust: Thrust, window: float, guess: low_thrust_split.LowThrustSplit, node: float
) -> float:
    """Least ΔV of the averaged equations, from the closed form; infinite if none was found [m/s].

    Parameters
    ----------
    window : float
        η [rad].
    node : float
        κ V sin i times the node that the arcs turn in all [m/s].
    """
    turn, share = window / math.sin(window), 2.0 * window / math.pi
    start = math.sqrt(MU_M3_S2 / pair.first[0]), *pair.first[1:]
    end_speed = math.sqrt(MU_M3_S2 / pair.second[0])
    rate = -1.5 * OBLATENESS_M2 * end_speed**7 / MU_M3_S2**3 * math.cos(pair.second[1])
    goal = np.array([end_speed, pair.second[1], pair.second[2] + rate * pair.span])
    push = thrust.acceleration * share
    sine = math.sin(pair.second[1])

    def parts(unknown: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        times = unknown[:PARTS] * pair.span
        return times, unknown[PARTS : 2 * PARTS], unknown[2 * PARTS :]

    def missed(unknown: FloatArray) -> FloatArray:
        speed, inclination, node, _ = flown(start, pair.span, push, turn, *parts(unknown))
        off = np.array([speed, inclination, node]) - goal
        return off * np.array([1.0, end_speed, end_speed * sine]) / 100.0

    def cost(unknown: FloatArray) -> float:
        return float(push * unknown[:PARTS].sum() * pair.span) / 100.0

    rest = start[0] - end_speed - guess.climb
    tilt = turn * end_speed * (pair.second[1] - pair.first[1]) - guess.tilt
    yaws, places, times = [], [], []
    for climb, tilted, along, length in (
        (guess.climb, guess.tilt, 0.5 * node, guess.times.first),
        (rest, tilt, 0.5 * node, guess.times.second),
    ):
        turned = math.hypot(tilted, along)
        for _ in range(PARTS // 2):
            times.append(2.0 * length / PARTS / pair.span)
            yaws.append(math.atan2(turned, climb))
            places.append(math.atan2(along, tilted))
    best = math.inf
    limits = [(0.0, 1.0)] * PARTS + [(-2.0 * math.pi, 2.0 * math.pi)] * (2 * PARTS)
    constraints = (
        {"type": "eq", "fun": missed},
        {"type": "ineq", "fun": lambda unknown: 1.0 - unknown[:PARTS].sum()},
    )
    for begin in (1.0, 0.8):
        found = minimize(
            cost,
            np.array([begin * t + 1e-4 for t in times] + yaws + places),
            method="SLSQP",
            bounds=limits,
            constraints=constraints,
            options={"maxiter": 400, "ftol": 1e-9},
        )
        if np.abs(missed(found.x)).max() < 1e-5:
            mass = 1.0 - cost(found.x) * 100.0 / EXHAUST_M_S
            best = min(best, -EXHAUST_M_S * math.log(mass))
    return best


@kernel
def free(pair, thrust, window, span):
    """The closed form with a free phase, and κ V sin i times the node that its arcs turn [m/s]."""
    drift = pair.drift
    task = drift_pair.task_of(drift, 0.0, span, drift_pair.ALIKE)
    steers = low_thrust_windows.steering(low_thrust_windows.places(pair, task, 0.0, span), window)
    found, _ = low_thrust_split.free_split(weighted(drift, steers.turn), task, thrust, steers)
    known = task.lag + drift.node_rate_i * (span - 0.5 * found.times.first)
    known -= drift.node_rate_j * 0.5 * found.times.second
    coasting = span - 0.5 * (found.times.first + found.times.second)
    speed = drift.speed_i - found.climb
    pull = -1.5 * drift.oblateness * speed**7 / MU_M3_S2**3 * coasting
    known -= pull * math.cos(drift.inclination_i + found.tilt / (steers.turn * drift.linear.speed))
    return found, steers.turn * drift.linear.speed * drift.linear.sine * known


@kernel
def repeated(pair, thrust, departures, arrivals):
    """Sum of the ΔV of all legs between given times that can be flown."""
    total = 0.0
    for departure in departures:
        for arrival in arrivals:
            found = split_legs.delta_v(pair, thrust, departure, arrival)
            if found < math.inf:
                total += found
    return total


@kernel
def bound_and_costs(pair, lightest, masses, departure, arrival):
    """The lower bound for all masses, and the least ΔV and its time of thrust for some of them."""
    bound = split_legs.bound_below(pair, lightest, departure, arrival, math.inf)
    least, thrusting = math.inf, 0.0
    for mass in masses:
        thrust = Thrust(lightest.acceleration / mass, lightest.exhaust)
        found = split_legs.leg_between(pair, thrust, departure, arrival).split
        if found.delta_v < least:
            least, thrusting = found.delta_v, found.times.first + found.times.second
    return bound, least, thrusting


def low_thrust(pairs: int = 200, bounds: int = 200_000, repeats: int = 15) -> None:
    """Low-thrust legs: the closed form against optimised transfers, masses, bounds, and speed.

    Pairs of circles are drawn 650 to 950 km high, up to 60 km, 0.2° and 6° of node apart, with 20
    to 160 days and an acceleration of 1 to 5 · 10⁻⁴ m/s². For each the closed form with a free
    phase, with thrust in windows of ±90°, ±60° and ±30°, stands against the least ΔV of the
    averaged equations of motion: two arcs of two parts each, all of whose durations and directions
    are free.
    """
    rule = adr_opt.generate("tiny", 0).replace(dynamics="j2").transfer_rule()
    _accuracy(rule, pairs)
    _masses(rule, pairs)
    _bounds(rule, bounds)
    _speed(rule, repeats)


def _accuracy(rule: NamedTuple, number: int) -> None:
    """Print the closed form against the optimum, by windows of thrust."""
    head("window", "legs", "total", "mean absolute error", "largest", "no leg")
    totals = np.zeros(2)
    for window in WINDOWS_RAD:
        rng, said, true, none = np.random.default_rng(11), [], [], 0
        for _ in range(number):
            pair = drawn(rng)
            thrust = Thrust(pair.acceleration, EXHAUST_M_S)
            bodies = body_row(pair.first, 0.0), body_row(pair.second, rng.uniform(0.0, 360.0))
            made = prepare(*bodies, rule._replace(approach_revolutions=0.0), math.nan, 0.0)
            split, node = free(made, thrust, window, pair.span)
            if not sum(split.times) < pair.span:  # infinite if there is no leg
                none += 1
                continue
            best = optimum(pair, thrust, window, split, float(node))
            if math.isfinite(best):
                said.append(split.delta_v)
                true.append(best)
        off = np.array(said) / np.array(true) - 1.0
        totals += sum(said), sum(true)
        row(
            f"±{math.degrees(window):.0f}°",
            len(said),
            f"{sum(said) / sum(true) - 1.0:+.2%}",
            f"{np.abs(off).mean():.2%}",
            f"{np.abs(off).max():.1%}",
            none,
        )
    print(f"\nAll: {totals[0] / totals[1] - 1.0:+.2%}.")


def _masses(rule: NamedTuple, number: int) -> None:
    """Print how much cheaper legs of lighter chasers are, of those that both can fly."""
    head("mass", "legs", "total", "largest saving", "no leg if heavier")
    for mass in (0.95, 0.9, 0.8):
        rng, costs = np.random.default_rng(13), []
        for _ in range(number):
            pair = drawn(rng)
            bodies = body_row(pair.first, 0.0), body_row(pair.second, rng.uniform(0.0, 360.0))
            made = prepare(*bodies, rule, rng.uniform(0.0, 365.0) * DAY_S, 0.0)
            thrusts = (Thrust(pair.acceleration / each, EXHAUST_M_S) for each in (1.0, mass))
            costs.append([split_legs.delta_v(made, each, 0.0, pair.span) for each in thrusts])
        known = np.array(costs)
        both = known[np.isfinite(known).all(axis=1)]
        least = both.min(axis=1)  # a lighter chaser may throttle
        row(
            f"{mass:.0%}",
            len(both),
            f"{least.sum() / both[:, 0].sum() - 1.0:+.2%}",
            f"{(least / both[:, 0] - 1.0).min():+.1%}",
            int((np.isinf(known[:, 0]) & np.isfinite(known[:, 1])).sum()),
        )


def _bounds(rule: NamedTuple, number: int) -> None:
    """Print how many lower bounds some chaser undercuts, over pairs of all kinds."""
    rng, legs, below, burning = np.random.default_rng(17), 0, [], []
    for _ in range(number):
        inclination, raan = float(rng.choice([0.9, 1.24, 1.5, 1.71])), rng.uniform(-3.0, 3.0)
        apart = 0.01 * rng.normal(), 0.05 * rng.normal()
        bodies = [
            body_row(
                (EARTH_RADIUS_M + rng.uniform(500e3, 1200e3), inclination + tilt, raan + turn),
                rng.uniform(0.0, 360.0),
                eccentricity=rng.uniform(0.0, 0.01) * rng.integers(2),
                perigee_deg=rng.uniform(0.0, 360.0),
            )
            for tilt, turn in ((0.0, 0.0), apart)
        ]
        departure, span = rng.uniform(0.0, 700.0) * DAY_S, 10.0 ** rng.uniform(0.5, 2.5) * DAY_S
        epoch = float(rng.choice([math.nan, rng.uniform(-1e9, 1e9)]))
        lightest = Thrust(10.0 ** rng.uniform(-4.3, -3.0), EXHAUST_M_S)
        masses = np.linspace(1.0, rng.uniform(1.0, 2.0), 7)
        bound, least, burns = bound_and_costs(
            prepare(*bodies, rule, epoch, 0.0), lightest, masses, departure, departure + span
        )
        legs += least < math.inf
        if least < bound:
            below.append(1.0 - least / bound)
            burning.append(burns / span)
    print(
        f"\n{number} drawn pairs, seven masses: {legs} have a leg, {len(below)} one below the "
        f"lower bound, by {max(below, default=0.0):.1%} at most, with thrust on for at least "
        f"{min(burning, default=0.0):.0%} of the time."
    )


def _speed(rule: NamedTuple, repeats: int) -> None:
    """Print the time of a connection with all its windows and a whole number of laps."""
    departures, arrivals = np.linspace(0.0, 60.0, 61) * DAY_S, np.linspace(80.0, 200.0, 61) * DAY_S
    head("thrust in the shadow", "a leg, the best of three windows, median of pairs")
    for on, epoch in (("on", math.nan), ("off", 0.0)):
        rng, found = np.random.default_rng(5), []
        for _ in range(repeats):
            pair = drawn(rng)
            thrust = Thrust(pair.acceleration, EXHAUST_M_S)
            bodies = body_row(pair.first, 0.0), body_row(pair.second, rng.uniform(0.0, 360.0))
            made = prepare(*bodies, rule, epoch, 0.0)
            repeated(made, thrust, departures[:1], arrivals[:1])
            begun = time.process_time()
            repeated(made, thrust, departures, arrivals)
            found.append((time.process_time() - begun) / (departures.size * arrivals.size))
        row(on, f"{median(found) * 1e6:.2f} µs")
