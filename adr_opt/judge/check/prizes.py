"""What prizes have in common, so that it can be told whether an objective is the largest there is.

Worked out once more, by itself: see :mod:`adr_opt.common.tolerance` for what planners know.
"""

from __future__ import annotations

import math
from fractions import Fraction

from ...problem.instance import Instance

MOST_STEPS = 2**46
"""With more steps in the sum of what targets are worth to planners nothing is made of them."""

SHARE = 1e-11
"""Then objectives are equal that differ by no more of the sum of all prizes."""


SAFE = 1.0 - 1e-6
"""Share of the difference that a bound has to be nearer by: rounding makes no difference of it."""


def is_met(objective: float, bound: float, difference: float) -> bool:
    """Whether no objective is larger than one and within a bound: they are nearer than objectives.

    Parameters
    ----------
    objective, bound : float
    difference : float
        See :func:`difference_of`.
    """
    return bound - objective <= SAFE * difference


def difference_of(instance: Instance) -> float:
    """By how much two objectives differ at least that are not equal.

    All prizes, as they are written, are whole numbers of such steps. Where there are too many steps
    objectives count as equal that differ by less than :data:`SHARE` of the sum.
    """
    written = [Fraction(repr(target.prize)) for target in instance.targets if target.prize > 0.0]
    if not written:
        return 0.0
    total = sum(written)
    parts = math.lcm(*(prize.denominator for prize in written))
    step = Fraction(math.gcd(*(int(prize * parts) for prize in written)), parts)
    required = sum(target.required for target in instance.targets)
    if (1 + required) * (total + step) <= MOST_STEPS * step:
        return float(step)
    return SHARE * float(total)
