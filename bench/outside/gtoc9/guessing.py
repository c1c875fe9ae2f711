"""First guesses for legs of weeks: the phase first, then everything else.

Over weeks a chaser runs through hundreds of revolutions, and where on its orbit it is on arrival
decides what an impulse there does. So a linear problem about the coasting trajectory is worth
little: its late impulses stand where the chaser will not be. Here two impulses along the orbit,
half a revolution apart, first lead to a drift orbit on which the goal's longitude is met after a
whole number of revolutions more or fewer. About that trajectory impulses are of least size at the
right phase. What they do to the energy besides, |u|²/2, is small and moves the phase all the same;
so the phase is mended before the next round.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from adr_opt.fly.refine.least import least_impulses
from adr_opt.fly.refine.leg import LegEnds, NoWay, fly
from adr_opt.kernels.orbits import coast, equinoctial
from adr_opt.kernels.orbits.gravity import FIELDS

from ..reading import FloatArray

PER_REVOLUTION, MOST_TIMES = 12, 108
"""Number of times at which impulses are tried: per revolution, and at most."""

REVOLUTIONS, STRIDE = 12, 3
"""Range of revolutions tried, more and fewer than without impulses: every third of them, and then
the neighbours of the best one."""

MOST_DRIFT_M_S = 250.0
"""Maximum total of both impulses of a drift orbit; beyond it lie the limits of altitude."""

CLOSE_RAD, MOST_SECANT = 1e-3, 12
"""Tolerance of the goal's longitude, and maximum number of secant steps."""

RANKED = 4
"""Number of drift orbits followed further."""

ROUNDS = 3
"""Rounds of least impulses, each around those of the previous one."""

TOLERANCE = 1e-2
"""Tolerance of least impulses, which are only guesses."""

MOST_M_S = 2000.0
"""A guess of more is none."""


class Guess(NamedTuple):
    """Impulses at many times, most of them zero, that nearly lead to the goal of a course.

    ``total`` is their size [m/s].
    """

    total: float
    course: LegEnds
    times: FloatArray
    impulses: FloatArray


def times_of(start_s: float, end_s: float, revolution_s: float) -> FloatArray:
    """Times near both ends, and some in between."""
    grid = np.arange(start_s, end_s, revolution_s / PER_REVOLUTION)
    if grid.size <= MOST_TIMES:
        return np.r_[grid, end_s]
    edge = MOST_TIMES // 3
    middle = np.linspace(edge, grid.size - edge, MOST_TIMES // 3).astype(int)
    places = np.unique(np.r_[np.arange(edge), middle, np.arange(grid.size - edge, grid.size)])
    return np.r_[grid[places], end_s]


def guesses(course: LegEnds, revolution_s: float) -> list[Guess]:
    """First guesses by different numbers of revolutions, the cheapest first.

    Parameters
    ----------
    course : LegEnds
        Its angle counts for nothing; those of the guesses are set.
    revolution_s : float
    """
    times = times_of(course.start_s, course.end_s, revolution_s)
    free = fly(course, np.array([course.start_s]), np.zeros((1, 3)))
    # With no angle asked for, the miss counts all revolutions; what they leave over is the phase.
    turns = round(free.miss[5] / math.tau)
    found: dict[int, Guess] = {}

    def follow(more: int) -> None:
        aimed = replace(course, angle=math.tau * (turns + more))
        with contextlib.suppress(NoWay):
            found[more] = _least(_drifting(aimed, revolution_s, times))

    for more in range(-REVOLUTIONS, REVOLUTIONS + 1, STRIDE):
        follow(more)
    middle = min(found, key=lambda more: found[more].total, default=0)
    while abs(middle) >= REVOLUTIONS:
        # The best one lies at the edge: on, as long as it gets better.
        follow(middle + int(math.copysign(STRIDE, middle)))
        last, middle = middle, min(found, key=lambda more: found[more].total)
        if middle == last:
            break
    for more in range(middle - STRIDE + 1, middle + STRIDE):
        if more not in found:
            follow(more)
    better = []
    for guess in sorted(found.values(), key=lambda guess: guess.total)[:RANKED]:
        try:
            for _ in range(1, ROUNDS):
                guess = _least(phased(guess))
            better.append(phased(guess))
        except NoWay:
            continue
    return sorted(better, key=lambda guess: guess.total)


def _drifting(course: LegEnds, revolution_s: float, times: FloatArray) -> Guess:
    """Two impulses along the orbit after which its longitude is that of the goal."""
    second = course.start_s + 0.5 * revolution_s
    if second >= course.end_s:
        raise NoWay("less than half a revolution")
    times = np.unique(np.r_[course.start_s, second, times])
    halfway = int(np.searchsorted(times, second))
    return phased(Guess(0.0, course, times, np.zeros((times.size, 3))), (0, halfway))


def phased(guess: Guess, places: tuple[int, ...] = (0,)) -> Guess:
    """The same but for a change along the orbit, so that the longitude of the goal is met.

    Parameters
    ----------
    guess : Guess
    places : tuple of int
        Of the impulses that share the change: half a revolution apart, the orbit stays round.
    """
    course = guess.course
    used = np.any(guess.impulses != 0.0, axis=1)
    used[list(places)] = True
    times = np.r_[course.start_s, guess.times[used]]
    impulses = np.vstack([np.zeros(3), guess.impulses[used]])
    changed = 1 + np.searchsorted(np.flatnonzero(used), places)
    frame = equinoctial.own_frame(course.goal)
    goal = equinoctial.elements(course.goal, frame)[5]
    # A semi-major axis changes by 2 a Δv / v, the mean motion by three halves of that share.
    rate = -3.0 * (course.end_s - course.start_s) / math.hypot(*course.start[:3])
    total, before = 0.0, (0.0, 0.0)
    change = np.zeros((len(places), 3))
    for _ in range(MOST_SECANT):
        tried = impulses.copy()
        tried[changed] += change
        states, _, angle = coast.fly(
            course.start, times, tried, course.end_s, FIELDS[course.gravity], False
        )
        miss = math.remainder(equinoctial.elements(states[-1], frame)[5] - goal, math.tau)
        miss += math.tau * round((angle - course.angle - miss) / math.tau)
        if not math.isfinite(miss):
            break
        if abs(miss) < CLOSE_RAD:
            found = guess.impulses.copy()
            found[used] = tried[1:]
            return guess._replace(impulses=found, total=float(np.linalg.norm(found, axis=1).sum()))
        # Impulses that come later turn with the phase, and so does what they do to it.
        if total != before[0] and (steeper := (miss - before[1]) / (total - before[0])) < 0.0:
            rate = min(max(steeper, 4.0 * rate), 0.25 * rate)
        before = total, miss
        total -= miss / rate
        if abs(total) > MOST_DRIFT_M_S:
            break
        velocity = states[changed, 3:]
        speed = np.sqrt(np.sum(velocity**2, axis=1))
        change = total / len(places) * velocity / speed[:, None]
    raise NoWay("no such drift orbit")


def _least(guess: Guess) -> Guess:
    """Impulses of least size to first order about those of a guess."""
    now = fly(guess.course, guess.times, guess.impulses)
    aimed = np.einsum("kij,kj->i", now.effects, now.impulses) - now.miss
    least = least_impulses(now.effects, aimed, TOLERANCE)
    if not 0.0 < least.total < MOST_M_S:
        raise NoWay("the first guess leads nowhere")
    sizes = np.sqrt(np.sum(least.impulses**2, axis=1))
    impulses = np.where((sizes > 1e-4 * sizes.max())[:, None], least.impulses, 0.0)
    return guess._replace(total=least.total, impulses=impulses)
