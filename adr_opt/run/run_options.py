"""Settings of one run of a planner or a bound."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..plan.plan import Plan

Start = Plan | Iterable[int | str] | Iterable[Iterable[int | str]]
"""A plan, or its bodies in order; for several chasers, one sequence each."""


DEFAULT_METHOD = "auto"
DEFAULT_BOUND = "exact"
"""Default bound, which proves most kinds of missions, several chasers included."""
DEFAULT_TIME_LIMIT_S = 10.0
DEFAULT_BOUND_TIME_LIMIT_S = 60.0


@dataclass(frozen=True)
class RunOptions:
    """Settings of one run; the parameters of :func:`adr_opt.solve` explain each.

    Attributes
    ----------
    time_limit : float
        Wall time, the timetable included [s].
    seed : int
    start : Plan or sequence of int or str, optional
    repair : bool
    jobs : int, optional
    iterations : int, optional
    bound : str, optional
        Name of a bound to run beside the method.
    margin : float
        Share of each tank that is kept back.
    memory_gib : float, optional
        Most memory of the timetable [GiB].
    options : mapping
        Those of the method; they may have any names, those of the above included.
    """

    time_limit: float
    seed: int = 0
    start: Start | None = None
    repair: bool = False
    jobs: int | None = None
    iterations: int | None = None
    bound: str | None = None
    margin: float = 0.0
    memory_gib: float | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
