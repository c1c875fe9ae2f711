"""Least distance of an approach to its target if a burn is missed, by the judge's own flight.

Chaser and target fall freely in the field of a flattened Earth, whatever the instance's dynamics;
those of a refined plan in its own field. A chaser that misses a burn makes none after it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from ...common.constants import MU_M3_S2, OBLATENESS_M2
from ...kernels.orbits import elements
from ...plan.plan import Plan
from ...problem.approach import LAPS_AFTER, approach_of
from ...problem.instance import Instance
from .violation import Violation

Array = npt.NDArray[np.float64]

STEPS = 90
"""Integration steps per revolution."""

SPARE_M = 1.0
"""Tolerance on the distance kept, for the step length and the rounding of burns [m]."""

CAPTURE_REVOLUTIONS = 0.5
"""Last part of an approach, into the target."""


def _pull(position: Array, oblateness_m2: float) -> Array:
    square = np.sum(position**2, axis=-1, keepdims=True)
    polar = position[..., 2:] ** 2 / square
    flat = 1.5 * oblateness_m2 / square
    shares = np.concatenate([1.0 - 5.0 * polar, 1.0 - 5.0 * polar, 3.0 - 5.0 * polar], axis=-1)
    pulled: Array = -MU_M3_S2 * position / square**1.5 * (1.0 + flat * shares)
    return pulled


def _rates(states: Array, oblateness_m2: float) -> Array:
    return np.concatenate([states[..., 3:], _pull(states[..., :3], oblateness_m2)], axis=-1)


def _moved(states: Array, step_s: Array | float, oblateness_m2: float = OBLATENESS_M2) -> Array:
    """The states a step later, by the classical Runge–Kutta method."""
    first = _rates(states, oblateness_m2)
    second = _rates(states + 0.5 * step_s * first, oblateness_m2)
    third = _rates(states + 0.5 * step_s * second, oblateness_m2)
    fourth = _rates(states + step_s * third, oblateness_m2)
    moved: Array = states + step_s / 6.0 * (first + 2.0 * (second + third) + fourth)
    return moved


Burning = Callable[[int, Array], Array]
"""Impulses [m/s] of a burn by its number and the states before it, (..., approaches, 6)."""


def flights(
    target: Array,
    chaser: Array,
    times_s: Array,
    burn: Burning,
    until_s: Array,
    oblateness_m2: float = OBLATENESS_M2,
) -> Iterator[tuple[Array, Array, Array]]:
    """Fly approaches with each burn missed in turn, together with all burns after it.

    Parameters
    ----------
    target, chaser : (approaches, 6) float64
        States at the stand-offs [m, m/s].
    times_s : (burns, approaches) float64
        Of the burns, from the stand-off, in order [s].
    burn : callable
    until_s : (approaches,) float64
        When flights end [s].
    oblateness_m2 : float
        J2 R², 0 in two-body motion [m²].

    Yields
    ------
    now_s : (approaches,) float64
    target : (approaches, 6) float64
    flown : (burns + 1, approaches, 6) float64
        The chasers that miss each burn, and those that miss none.
    """
    count = len(times_s)
    flown, now = np.repeat(chaser[None], count + 1, axis=0), np.zeros(len(target))
    axis = 1.0 / (
        2.0 / np.sqrt(np.sum(target[:, :3] ** 2, axis=1))
        - np.sum(target[:, 3:] ** 2, axis=1) / MU_M3_S2
    )
    longest = math.tau * np.sqrt(axis**3 / MU_M3_S2) / STEPS
    for at, until in enumerate([*times_s, until_s]):
        steps = max(1, math.ceil(float(((until - now) / longest).max())))
        step = ((until - now) / steps)[:, None]
        for number in range(steps):
            yield now + number * step[:, 0], target, flown
            target = _moved(target, step, oblateness_m2)
            flown = _moved(flown, step, oblateness_m2)
        now = until
        if at < count:
            flown[at + 1 :, :, 3:] += burn(at, flown[at + 1 :])
    yield now, target, flown


def nearest_m(
    target: Array,
    chaser: Array,
    times_s: Array,
    burn: Burning,
    revolution_s: Array,
    oblateness_m2: float = OBLATENESS_M2,
) -> Array:
    """Least distances of :func:`flights` from the targets, shape (burns, approaches) [m].

    Up to :data:`.approach.LAPS_AFTER` revolutions after the missed burn.
    """
    least = np.full(times_s.shape, np.inf)
    ends = times_s + LAPS_AFTER * revolution_s
    for now, there, flown in flights(target, chaser, times_s, burn, ends[-1], oblateness_m2):
        apart = np.sqrt(np.sum((flown[:-1, :, :3] - there[:, :3]) ** 2, axis=-1))
        least = np.where(now <= ends, np.minimum(least, apart), least)
    return least


def rule_of(rows: Array, motion: Array) -> Burning:
    """Burns of an approach in the chaser's axes: along and across the velocity, and normal.

    Parameters
    ----------
    rows : (burns, 5) float64
        As of :class:`.approach.Approach`.
    motion : (approaches, 2) float64
        Mean motions [rad/s] and semi-major axes [m].
    """
    n, speed = motion[:, :1], motion[:, :1] * motion[:, 1:]

    def burn(number: int, states: Array) -> Array:
        _, outward, ahead, across, _ = rows[number]
        size = np.sqrt(np.sum(states[..., 3:] ** 2, axis=-1, keepdims=True))
        along = states[..., 3:] / size
        normal = np.cross(states[..., :3], states[..., 3:])
        normal /= np.sqrt(np.sum(normal**2, axis=-1, keepdims=True))
        made: Array = n * (
            outward * np.cross(along, normal) + ahead * speed / size * along + across * normal
        )
        return made

    return burn


def begun(orbits: Array, standoff_m: float) -> tuple[Array, Array, Array]:
    """States of targets and of chasers at rest behind them, with mean motions and axes.

    Parameters
    ----------
    orbits : (approaches, 6) float64
        Semi-major axis [m], eccentricity, inclination, node, argument of perigee and mean anomaly
        [rad] at the stand-off.
    standoff_m : float

    Returns
    -------
    target, chaser : (approaches, 6) float64
    motion : (approaches, 2) float64
    """
    axis, e, tilt, node, perigee, mean = orbits.T
    n = np.sqrt(MU_M3_S2 / axis**3)
    eccentric = mean.copy()
    for _ in range(30):
        eccentric -= (eccentric - e * np.sin(eccentric) - mean) / (1.0 - e * np.cos(eccentric))
    minor, rate = np.sqrt(1.0 - e * e), n / (1.0 - e * np.cos(eccentric))
    c, s = np.cos(node), np.sin(node)
    to_perigee = np.stack(
        [
            c * np.cos(perigee) - s * np.sin(perigee) * np.cos(tilt),
            s * np.cos(perigee) + c * np.sin(perigee) * np.cos(tilt),
            np.sin(perigee) * np.sin(tilt),
        ]
    )
    beside = np.stack(
        [
            -c * np.sin(perigee) - s * np.cos(perigee) * np.cos(tilt),
            -s * np.sin(perigee) + c * np.cos(perigee) * np.cos(tilt),
            np.cos(perigee) * np.sin(tilt),
        ]
    )
    x, y = axis * (np.cos(eccentric) - e), axis * minor * np.sin(eccentric)
    u = -axis * np.sin(eccentric) * rate
    v = axis * minor * np.cos(eccentric) * rate
    target = np.concatenate([x * to_perigee + y * beside, u * to_perigee + v * beside]).T
    delay = standoff_m / np.sqrt(np.sum(target[:, 3:] ** 2, axis=1))
    return target, _moved(target, -delay[:, None]), np.stack([n, axis], axis=1)


def check_missed(instance: Instance, plan: Plan) -> Iterator[Violation]:
    """Check the approach of each leg with each of its burns missed in turn."""
    settings, bodies = instance.transfer, instance.names
    legs = [leg for route in plan.routes for leg in route.legs]
    flown = [
        (number, leg.destination, burn.time_s)
        for number, leg in enumerate(legs, start=1)
        for burn in [burn for burn in leg.burns if burn.phase == "approach"][:1]
        if leg.destination in bodies
    ]
    if settings.approach == "half-lap" or not flown:
        return
    rows, orbits = approach_of(settings).burns, instance.orbits()
    judged = int(np.sum(rows[:, 0] <= rows[-1, 0] - CAPTURE_REVOLUTIONS))
    found = [elements_at(orbits[bodies.index(name)], time_s) for _, name, time_s in flown]
    target, chaser, motion = begun(np.array(found), settings.standoff_m)
    revolution = math.tau / motion[:, 0]
    times = rows[:judged, :1] * revolution
    least = nearest_m(target, chaser, times, rule_of(rows, motion), revolution)
    for at, (number, name, _) in enumerate(flown):
        yield from violations(number, name, least[:, at], settings.keep_out_m)


def elements_at(row: Array, time_s: float) -> tuple[float, ...]:
    """Elements of a body at a time, as :func:`begun` takes them."""
    perigee = float(elements.perigees(row, time_s))
    return (
        float(elements.radii(row, time_s)),
        float(elements.eccentricities(row, time_s)),
        float(elements.inclinations(row, time_s)),
        float(elements.nodes(row, time_s)),
        perigee,
        float(elements.latitudes(row, time_s)) - perigee,
    )


def violations(number: int, name: str, least_m: Array, keep_out_m: float) -> Iterator[Violation]:
    """The missed burn of an approach that leads nearest to the target, if too near."""
    worst = int(np.argmin(least_m))
    if not least_m[worst] >= keep_out_m - SPARE_M:
        yield Violation(
            number,
            "keep-out",
            f"with burn {worst + 1} of its approach missed it comes within {least_m[worst]:.0f} m "
            f"of {name!r}, which keep_out_m = {keep_out_m!r} forbids",
        )
