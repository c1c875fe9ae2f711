"""Interface between the driver of a proof and a solver."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class SolverAnswer(NamedTuple):
    """Answer of a solver for a network.

    Attributes
    ----------
    legs : tuple of int or None
        Of the best path it knows, in any order.
    upper_bound : float
        Proven: no path of the network is worth more. +inf if nothing was proven.
    nodes : int
        Nodes or branches of its search.
    """

    legs: tuple[int, ...] | None
    upper_bound: float
    nodes: int


class Hear(NamedTuple):
    """Callback for a solver's progress.

    Attributes
    ----------
    bound : callable
        Told a bound on the paths of the network; says whether to stop.
    remaining_s : callable
        Seconds that may still be used.
    """

    bound: Callable[[float], bool]
    remaining_s: Callable[[], float]
