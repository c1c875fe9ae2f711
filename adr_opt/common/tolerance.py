"""Equality of objectives, and the common step of their values.

Prizes have a common step wherever they are written in so few digits that it can be told, and then
objectives are compared exactly: by whole steps. Where they have none, objectives differ by as
arbitrarily little, and the tolerance is what arithmetic leaves. `check` and `verify` derive all
this again by themselves, on purpose.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from decimal import Decimal
from fractions import Fraction

RELATIVE = 1e-11
"""Relative tolerance between objectives without a common step, as a share of all prizes."""

ROUNDED = 2.0**-48
"""Largest relative difference between sums of the same prizes due to rounding."""

COST_RELATIVE = 1e-6
"""Relative excess over its bound at which a cost, which has no steps, still counts as minimal."""

ROUNDING = 1e-6
"""Distance below a multiple of the step at which a bound counts as that multiple [steps]."""

WHOLE = 1e-12
"""Relative tolerance for prizes as multiples of a step found by division."""

NOISY = 1e-6
"""Smallest such step, as a share of the sum of all prizes."""

MOST_STEPS = 2**46
"""Largest sum of all prizes, in steps, that can be resolved with a margin: sums are off by at
most 2⁻⁵⁰ of themselves."""

DIGITS = 12
"""Maximum number of significant digits of a prize that is taken as exact."""

TOO_SMALL = 4.0 * RELATIVE
"""Share of all prizes below which a prize without a common step would be lost in sums."""


def tolerance(bound: float) -> float:
    """Difference between an incumbent and a bound that rounding alone may cause."""
    return ROUNDED * abs(bound)


def meets(incumbent: float, bound: float) -> bool:
    """Whether an incumbent is as good as a bound, where prizes are unknown.

    Where they are, :meth:`.Prizes.meets` knows more.
    """
    return incumbent >= bound - tolerance(bound)


def common_step(prizes: Iterable[float], required: int = 0) -> float:
    """The largest number that divides all prizes, and hence all objectives.

    Parameters
    ----------
    prizes : iterable of float
    required : int
        Number of required targets, each of which is worth all prizes more to a planner.

    Returns
    -------
    float
        0 if there is none, or if all worths are more than :data:`MOST_STEPS` together.
    """
    worth = [float(prize) for prize in prizes if prize > 0.0]
    if not worth:
        return 0.0
    step = decimal_step(worth)
    return step if _are_few(worth, step, required) else _step_by_division(worth)


def _are_few(worth: Sequence[float], step: float, required: int) -> bool:
    """Whether the sum of all prizes is few enough steps to be resolved."""
    return (1 + required) * (math.fsum(worth) + step) <= MOST_STEPS * step


def decimal_step(prizes: Sequence[float]) -> float:
    """The largest number that divides positive prizes exactly as written in decimals."""
    if all(prize.is_integer() for prize in prizes):
        return float(math.gcd(*(int(prize) for prize in prizes)))
    written = [Fraction(repr(prize)) for prize in prizes]
    parts = math.lcm(*(number.denominator for number in written))
    return float(Fraction(math.gcd(*(int(number * parts) for number in written)), parts))


def _step_by_division(worth: list[float]) -> float:
    """The step of prizes that rounding has shifted off its multiples; 0 if none."""
    least = NOISY * math.fsum(worth)
    if min(worth) < least:
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


def check_prizes(prizes: Iterable[float], required: int) -> None:
    """Check that proofs can tell sums of these prizes apart in floating point.

    Parameters
    ----------
    prizes : iterable of float
    required : int
        Number of required targets, each worth more to a planner than all prizes together.

    Raises
    ------
    ValueError
        They cannot. What is accepted stays so with fewer targets.
    """
    worth = [float(prize) for prize in prizes if prize > 0.0]
    if not worth or common_step(worth, required):
        return
    total = math.fsum(worth)
    meant = [prize for prize in worth if _digits(prize) <= DIGITS]
    if meant and not _are_few(meant, decimal_step(meant), required):
        step = decimal_step(meant)
        besides = f", and {required} required targets count as many each" if required else ""
        raise ValueError(
            f"field targets: prizes are multiples of {step:g} and sum to {total:g}, which is "
            f"{total / step:.2g} steps{besides}; no more than {MOST_STEPS:.2g} can be told apart: "
            "round prizes"
        )
    if min(worth) < TOO_SMALL * total:
        raise ValueError(
            f"field targets: a prize of {min(worth):g} is lost to rounding in the sum of all, "
            f"{total:g}; give prizes of at least {TOO_SMALL:g} of it, or with a common step"
        )


def _digits(prize: float) -> int:
    """Number of significant digits in which a prize is written."""
    return len(Decimal(repr(prize)).normalize().as_tuple().digits)


def are_multiples(prizes: Iterable[float], step: float) -> bool:
    """Whether all prizes are multiples of a step, up to rounding."""
    return all(abs(prize - step * round(prize / step)) <= WHOLE * prize for prize in prizes)


def rounded_down(bound: float, step: float, slack: float = ROUNDING) -> float:
    """A bound rounded down to a multiple of the step; unchanged if the step is 0.

    Parameters
    ----------
    bound, step : float
    slack : float
        By how much the bound may be too small for rounding [steps].
    """
    if not step or not math.isfinite(bound):
        return bound
    return step * math.floor(bound / step + slack)


def rounded_up(goal: float, step: float) -> float:
    """A goal rounded up to a multiple of the step; unchanged if the step is 0."""
    return step * math.ceil(goal / step - ROUNDING) if step else goal
