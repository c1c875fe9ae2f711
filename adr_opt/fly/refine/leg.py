"""One leg in true dynamics: impulses of least ΔV between two states.

Successive convex steps. Misses are measured in equinoctial elements in the frame of the goal, and
the longitude counts whole revolutions: so they are nearly linear in the impulses, even where weeks
of drift have led a trajectory once round the Earth too far. About the present trajectory the
impulses of least total size are a cone problem (:mod:`.least`) over many candidate times; they are
flown, closed by Newton steps, and taken if they cost less.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...common.constants import MU_M3_S2
from ...kernels.orbits import coast, equinoctial
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from .bodies import Gravity
from .least import fewest, least_impulses

POSITION_M, SPEED_M_S = 1e-3, 1e-6
"""Tolerances of a leg at its goal: a thousandth of those in the contract of refined plans."""

MOST_NEWTON = 25
MOST_CONVEX, MOST_LED_BACK = 12, 24
"""Maximum numbers of steps to close a miss, of convex steps, and of those back within limits."""

WORTH = 1e-4
"""Least relative gain of a convex step; a smaller one is the last."""

PER_REVOLUTION = 24
"""Number of candidate times per revolution."""

MOST_CANDIDATES = 960
"""Maximum number of candidate times in a leg; beyond it, whole revolutions in its middle are
omitted evenly."""

INSIDE_M, NEAR_M = 8e3, 4e3
"""Margin of apsides to their limits, and tolerance on it [m]. Osculating apsides of an arc vary by
as much under J2, so that arcs beside it would exceed the limits."""

NEGLIGIBLE_M_S = 1e-4
"""Size below which impulses are omitted if the others suffice [m/s]."""


@dataclass(frozen=True)
class LegEnds:
    """Start and goal of a leg.

    Attributes
    ----------
    start, goal : (6,) float64
        Inertial states [m, m/s].
    start_s, end_s : float
        Their times since the epoch [s].
    angle : float
        That the chaser runs through between them by plan, revolutions counted [rad].
    gravity : {"two-body", "j2", "j3", "j4"}
    lowest_m, highest_m : float
        Radii that :func:`cheapen` keeps perigees and apogees between; where the trajectory that
        it begins with goes further, it may go as far [m].
    """

    start: Array
    goal: Array
    start_s: float
    end_s: float
    angle: float
    gravity: Gravity
    lowest_m: float = 0.0
    highest_m: float = math.inf

    def move(self, times: Array, impulses: Array) -> tuple[Array, Array, float]:
        """Fly impulses from the start: the result of :func:`adr_opt.kernels.orbits.coast.fly`."""
        zonals = FIELDS[self.gravity]
        found: tuple[Array, Array, float] = coast.fly(
            self.start, times, impulses, self.end_s, zonals, True
        )
        return found


@dataclass(frozen=True)
class FlownImpulses:
    """A flown sequence of impulses.

    Attributes
    ----------
    times : (burns,) float64
        [s].
    impulses : (burns, 3) float64
        [m/s].
    states : (burns + 1, 6) float64
        Before each, and at the end.
    effects : (burns, 6, 3) float64
        Derivatives of the miss by each impulse.
    miss : (6,) float64
        In equinoctial elements [m, …, rad], revolutions counted.
    """

    times: Array
    impulses: Array
    states: Array
    effects: Array
    miss: Array

    @property
    def delta_v_m_s(self) -> float:
        """Sum of the impulses [m/s]."""
        return float(np.sqrt(np.sum(self.impulses**2, axis=1)).sum())

    @property
    def apsides_m(self) -> tuple[Array, Array]:
        """Perigees and apogees of the arcs after each impulse, shape (burns,) each [m].

        An arc after the last impulse counts, one without length does not: it ends at the goal.
        """
        after = self.states[:-1].copy()
        after[:, 3:] += self.impulses
        radius = np.sqrt(np.sum(after[:, :3] ** 2, axis=1))
        axis = 1.0 / (2.0 / radius - np.sum(after[:, 3:] ** 2, axis=1) / MU_M3_S2)
        momentum = np.sum(np.cross(after[:, :3], after[:, 3:]) ** 2, axis=1)
        e = np.sqrt(np.maximum(1.0 - momentum / (MU_M3_S2 * axis), 0.0))
        return axis * (1.0 - e), axis * (1.0 + e)

    @property
    def reach_m(self) -> tuple[float, float]:
        """Lowest perigee and highest apogee of the arcs between impulses [m]."""
        perigees, apogees = self.apsides_m
        return float(perigees.min()), float(apogees.max())


class NoWay(ArithmeticError):
    """No trajectory to the goal was found from the given burns."""


def fly(course: LegEnds, times: Array, impulses: Array) -> FlownImpulses:
    """Fly impulses and compute the miss.

    Raises
    ------
    NoWay
        They lead away from the Earth or into its centre.
    """
    # The arc before the first impulse counts in the angle: it is flown as one without.
    early = times[0] > course.start_s
    if early:
        times, impulses = np.r_[course.start_s, times], np.vstack([np.zeros(3), impulses])
    states, arcs, angle = course.move(times, impulses)
    end = states[-1]
    frame = equinoctial.own_frame(course.goal)
    reached = equinoctial.elements(end, frame)
    if not np.isfinite(reached).all():
        raise NoWay("the burns lead away from the Earth or into its centre")
    miss = reached - equinoctial.elements(course.goal, frame)
    miss[5] = math.remainder(miss[5], math.tau)
    miss[5] += math.tau * round((angle - course.angle - miss[5]) / math.tau)
    effects = equinoctial.jacobian(end, frame) @ arcs[:, :, 3:]
    first = 1 if early else 0
    return FlownImpulses(times[first:], impulses[first:], states[first:], effects[first:], miss)


def residual(course: LegEnds, flown: FlownImpulses) -> tuple[float, float]:
    """Distance from the goal [m] and speed relative to it [m/s]."""
    apart = flown.states[-1] - course.goal
    return math.hypot(*apart[:3]), math.hypot(*apart[3:])


def close(
    course: LegEnds, times: Array, impulses: Array, most: int = MOST_NEWTON, *, evenly: bool = False
) -> FlownImpulses:
    """Change impulses as little as necessary to reach the goal.

    Newton's steps of least weighted square: large impulses take more of the change, unless all are
    to take of it evenly.

    Raises
    ------
    NoWay
        The steps do not lead to the goal.
    """
    flown = fly(course, times, impulses)
    size = _size(course, flown.miss)
    for _ in range(most):
        position, speed = residual(course, flown)
        if position < POSITION_M and speed < SPEED_M_S:
            return flown
        weights = np.sqrt(np.sum(flown.impulses**2, axis=1))
        weights = np.ones(weights.size) if evenly else weights + 0.02 * weights.max() + 1e-3
        step = _least_square(flown.effects, -flown.miss, weights)
        for _ in range(8):
            try:
                tried = fly(course, times, flown.impulses + step)
            except NoWay:
                step = 0.25 * step
                continue
            if (found := _size(course, tried.miss)) < size or size < 1e-2:
                flown, size = tried, found
                break
            step = 0.25 * step
        else:
            break
    position, speed = residual(course, flown)
    if position < 10.0 * POSITION_M and speed < 10.0 * SPEED_M_S:
        return flown
    raise NoWay(f"a miss of {position:.3g} m and {speed:.3g} m/s cannot be closed")


def cheapen(course: LegEnds, flown: FlownImpulses) -> FlownImpulses:
    """Impulses of less ΔV that also reach the goal, by successive convex steps.

    Steps that are shortened until they stay within the limits of altitude end far from the least.
    So where the least without limits is beyond them, it is led back as well, with the apsides that
    are beyond held at their limits; the cheaper one within them is taken. Where the trajectory that
    it begins with goes further, and nothing else is found, it may go as far.
    """
    limits, (low, high) = (course.lowest_m, course.highest_m), flown.reach_m
    least = _descended(course, flown, (-math.inf, math.inf))
    if _is_within(least, limits):
        return least
    back = least
    best = _descended(course, flown, (min(limits[0], low), max(limits[1], high)))
    for _ in range(MOST_LED_BACK):
        led = _led_back(course, back, limits)
        if led is None:
            break
        gain = best.delta_v_m_s - led.delta_v_m_s
        if _is_within(led, limits) and (gain > 0.0 or not _is_within(best, limits)):
            best = led
            if abs(gain) <= WORTH * best.delta_v_m_s:
                break
        back = led
    return best


def _descended(course: LegEnds, flown: FlownImpulses, limits: tuple[float, float]) -> FlownImpulses:
    """The end of convex steps that get cheaper and stay within limits."""
    share = 1.0
    for _ in range(MOST_CONVEX):
        times, impulses = _with_candidates(course, flown)
        now = fly(course, times, impulses)
        wanted = np.einsum("kij,kj->i", now.effects, now.impulses) - now.miss
        found = _fewest_of_least(now.effects, wanted)
        gain = 0.0
        while share > 0.02:
            tried = _try(course, times, impulses + share * (found - impulses))
            if (
                tried is not None
                and _is_within(tried, limits)
                and tried.delta_v_m_s < flown.delta_v_m_s
            ):
                gain = flown.delta_v_m_s - tried.delta_v_m_s
                flown, share = tried, min(1.0, 2.0 * share)
                break
            share *= 0.5
        if gain <= WORTH * flown.delta_v_m_s:
            break
    # A step that was taken in part leaves the impulses of two solutions.
    tried = _try(course, flown.times, fewest(flown.effects, flown.impulses))
    if (
        tried is not None
        and _is_within(tried, limits)
        and tried.delta_v_m_s <= (1.0 + WORTH) * flown.delta_v_m_s
    ):
        return tried
    return flown


def _led_back(
    course: LegEnds, flown: FlownImpulses, limits: tuple[float, float]
) -> FlownImpulses | None:
    """The convex step that holds all apsides at or beyond their limits at the limits.

    None if it does not reach the goal.
    """
    times, impulses = _with_candidates(course, flown)
    now = fly(course, times, impulses)
    wanted = np.einsum("kij,kj->i", now.effects, now.impulses) - now.miss
    effects = now.effects
    perigees, apogees = flown.apsides_m
    for arc, begins in enumerate(flown.times):
        for apsis, sign, limit in (
            (perigees[arc], -1.0, limits[0] + INSIDE_M),
            (apogees[arc], 1.0, limits[1] - INSIDE_M),
        ):
            if sign * (apsis - limit) > -NEAR_M:
                row, value = _held(course, now, float(begins), sign, limit)
                effects = np.concatenate([effects, row[:, None, :]], axis=1)
                wanted = np.append(wanted, value)
    return _try(course, times, _fewest_of_least(effects, wanted))


def _is_within(flown: FlownImpulses, limits: tuple[float, float]) -> bool:
    low, high = flown.reach_m
    return limits[0] <= low and high <= limits[1]


def _held(
    course: LegEnds, now: FlownImpulses, begins_s: float, sign: float, apsis_m: float
) -> tuple[Array, float]:
    """Linear equation that puts an apsis of an arc at a radius: its row (burns, 3), and value.

    Impulses before the arc change its size and eccentricity as they change those at the goal. The
    sign is −1 for a perigee, and 1 for an apogee.
    """
    arc = int(np.searchsorted(now.times, begins_s, side="right")) - 1
    after = now.states[arc].copy()
    after[3:] += now.impulses[arc]
    axis, f, g = equinoctial.elements(after, equinoctial.own_frame(course.goal))[:3]
    e = math.hypot(f, g)
    slope = np.array([1.0 + sign * e, sign * axis * f / e, sign * axis * g / e])
    row = np.einsum("i,kij->kj", slope, now.effects[:, :3])
    row[arc + 1 :] = 0.0
    return row, apsis_m - axis * (1.0 + sign * e) + float(np.sum(row * now.impulses))


def _fewest_of_least(effects: Array, wanted: Array) -> Array:
    """Impulses of least total size that make a change, as few as possible."""
    return fewest(effects, least_impulses(effects, wanted).impulses)


def _try(course: LegEnds, times: Array, impulses: Array) -> FlownImpulses | None:
    """Close impulses without negligible ones; None if that fails."""
    sizes = np.sqrt(np.sum(impulses**2, axis=1))
    kept = sizes > NEGLIGIBLE_M_S
    if kept.sum() < 2:
        return None
    try:
        return close(course, times[kept], impulses[kept])
    except NoWay:
        return None


def _with_candidates(course: LegEnds, flown: FlownImpulses) -> tuple[Array, Array]:
    """Impulses of a trajectory, with zeros at candidate times."""
    radius = math.hypot(*course.goal[:3])
    revolution = math.tau * math.sqrt(radius**3 / MU_M3_S2)
    span = course.end_s - course.start_s
    step = revolution / PER_REVOLUTION
    grid = np.linspace(course.start_s, course.end_s, 2 + int(span / step))
    if grid.size > MOST_CANDIDATES:
        edge = MOST_CANDIDATES // 3
        # Both ends in full, and whole revolutions evenly spread between them.
        starts = np.linspace(edge, grid.size - edge, MOST_CANDIDATES // 3 // PER_REVOLUTION + 1)
        runs = [np.arange(int(s), int(s) + PER_REVOLUTION) for s in starts[:-1]]
        chosen = np.r_[np.arange(edge), *runs, np.arange(grid.size - edge, grid.size)]
        grid = grid[np.unique(chosen)]
    apart = np.abs(grid[:, None] - flown.times[None, :]).min(axis=1)
    grid = grid[apart > 1e-3 * step]
    times = np.r_[grid, flown.times]
    impulses = np.vstack([np.zeros((grid.size, 3)), flown.impulses])
    order = np.argsort(times, kind="stable")
    return times[order], impulses[order]


def _least_square(effects: Array, change: Array, weights: Array) -> Array:
    count, equations, _ = effects.shape
    rows = effects.transpose(1, 0, 2).reshape(equations, 3 * count)
    wide = np.repeat(weights, 3)
    weighted = rows * wide
    scale = 1.0 / np.sqrt(np.sum(weighted * weighted, axis=1))
    system = (weighted * scale[:, None]) @ (weighted * scale[:, None]).T
    dual = np.linalg.lstsq(system, change * scale, rcond=1e-13)[0]
    found: Array = (wide * ((weighted * scale[:, None]).T @ dual)).reshape(count, 3)
    return found


def _size(course: LegEnds, miss: Array) -> float:
    """Length equivalent to a miss in elements [m]."""
    radius = math.hypot(*course.goal[:3])
    return float(np.linalg.norm(miss * np.array([1.0, *([radius] * 5)])))
