"""Common step of prizes, which decides whether an objective is optimal.

Worked out once more, by itself: see :mod:`adr_opt.common.tolerance` for what planners know.
"""

from __future__ import annotations

import math
from fractions import Fraction

from ...common.constants import SLACK_S
from ...plan.plan import Plan
from ...problem.instance import Instance

MOST_STEPS = 2**46
"""Maximum number of steps in the sum of worths; beyond it, steps are not used."""

SHARE = 1e-11
"""Relative tolerance between objectives in that case, as a share of the sum of all prizes."""


SAFE = 1.0 - 1e-6
"""Share of the difference within which a bound must lie, to cover rounding."""


def is_met(objective: float, bound: float, difference: float) -> bool:
    """Whether no better objective fits within a bound.

    Parameters
    ----------
    objective, bound : float
    difference : float
        See :func:`difference_of`.
    """
    return bound - objective <= SAFE * difference


def collected(instance: Instance, plan: Plan) -> float:
    """Sum of the prizes of the targets that a plan visits.

    Of a prize that falls the first that its service does not outlast. A service with a tow ends
    when the tow does that follows it at once.
    """
    ends: dict[str, float] = {}
    for leg in plan.legs:
        towed_s = 0.0 if leg.tow is None else leg.tow.end_s - leg.tow.start_s
        ends.setdefault(leg.destination, leg.end_s + towed_s)
    found = []
    for target in instance.targets:
        if target.name in ends:
            levels = [
                prize
                for until_s, prize in target.prize_until or ()
                if ends[target.name] <= until_s + SLACK_S
            ]
            found.append(max(levels, default=target.prize))
    return math.fsum(found)


def difference_of(instance: Instance) -> float:
    """Least difference between two unequal objectives.

    All prizes, as they are written, are whole numbers of such steps. Where there are too many steps
    objectives count as equal that differ by less than :data:`SHARE` of the sum.
    """
    prizes = [prize for target in instance.targets for prize in target.prizes]
    written = [Fraction(repr(prize)) for prize in prizes if prize > 0.0]
    if not written:
        return 0.0
    total = sum(written)
    parts = math.lcm(*(prize.denominator for prize in written))
    step = Fraction(math.gcd(*(int(prize * parts) for prize in written)), parts)
    required = sum(target.required for target in instance.targets)
    if (1 + required) * (total + step) <= MOST_STEPS * step:
        return float(step)
    return SHARE * float(total)
