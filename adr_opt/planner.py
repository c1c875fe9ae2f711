"""What a planner is, and where planners and bounds are found."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Protocol, TypeVar

from .errors import InputError
from .mission import Mission
from .result import Result
from .stop import Stop

PLANNERS = "adr_opt.planners"
BOUNDS = "adr_opt.bounds"
"""Entry-point groups; a package that declares one of them shows up by being installed."""

MOST_JOBS = 1024
"""Most threads of a method."""


class Progress(Protocol):
    """Hears of every new incumbent or bound: −inf and +inf stand for none yet."""

    def __call__(self, incumbent: float, bound: float) -> None:
        """Hear of it; called from the thread that found it."""
        ...


class Planner(Protocol):
    """A planner or a bound: same mission, seed and work, same result.

    A method that can begin from a known plan has a parameter ``start``, a sequence of bodies or
    None; one that can use several cores has an option ``jobs``, 0 for all of them.

    Options are keyword-only parameters after ``progress``, each with a default whose type is the
    option's type; ``methods`` lists them from the signature.
    """

    def __call__(
        self, mission: Mission, *, seed: int, stop: Stop, progress: Progress, **options: Any
    ) -> Result:
        """Plan (or bound) a mission until it is enough."""
        ...


def silent(incumbent: float, bound: float) -> None:
    """A progress that hears and says nothing."""


def _found(group: str) -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in sorted(entry_points(group=group), key=lambda e: e.name)}


def names(group: str = PLANNERS) -> tuple[str, ...]:
    """Names of the installed planners (or bounds), sorted; nothing is imported."""
    return tuple(_found(group))


def get(name: str, group: str = PLANNERS) -> Planner:
    """The planner (or bound) of a name.

    Raises
    ------
    InputError
        There is none of that name; the sentence lists those there are.
    """
    found = _found(group)
    if name not in found:
        known = ", ".join(found) or "none is installed"
        raise InputError(f"method {name!r} is unknown; use one of: {known}")
    planner: Planner = found[name].load()
    return planner


def options(planner: Planner) -> dict[str, inspect.Parameter]:
    """The options of a planner, read off its signature."""
    fixed = {"seed", "stop", "progress", "start"}
    return {
        name: parameter
        for name, parameter in inspect.signature(planner).parameters.items()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY and name not in fixed
    }


LARGEST_WHOLE = 10**9
"""Largest value of an option that is a whole number, unless :func:`at_most` says less."""

Function = TypeVar("Function", bound=Callable[..., Any])


def at_most(**largest: int) -> Callable[[Function], Function]:
    """Declare the largest values of options that cost memory, or time that no stop ends."""

    def declare(planner: Function) -> Function:
        planner.__dict__["at_most"] = largest
        return planner

    return declare


def check_size(name: str, planner: Planner, option: str, value: Any) -> None:
    """Refuse a whole number that is larger than the option can be.

    Raises
    ------
    InputError
        The sentence says how large it may be.
    """
    most = {"jobs": MOST_JOBS, **getattr(planner, "at_most", {})}.get(option, LARGEST_WHOLE)
    if isinstance(value, int) and abs(value) > most:
        raise InputError(f"option {option} = {value} of method {name!r}: must be at most {most}")


def parse_option(name: str, planner: Planner, option: str, text: str) -> Any:
    """The value of an option given as text, by the type of its default.

    Raises
    ------
    InputError
        No such option, or not a value of its type.
    """
    known = options(planner)
    if option not in known:
        listed = ", ".join(known) or "it has none"
        raise InputError(f"option {option!r} of method {name!r} is unknown; use one of: {listed}")
    default = known[option].default
    try:
        if isinstance(default, bool):
            return {"true": True, "false": False}[text.lower()]
        if isinstance(default, (int, float)):
            return type(default)(text)
    except (ValueError, KeyError):
        kind = {bool: "true or false", int: "an integer", float: "a number"}[type(default)]
        raise InputError(f"option {option} = {text!r} of method {name!r}: give {kind}") from None
    return text
