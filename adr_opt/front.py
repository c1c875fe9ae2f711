"""Solve an instance: the front door of the planners."""

from __future__ import annotations

import math
from typing import Any

from .errors import InputError
from .generator import LARGEST_SEED
from .instance import Instance
from .mission import Mission
from .planner import Progress, get, options, silent
from .result import Result
from .stop import AnyOf, MaxRuntime, Stop

DEFAULT_METHOD = "ortools"
DEFAULT_TIME_LIMIT_S = 10.0


def solve(
    instance: Instance | Mission,
    method: str = DEFAULT_METHOD,
    *,
    time_limit: float = DEFAULT_TIME_LIMIT_S,
    seed: int = 0,
    stop: Stop | None = None,
    progress: Progress = silent,
    **method_options: Any,
) -> Result:
    """Plan a mission.

    Parameters
    ----------
    instance : Instance or Mission
        A :class:`Mission` brings its timetable along.
    method : str
        Name of an installed planner.
    time_limit : float
        Wall time from this call, the timetable included [s]. Quick planners end by themselves.
    seed : int
    stop : Stop, optional
        A further criterion; planning ends at whichever comes first.
    progress : callable
        Called with incumbent and bound whenever one improves.
    **method_options
        Options of the planner, see ``python -m adr_opt methods``.

    Returns
    -------
    Result

    Raises
    ------
    InputError
        Unknown method or option, or a value out of range.
    """
    clock = MaxRuntime(time_limit)
    if not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"seed = {seed}: must be between 0 and {LARGEST_SEED}")
    planner = get(method)
    known = options(planner)
    for option in method_options:
        if option not in known:
            listed = ", ".join(known) or "it has none"
            raise InputError(
                f"option {option!r} of method {method!r} is unknown; use one of: {listed}"
            )
    mission = instance if isinstance(instance, Mission) else Mission(instance)
    criterion = AnyOf(clock, stop) if stop is not None else clock
    progress(-math.inf, math.inf)
    return planner(mission, seed=seed, stop=criterion, progress=progress, **method_options)
