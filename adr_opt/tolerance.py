"""When two objectives count as equal, and what steps objectives come in.

All of it is relative, so that prizes of any size are planned and proven alike. `check` states its
own tolerance, on purpose.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

RELATIVE = 1e-6
"""An incumbent meets a bound that is above it by no more than this share of the bound."""

ROUNDING = 1e-6
"""A bound this little below a multiple of the step counts as that multiple [steps]."""

WHOLE = 1e-12
"""A prize is a multiple of the step if it misses one by no more than this share of it."""


def tolerance(bound: float) -> float:
    """What an incumbent may lack of a bound that it meets."""
    return RELATIVE * abs(bound)


def meets(incumbent: float, bound: float) -> bool:
    """Whether an incumbent is as good as a bound."""
    return incumbent >= bound - tolerance(bound)


def common_step(prizes: Iterable[float]) -> float:
    """The largest number of which all prizes are multiples, and with them all objectives.

    Returns
    -------
    float
        0 if there is none, or if it is below the tolerance of the sum of all prizes: rounding to
        such steps would tell nobody anything.
    """
    worth = [prize for prize in prizes if prize > 0.0]
    least = RELATIVE * sum(worth)
    if not worth or min(worth) < least:
        return 0.0
    step = 0.0
    for prize in worth:
        # Euclid's algorithm; a remainder below the least step is what rounding has left.
        while prize > 0.5 * least:
            step, prize = prize, math.fmod(step, prize)
            if step - prize < 0.5 * least:
                prize = 0.0
    greatest = max(worth)
    step = greatest / round(greatest / step)
    return step if step >= least and are_multiples(worth, step) else 0.0


def are_multiples(prizes: Iterable[float], step: float) -> bool:
    """Whether all prizes are multiples of a step."""
    return all(abs(prize - step * round(prize / step)) <= WHOLE * prize for prize in prizes)


def rounded_down(bound: float, step: float) -> float:
    """A bound on objectives that come in steps; as it is if the step is 0."""
    if not step or not math.isfinite(bound):
        return bound
    return step * math.floor(bound / step + ROUNDING)


def rounded_up(goal: float, step: float) -> float:
    """The least objective that is worth a goal, likewise."""
    return step * math.ceil(goal / step - ROUNDING) if step else goal
