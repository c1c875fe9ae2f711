"""Flights with errors without linearisation, as a reference for the feedback.

All states are integrated, and before each burn those that are left are targeted anew as they would
be on board: the least squares of :mod:`.feedback` by Gauss's and Newton's steps, with the miss of
the step before, found by flying it.
"""

from __future__ import annotations

import math

import numpy as np

from ...kernels.orbits import coast, equinoctial
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from .errors import FlightErrors
from .feedback import BodiesOff, LegPart

STEPS = 3
"""Number of targeting steps before each burn."""


def fly_exactly(
    part: LegPart, begun: Array, drawn: Array, errors: FlightErrors, off: BodiesOff | None = None
) -> tuple[float, Array]:
    """Fly a part of a leg once.

    Parameters
    ----------
    part : LegPart
    begun : (6,) float64
        By how much the flight is off at the beginning [m, m/s].
    drawn : (burns, 3) float64
        Standard normal numbers.
    errors : FlightErrors
    off : BodiesOff, optional
        Of the bodies, each of shape (6,).

    Returns
    -------
    float
        ΔV [m/s].
    (6,) float64
        The state at the end less that of the refined plan, or less that of the stand-off where
        the destination is [m, m/s].

    Raises
    ------
    ArithmeticError
        It leads away from the Earth or into its centre.
    """
    zonals, none = FIELDS[part.gravity], np.empty((0, 0))
    docked, goal, elsewhere = part.start, part.goal, np.zeros(6)
    if off is not None:
        docked, goal, elsewhere = moved(docked, off.origin), moved(goal, off.target), off.target
    now, angle, spent = docked + begun, 0.0, 0.0
    last = part.times.size - 1
    for at, impulse in enumerate(part.impulses):
        if at < part.seen and part.gains[at] is not None:
            known = docked.copy()  # no burn before this one is seen
            coast.coast(known, part.times[at] - part.times[0], zonals, none)
        else:
            known = now
        target = elsewhere if at >= part.tracked else np.zeros(6)
        burn = impulse + _correction(part, known, at, angle, target)
        burn = errors.of_burns(burn[:, None], drawn[at][:, None])[:, 0]
        spent += math.hypot(*burn)
        now = now.copy()
        now[3:] += burn
        until = part.times[at + 1] if at < last else part.end_s
        angle += coast.coast(now, until - part.times[at], zonals, none)
    if not np.isfinite(now).all():
        raise ArithmeticError("a flight with errors leads away from the Earth or into its centre")
    return spent, now - goal


def moved(state: Array, off: Array) -> Array:
    """A state moved by elements in its own frame, both of shape (6,)."""
    frame = equinoctial.own_frame(state)
    there: Array = equinoctial.state_of(equinoctial.elements(state, frame) + off, frame)
    return there


def _correction(part: LegPart, state: Array, at: int, angle: float, target: Array) -> Array:
    """Change of a burn, from a state before it, the angle covered so far and where the goal is."""
    gain, effects = part.gains[at], part.effects[at:]
    if gain is None:
        return np.zeros(3)
    changes = np.zeros((len(effects), 3))
    for _ in range(STEPS):
        miss = _miss(part, state, at, angle, changes) - target
        changes = gain @ (miss - np.einsum("kij,kj->i", effects, changes))
    return np.asarray(changes[0])


def _miss(part: LegPart, state: Array, at: int, angle: float, changes: Array) -> Array:
    """Predicted miss in elements after this burn and those that follow, laps counted."""
    impulses = part.impulses[at:] + changes
    states, _, rest = coast.fly(
        state, part.times[at:], impulses, part.end_s, FIELDS[part.gravity], False
    )
    frame = equinoctial.own_frame(part.goal)
    reached, goal = (equinoctial.elements(one, frame) for one in (states[-1], part.goal))
    miss: Array = reached - goal
    if not np.isfinite(miss).all():
        raise ArithmeticError("a flight with errors leads away from the Earth or into its centre")
    miss[5] = math.remainder(miss[5], math.tau)
    miss[5] += math.tau * round((angle + rest - part.angle - miss[5]) / math.tau)
    return miss
