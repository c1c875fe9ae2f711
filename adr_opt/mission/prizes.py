"""What targets are worth: prizes, what is required, and how planners hold the two together."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ..common.tolerance import RELATIVE, ROUNDED, ROUNDING, common_step, rounded_down
from ..plan.cargo import most_targets
from ..problem.instance import Instance

GUARD, MOST_GUARD = 1e-9, 0.125
"""A computed bound may be too small by this share of all worths, or by so many steps at most."""

MARGIN, MOST_MARGIN = 1e-3, 0.5
"""Plans worth a step more are asked for from so much below, or by more where steps are small beside
the sum: by several times what rounding may do [steps]."""


class Prizes:
    """The prizes of an instance, and what its targets are worth to a planner.

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
        """SHA-256 of the instance, worked out once."""
        return self.instance.sha256

    @cached_property
    def bonus(self) -> float:
        """What servicing a required target is worth to a planner, besides its prize.

        More than all prizes together, and a multiple of what they are multiples of.
        """
        prizes = [target.prize for target in self.instance.targets]
        return math.fsum(prizes) + (self.prize_step or max(prizes, default=0.0) or 1.0)

    @cached_property
    def planning_prizes(self) -> npt.NDArray[np.float64]:
        """What servicing each body is worth to a planner, shape (bodies,)."""
        worths = np.zeros(len(self.names))
        worths[self.instance.first_target :] = [
            target.prize + self.bonus * target.required for target in self.instance.targets
        ]
        worths.setflags(write=False)
        return worths

    @cached_property
    def is_required(self) -> npt.NDArray[np.bool_]:
        """Whether every plan services a body, shape (bodies,)."""
        is_required = np.zeros(len(self.names), dtype=np.bool_)
        is_required[self.instance.first_target :] = [
            target.required for target in self.instance.targets
        ]
        is_required.setflags(write=False)
        return is_required

    @cached_property
    def required(self) -> frozenset[int]:
        """The targets that every plan services."""
        return frozenset(np.flatnonzero(self.is_required).tolist())

    @cached_property
    def prize_step(self) -> float:
        """All objectives are multiples of it, so that a bound may be rounded down; 0 for none."""
        return common_step((target.prize for target in self.instance.targets), len(self.required))

    @cached_property
    def step_slack(self) -> float:
        """By how much a computed bound may be too small [steps]."""
        if not self.prize_step:
            return 0.0
        steps = self.all_worth / self.prize_step
        return max(ROUNDING, min(MOST_GUARD, GUARD * steps))

    @cached_property
    def step_margin(self) -> float:
        """How far below the next step it is asked for, well more than the slack [steps]."""
        return max(MARGIN, min(MOST_MARGIN, 4.0 * self.step_slack))

    @cached_property
    def prize_resolution(self) -> float:
        """Objectives that differ by no more are equal: half a step; a share of all prizes without.

        That is, what arithmetic can tell apart, not what anybody would like to neglect.
        """
        return 0.5 * self.prize_step if self.prize_step else RELATIVE * (self.all_prize or 1.0)

    @property
    def rounding(self) -> float:
        """By how much a computed bound may be too small."""
        return self.step_slack * self.prize_step if self.prize_step else self.prize_resolution

    @cached_property
    def bound_guard(self) -> float:
        """What a proven value is raised by before others verify it, against their rounding."""
        return (0.5 if self.prize_step else 0.125) * self.rounding

    @cached_property
    def threshold_guard(self) -> float:
        """The same of a threshold that nothing reaches, which has more room below the next step."""
        margin = self.step_margin * self.prize_step if self.prize_step else self.prize_resolution
        return 0.25 * margin

    def rounded_down(self, bound: float) -> float:
        """A bound on what plans are worth: the largest whole number of steps that it allows."""
        return rounded_down(bound, self.prize_step, self.step_slack)

    def meets(self, incumbent: float, bound: float) -> bool:
        """Whether no objective is above an incumbent and within a bound: less than a step is left.

        Without a step, whether no more is left than arithmetic can tell.
        """
        return incumbent >= self.rounded_down(bound) - self.prize_resolution

    @property
    def most_targets(self) -> int | None:
        """So many targets may be serviced; None for all of them."""
        most = [most_targets(self.instance, chaser) for chaser in self.instance.chasers]
        return None if None in most else sum(filter(None, most))

    @property
    def total_prize(self) -> float:
        """Sum of the prizes of as many targets as may be serviced: the trivial bound."""
        return self._largest([target.prize for target in self.instance.targets])

    @property
    def total_worth(self) -> float:
        """The same of what targets are worth to a planner."""
        return self._largest(self.planning_prizes.tolist())

    @property
    def all_prize(self) -> float:
        """Sum of all prizes."""
        return math.fsum(target.prize for target in self.instance.targets)

    @property
    def all_worth(self) -> float:
        """Sum of what all targets are worth to a planner."""
        return math.fsum(self.planning_prizes)

    def _largest(self, prizes: list[float]) -> float:
        return math.fsum(sorted(prizes, reverse=True)[: self.most_targets])

    def worth(self, prizes: float) -> float:
        """What a plan with all required targets and so many prizes is worth to a planner."""
        return prizes + len(self.required) * self.bonus

    def shown(self, worth: float) -> float:
        """The prizes of what is worth so much to a planner; −inf if it lacks a required target."""
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
        """What bodies are worth to a planner; their order does not matter."""
        return math.fsum(self.planning_prizes[j] for j in bodies)

    def prizes(self, bodies: Iterable[int]) -> float:
        """Sum of the prizes of bodies."""
        first = self.instance.first_target
        return math.fsum(self.instance.targets[j - first].prize for j in bodies if j >= first)

    def lacking(self, bodies: Iterable[int]) -> tuple[int, ...]:
        """The required targets that are not among the bodies."""
        return tuple(sorted(self.required.difference(bodies)))
