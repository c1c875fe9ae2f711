"""Progress reports of a running method."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Protocol


class Progress(Protocol):
    """Callback for each new incumbent or bound; −inf and +inf mean none yet.

    One that has a method ``found`` is shown plans as well: see :func:`show_plan`.
    """

    def __call__(self, incumbent: float, bound: float) -> None:
        """Receive a report, in the thread that found it."""
        ...


def silent(incumbent: float, bound: float) -> None:
    """A progress callback that does nothing."""


def show_plan(progress: Progress, *routes: Iterable[int]) -> None:
    """Show a legal plan to a progress callback that wants to see plans, before it is reported.

    Parameters
    ----------
    progress : Progress
    *routes : iterable of int
        Bodies in order for each chaser.
    """
    found = getattr(progress, "found", None)
    if found is not None:
        found(tuple(tuple(int(body) for body in route) for route in routes))


def tell_plan(progress: Progress, objective: float, *routes: Iterable[int]) -> None:
    """Report a plan without a bound, and show it.

    Parameters
    ----------
    progress : Progress
    objective : float
    *routes : iterable of int
        Bodies in order for each chaser.
    """
    show_plan(progress, *routes)
    progress(objective, math.inf)


class Relayed:
    """A progress callback that converts incumbents and bounds for another, and passes plans on.

    Parameters
    ----------
    tell : callable
        Called with incumbent and bound.
    to : Progress
        Shown the plans.
    """

    def __init__(self, tell: Callable[[float, float], None], to: Progress) -> None:
        self._tell, self._to = tell, to

    def __call__(self, incumbent: float, bound: float) -> None:
        """Receive a report."""
        self._tell(incumbent, bound)

    def found(self, routes: tuple[tuple[int, ...], ...]) -> None:
        """Pass a plan on."""
        show_plan(self._to, *routes)
