"""Mean worths of tries at targets, and penalties that cancel the luck of captures."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ...problem.instance import Instance
from ...problem.uncertainty import Uncertainty

PRIZE_DIGITS = 9
"""Number of digits to which prizes are rounded up."""


def worths_of_tries(
    prize: float, success: float, tries: int, paid: float = 0.0
) -> tuple[float, ...]:
    """Mean worth of a target before each try, and after the last failed one.

    W_k = p r + (1 − p) max(W_{k+1}, 0) − what is paid for the time of a try, and 0 after the last.
    """
    worths = [0.0]
    for _ in range(tries):
        worths.append(success * prize + (1.0 - success) * max(worths[-1], 0.0) - paid)
    return tuple(reversed(worths))


class TryWorths:
    """Prizes less penalties whose mean is zero (docs/model.md section 13).

    Parameters
    ----------
    instance : Instance
    uncertainty : Uncertainty
    paid : mapping of int to float
        Price of the time of a try, by number of the target; 0 by default. Penalties then also take
        out the luck of targets that need few tries.
    """

    def __init__(
        self, instance: Instance, uncertainty: Uncertainty, paid: Mapping[int, float] | None = None
    ) -> None:
        self._paid = paid or {}
        self._targets, self._first_target = instance.targets, instance.first_target
        self._uncertainty = uncertainty
        self._known: dict[int, tuple[float, ...]] = {}

    def _worths(self, target: int) -> tuple[float, ...]:
        """The worths of tries at a target, computed when first needed."""
        if target not in self._known:
            of, uncertainty = self._targets[target - self._first_target], self._uncertainty
            self._known[target] = worths_of_tries(
                of.prize,
                uncertainty.success_of(of.name),
                uncertainty.tries_of(of.name),
                self._paid.get(target, 0.0),
            )
        return self._known[target]

    def _gone(self, target: int) -> float:
        return self._uncertainty.gone_of(self._targets[target - self._first_target].name)

    def most(self, target: int) -> float:
        """Mean worth of going to a target, with all tries."""
        return (1.0 - self._gone(target)) * self._worths(target)[0]

    def after(self, target: int, tries: int) -> float:
        """Value of a target at which some tries are made, until one succeeds or none is left."""
        return self.most(target) + tries * self._paid.get(target, 0.0)

    def after_failures(self, target: int, tries: int) -> float:
        """Value of an existing target that is given up after some failed tries."""
        return self.after(target, tries) - max(self._worths(target)[tries], 0.0)

    def on_arrival(self, target: int, *, gone: bool) -> float:
        """Value of an arrival; its mean is zero."""
        return self.most(target) if gone else self.most(target) - self._worths(target)[0]

    def of_try(self, target: int, attempt: int, *, caught: bool) -> float:
        """Value of the n-th try, if it ends in time; its mean is its chance times the prize."""
        before, after = self._worths(target)[attempt - 1 : attempt + 1]
        return before if caught else before - after


def mean_worths(instance: Instance, uncertainty: Uncertainty) -> dict[str, float]:
    """Mean worth of going to each target, rounded up, by name.

    Empty where all targets are worth the same share of their prizes, which then count as well.
    """
    if common_share(instance, uncertainty) is not None:
        return {}
    worths = TryWorths(instance, uncertainty)
    return {
        target.name: rounded_up(worths.most(body))
        for body, target in enumerate(instance.targets, start=instance.first_target)
    }


def common_share(instance: Instance, uncertainty: Uncertainty) -> float | None:
    """Mean share of its prize that each target is worth; None if shares differ."""
    worths = TryWorths(instance, uncertainty)
    shares = [
        worths.most(body) / target.prize
        for body, target in enumerate(instance.targets, start=instance.first_target)
        if target.prize > 0.0
    ]
    if not shares:
        return 1.0
    return shares[0] if max(shares) - min(shares) < 1e-12 else None


def with_worths(instance: Instance, worths: dict[str, float]) -> Instance:
    """An instance with the worths of going to its targets as prizes, where known."""
    if not worths:
        return instance
    targets = tuple(
        target.replace(prize=worths[target.name]) if target.prize > 0.0 else target
        for target in instance.targets
    )
    return instance.replace(targets=targets)


def rounded_up(prize: float) -> float:
    """A prize rounded up to few digits."""
    if prize <= 0.0:
        return 0.0
    digits = PRIZE_DIGITS - 1 - math.floor(math.log10(prize))
    scaled = prize * 10.0**digits
    near = round(scaled)
    whole = near if abs(scaled - near) < 1e-3 else math.ceil(scaled)
    return float(whole / 10**digits) if digits >= 0 else float(whole * 10**-digits)
