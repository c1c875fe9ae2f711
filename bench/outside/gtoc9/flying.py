"""Legs flown by the contest's own equations: the full pull of J2, impulses, and no estimate.

Between two debris a chaser is subject to the pull of the Earth with J2 and to its impulses. A leg
begins with the position and velocity of the one debris and must end with those of the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adr_opt.common.constants import DAY_S
from adr_opt.fly.refine.least import fewest
from adr_opt.fly.refine.leg import FlownImpulses, LegEnds, NoWay, fly, residual

from ..reading import FloatArray
from .ephemeris import Debris
from .guessing import Guess, guesses, phased
from .polishing import polished, without_one

MOST_IMPULSES = 5
"""Maximum number of impulses per leg."""

CLOSE_M, CLOSE_M_S = 100.0, 1.0
"""Largest distance and relative speed at a rendezvous."""

LOWEST_M = 6600e3
"""Least radius of perigees."""

BEST = 2
"""Number of guesses flown."""

DROPPED = 2
"""Number of ways to omit an impulse that are optimised."""

WORSE = 1.1
"""Ratio to its guess's cost beyond which a flight has left the guess's valley."""


@dataclass(frozen=True)
class FlownLeg:
    """A leg as flown.

    Attributes
    ----------
    delta_v_m_s : float
    impulses : int
    miss_m, miss_m_s : float
        Off the debris on arrival.
    times_s, impulses_m_s : (impulses,), (impulses, 3) float64
        Since MJD2000 0, inertial.
    """

    delta_v_m_s: float
    impulses: int
    miss_m: float
    miss_m_s: float
    times_s: FloatArray
    impulses_m_s: FloatArray


def flown_leg(
    one: Debris, other: Debris, departure_d: float, arrival_d: float, best: int = BEST
) -> FlownLeg:
    """Fly from a debris to another between two times [d].

    Parameters
    ----------
    one, other : Debris
    departure_d, arrival_d : float
        [d, MJD2000].
    best : int
        So many guesses are flown.

    Raises
    ------
    NoWay
        No impulses were found.
    """
    start_s, end_s = departure_d * DAY_S, arrival_d * DAY_S
    course = LegEnds(one.state(start_s), other.state(end_s), start_s, end_s, 0.0, "j2")
    found: FlownImpulses | None = None
    flights = 0
    for guess in guesses(course, other.revolution_s):
        if flights == best:
            break
        if found is not None and guess.total > 1.2 * found.delta_v_m_s:
            continue
        try:
            tried = _flown(guess)
        except NoWay:
            continue
        flights += 1
        if found is None or tried.delta_v_m_s < found.delta_v_m_s:
            found = tried
    if found is None:
        raise NoWay(f"no way from {departure_d:.3f} to {arrival_d:.3f}")
    miss = residual(course, found)
    return FlownLeg(found.delta_v_m_s, len(found.times), *miss, found.times, found.impulses)


def _flown(guess: Guess) -> FlownImpulses:
    """No more impulses than are allowed, to the goal, and as cheap as they are in its valley."""
    now = fly(guess.course, guess.times, guess.impulses)
    few = fewest(now.effects, now.impulses)
    kept = np.any(few != 0.0, axis=1)
    ways = [(now.times[kept], few[kept], now.effects[kept])]
    while len(ways[0][0]) > MOST_IMPULSES:
        ways = without_one(*ways[0])
    found: list[FlownImpulses] = []
    good = 0
    for times, impulses, _ in ways:
        if good == DROPPED:
            break
        try:
            start = phased(Guess(guess.total, guess.course, times, impulses))
            tried = polished(guess.course, times, start.impulses)
        except NoWay:
            continue
        if tried.reach_m[0] >= LOWEST_M:
            found.append(tried)
            good += tried.delta_v_m_s < WORSE * guess.total
    if not found:
        raise NoWay("the leg cannot be flown with so few impulses")
    return min(found, key=lambda flown: flown.delta_v_m_s)
