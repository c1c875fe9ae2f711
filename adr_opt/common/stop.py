"""Stopping criteria: small objects that tell a planner, from its incumbent and bound, to stop."""

from __future__ import annotations

import math
from typing import Protocol

from .clock import now_s
from .errors import InputError
from .tolerance import meets


class TimeIsOver(Exception):
    """An evaluation was interrupted by its stopping criterion."""


class Stop(Protocol):
    """A criterion asked once per iteration; the planner defines its iterations."""

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop.

        Parameters
        ----------
        incumbent : float
            Objective of the best plan so far; −inf if there is none.
        bound : float
            Best proven upper bound so far; +inf if there is none.
        """
        ...

    def remaining_s(self) -> float:
        """Remaining time [s], +inf without a limit: for phases that cannot ask."""
        return math.inf


class AnyOf(Stop):
    """Stops as soon as one of its criteria does; every criterion is asked every time."""

    def __init__(self, *criteria: Stop) -> None:
        self._criteria = criteria

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return any([criterion(incumbent, bound) for criterion in self._criteria])

    def remaining_s(self) -> float:
        """Remaining time of the criterion that has the least [s]."""
        return min((criterion.remaining_s() for criterion in self._criteria), default=math.inf)


class Clock(Stop):
    """The time limit of another criterion, which is not asked: for phases without iterations."""

    def __init__(self, stop: Stop) -> None:
        self._stop = stop

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self.remaining_s() <= 0.0

    def remaining_s(self) -> float:
        """Remaining time of the other criterion [s]."""
        return self._stop.remaining_s()


class Interrupted(Stop):
    """Stops once :meth:`interrupt` has been called, by a signal handler or another thread."""

    def __init__(self) -> None:
        self.is_set = False

    def interrupt(self) -> None:
        """Ask the planner to return its best plan at the next opportunity."""
        self.is_set = True

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self.is_set

    def remaining_s(self) -> float:
        """Remaining time: 0 once interrupted, +inf before [s]."""
        return 0.0 if self.is_set else math.inf


class MaxIterations(Stop):
    """Stops once it has been asked more than ``limit`` times, which is reproducible.

    Raises
    ------
    InputError
        The limit is not positive.
    """

    def __init__(self, limit: int) -> None:
        if limit <= 0:
            raise InputError(f"iterations = {limit}: must be positive")
        self._left = limit

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        self._left -= 1
        return self._left < 0


class MaxRuntime(Stop):
    """Stops after a number of seconds, counted from its construction.

    Raises
    ------
    InputError
        The limit is not positive.
    """

    def __init__(self, limit_s: float) -> None:
        if not limit_s > 0.0 or math.isnan(limit_s):
            raise InputError(f"time limit = {limit_s:g}: must be positive, in seconds")
        self._end = now_s() + limit_s

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self.remaining_s() <= 0.0

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return self._end - now_s()


class NoImprovement(Stop):
    """Stops once it has been asked ``limit`` times in a row without a better incumbent.

    Raises
    ------
    InputError
        The limit is not positive.
    """

    def __init__(self, limit: int) -> None:
        if limit <= 0:
            raise InputError(f"iterations without improvement = {limit}: must be positive")
        self._limit = limit
        self._best = -math.inf
        self._stale = 0

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        if incumbent > self._best:
            self._best = incumbent
            self._stale = 0
        else:
            self._stale += 1
        return self._stale >= self._limit


class Proven(Stop):
    """Stops once the incumbent meets the bound."""

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return meets(incumbent, bound)
