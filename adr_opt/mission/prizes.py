"""Prizes of targets, required targets, and their combination for planners.

Where prizes fall with time, what is lost of them enters the costs of labels, so that less lost
comes before less cost: labels along an order are compared by one number. A multiple of a unit that
no cost reaches, added to the cost, orders them by losses first: both are sums over legs. Losses are
exact; costs of equal losses are told apart by :data:`FINEST` at least.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.constants import SLACK_S
from ..common.errors import InputError
from ..common.tolerance import RELATIVE, ROUNDED, ROUNDING, common_step, rounded_down
from ..kernels.rules.falls import Falls
from ..problem.instance import Instance
from ..problem.rules import most_targets

FloatArray = npt.NDArray[np.float64]


FINEST = 0.01
"""Largest difference of costs that large losses may hide [m/s or kg]."""


class PrizeLosses(NamedTuple):
    """Losses of prizes, added to the costs of labels so that a smaller loss outranks any cost.

    Attributes
    ----------
    falls : Falls or None
        Of whole multiples of the unit; None if no prize falls.
    unit : float
        Cost of one step of prize: a power of two above any cost.
    step : float
        The step of prize.
    """

    falls: Falls | None
    unit: float
    step: float

    @classmethod
    def of(cls, falls: Falls | None, most_cost: float) -> PrizeLosses:
        """Losses scaled above an upper limit on costs.

        Raises
        ------
        InputError
            Losses and costs are too large together for one number.
        """
        if falls is None:
            return cls(None, math.inf, 0.0)
        unit = 2.0 ** math.ceil(math.log2(max(most_cost, 1.0)) + 1.0)
        steps = np.rint(falls.lost / falls.unit)
        last = falls.first[1:][np.diff(falls.first) > 0] - 1
        if math.ulp(float(steps[last].sum()) * unit) > FINEST:
            raise InputError(
                f"prizes may fall by {steps[last].sum():.3g} units of {falls.unit:g}, too many for "
                f"costs of up to {most_cost:.3g}; round the prizes, or lower the tanks' ΔV"
            )
        return cls(falls._replace(lost=steps * unit), unit, falls.unit)

    def apart(self, costs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Losses of prizes and costs, separated from their sums in labels."""
        if self.falls is None:
            return np.zeros(costs.size), costs
        lost = np.floor(costs / self.unit)
        return lost * self.step, costs - lost * self.unit


GUARD, MOST_GUARD = 1e-9, 0.125
"""Excess of a safe bound over a computed one: a share of all worths, and its maximum in steps."""

MARGIN, MOST_MARGIN = 1e-3, 0.5
"""Distance below the next step at which better plans are sought, larger where steps are small
compared with the sum: several times the effect of rounding [steps]."""


class Prizes:
    """The prizes of an instance, and the worth of its targets to planners.

    A planner makes the most of one number. So a required target is worth its prize and a bonus that
    no sum of prizes reaches.

    Parameters
    ----------
    instance : Instance

    Attributes
    ----------
    instance : Instance
    names : tuple of str
        Bodies, in the order of their numbers.
    """

    def __init__(self, instance: Instance) -> None:
        self.instance = instance
        self.names = instance.names

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the instance, computed once."""
        return self.instance.sha256

    @cached_property
    def bonus(self) -> float:
        """Worth of a required target to planners, in addition to its prize.

        More than all prizes together, and a multiple of what they are multiples of.
        """
        prizes = [target.greatest_prize for target in self.instance.targets]
        return math.fsum(prizes) + (self.prize_step or max(prizes, default=0.0) or 1.0)

    @cached_property
    def planning_prizes(self) -> npt.NDArray[np.float64]:
        """Worth of each body's service to planners, the greatest, shape (bodies,)."""
        worths = np.zeros(len(self.names))
        worths[self.instance.first_target :] = [
            target.greatest_prize + self.bonus * target.required for target in self.instance.targets
        ]
        worths.setflags(write=False)
        return worths

    @cached_property
    def is_required(self) -> npt.NDArray[np.bool_]:
        """Whether each body is a required target, shape (bodies,)."""
        is_required = np.zeros(len(self.names), dtype=np.bool_)
        is_required[self.instance.first_target :] = [
            target.required for target in self.instance.targets
        ]
        is_required.setflags(write=False)
        return is_required

    @cached_property
    def required(self) -> frozenset[int]:
        """Targets that every plan must service."""
        return frozenset(np.flatnonzero(self.is_required).tolist())

    @cached_property
    def falls(self) -> Falls | None:
        """Losses of prizes with time, as kernels take them; None if no prize falls."""
        targets = self.instance.targets
        if all(target.prize_until is None for target in targets):
            return None
        first = np.zeros(len(self.names) + 1, dtype=np.int64)
        levels = [target.prize_until or () for target in targets]
        first[self.instance.first_target + 1 :] = np.cumsum([len(each) for each in levels])
        until = [until_s + SLACK_S for each in levels for until_s, _ in each]
        # Differences of prizes as written would not be multiples of what prizes are multiples of.
        unit = common_step(prize for target in targets for prize in target.prizes) or 1.0
        lost = [
            unit * (round(target.greatest_prize / unit) - round(prize / unit))
            for target in targets
            for prize in target.prizes[1:]
        ]
        made = Falls(first, np.array(until), np.array(lost), unit)
        for array in made[:3]:
            array.setflags(write=False)
        return made

    @cached_property
    def prize_step(self) -> float:
        """Common divisor of all objectives, to which bounds may be rounded; 0 if none."""
        prizes = [prize for target in self.instance.targets for prize in target.prizes]
        return common_step(prizes, len(self.required))

    @cached_property
    def step_slack(self) -> float:
        """Largest shortfall of a computed bound [steps]."""
        if not self.prize_step:
            return 0.0
        steps = self.all_worth / self.prize_step
        return max(ROUNDING, min(MOST_GUARD, GUARD * steps))

    @cached_property
    def step_margin(self) -> float:
        """Distance below the next step at which it is sought, well above the slack [steps]."""
        return max(MARGIN, min(MOST_MARGIN, 4.0 * self.step_slack))

    @cached_property
    def prize_resolution(self) -> float:
        """Difference up to which objectives are equal: half a step, or else a share of all prizes.

        That is, the resolution of arithmetic, not a tolerance of convenience.
        """
        return 0.5 * self.prize_step if self.prize_step else RELATIVE * (self.all_prize or 1.0)

    @property
    def rounding(self) -> float:
        """Largest shortfall of a computed bound."""
        return self.step_slack * self.prize_step if self.prize_step else self.prize_resolution

    @cached_property
    def bound_guard(self) -> float:
        """Increase of a proven value before verification, to cover rounding there."""
        return (0.5 if self.prize_step else 0.125) * self.rounding

    @cached_property
    def threshold_guard(self) -> float:
        """Increase of an unreachable threshold, with more room below the next step."""
        margin = self.step_margin * self.prize_step if self.prize_step else self.prize_resolution
        return 0.25 * margin

    def rounded_down(self, bound: float) -> float:
        """A bound on the worth of plans, rounded down to whole steps."""
        return rounded_down(bound, self.prize_step, self.step_slack)

    def meets(self, incumbent: float, bound: float) -> bool:
        """Whether no better objective fits within a bound: the gap is less than a step.

        Without a step, whether no more is left than arithmetic can tell.
        """
        return incumbent >= self.rounded_down(bound) - self.prize_resolution

    @property
    def most_targets(self) -> int | None:
        """Maximum number of targets; ``None`` if unlimited."""
        most = [most_targets(self.instance, chaser) for chaser in self.instance.chasers]
        return None if None in most else sum(filter(None, most))

    @property
    def total_prize(self) -> float:
        """Sum of the largest prizes within the maximum number of targets: the trivial bound."""
        return self._largest([target.greatest_prize for target in self.instance.targets])

    @property
    def total_worth(self) -> float:
        """Sum of the largest worths to planners within the maximum number of targets."""
        return self._largest(self.planning_prizes.tolist())

    @property
    def all_prize(self) -> float:
        """Sum of all prizes, each the greatest."""
        return math.fsum(target.greatest_prize for target in self.instance.targets)

    @property
    def all_worth(self) -> float:
        """Sum of all targets' worths to planners."""
        return math.fsum(self.planning_prizes)

    def _largest(self, prizes: list[float]) -> float:
        return math.fsum(sorted(prizes, reverse=True)[: self.most_targets])

    def worth(self, prizes: float) -> float:
        """Worth to planners of a plan with all required targets, by the sum of its prizes."""
        return prizes + len(self.required) * self.bonus

    def shown(self, worth: float) -> float:
        """Sum of prizes by worth to planners; −inf if a required target is missing."""
        if not self.required or not math.isfinite(worth):
            return worth
        prizes = worth - len(self.required) * self.bonus
        # The difference of two numbers that large has lost digits.
        step = self.prize_step
        if step:
            whole = step * round(prizes / step)
            if abs(prizes - whole) < self.step_slack * step:
                prizes = whole
        elif abs(prizes) <= ROUNDED * abs(worth):
            prizes = 0.0
        return prizes if prizes >= 0.0 else -math.inf

    def collected(self, bodies: Iterable[int]) -> float:
        """Worth of bodies to planners, in any order; of falling prizes the greatest."""
        return math.fsum(self.planning_prizes[j] for j in bodies)

    def prizes(self, bodies: Sequence[int], ends_s: Sequence[float]) -> float:
        """Sum of the prizes of bodies, by the ends of their services [s].

        Of a tow the end that it has if it follows the service at once.
        """
        first, targets = self.instance.first_target, self.instance.targets
        return math.fsum(
            targets[j - first].prize_at(end_s - SLACK_S)
            for j, end_s in zip(bodies, ends_s, strict=True)
            if j >= first
        )

    def in_steps(self, worth: float) -> float:
        """A sum of prizes and losses without the rounding of either."""
        step = self.prize_step
        return step * round(worth / step) if step and self.falls is not None else worth

    def lacking(self, bodies: Iterable[int]) -> tuple[int, ...]:
        """Required targets not among the bodies."""
        return tuple(sorted(self.required.difference(bodies)))
