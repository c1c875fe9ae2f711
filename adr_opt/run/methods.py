"""Interface and look-up of planners and bounds."""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import field, fields, make_dataclass
from functools import lru_cache, partial, wraps
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any, Protocol

from ..common.errors import InputError
from ..common.options import MOST_JOBS, Options, option
from ..common.packages import load
from ..common.progress import Progress
from ..common.stop import Stop
from .method_spec import MethodSpec

if TYPE_CHECKING:
    from ..mission.result import Result

PLANNERS = "adr_opt.planners"
BOUNDS = "adr_opt.bounds"
"""Entry-point groups; a package that declares one of them is found once installed."""

REMOVED = {"cpsat": "was removed in 2.0; use 'exact', or 'mip' for a model to read"}
"""Messages about removed methods."""

FIXED = frozenset({"seed", "stop", "progress", "start"})
"""Parameters of methods besides their options."""


class Planner(Protocol):
    """A planner or a bound: the same problem, seed and work give the same result.

    A method that can begin from a known plan has a parameter ``start``, a sequence of bodies or
    None; one that has options has a parameter ``options``, whose default is those of its own
    subclass of :class:`adr_opt.common.options.Options`. One that can use several cores has an
    option ``jobs``, 0 for all of them. What else it can do is said by its
    :class:`.method_spec.MethodSpec`.
    """

    def __call__(
        self, mission: Any, /, *, seed: int, stop: Stop, progress: Progress, **more: Any
    ) -> Result:
        """Plan (or bound) a mission until told to stop."""
        ...


def _found(group: str) -> Mapping[str, EntryPoint]:
    places = tuple((place, _changed_ns(place)) for place in sys.path)
    return _entries(group, entry_points, places)


def _changed_ns(place: str) -> int | None:
    try:
        return os.stat(place or os.curdir).st_mtime_ns
    except OSError:
        return None


@lru_cache(maxsize=16)
def _entries(group: str, read: Callable[..., Any], places: object) -> Mapping[str, EntryPoint]:
    """Entry points by name; kept, as reading what is installed takes longer than a small plan."""
    entries = sorted(read(group=group), key=lambda entry: entry.name)
    return {entry.name: entry for entry in entries}


def names(group: str = PLANNERS) -> tuple[str, ...]:
    """Names of the installed planners (or bounds), sorted; nothing is imported."""
    return tuple(_found(group))


def spec(name: str, group: str = PLANNERS) -> MethodSpec:
    """Specification of the planner (or bound) with a name.

    Raises
    ------
    InputError
        There is none of that name, and the sentence lists those there are or says that it was
        removed; or what is installed under it cannot be called as planners are.
    """
    found = _found(group)
    if name not in found:
        if name in REMOVED:
            raise InputError(f"method {name!r} {REMOVED[name]}")
        known = ", ".join(found) or "none is installed"
        raise InputError(f"method {name!r} is unknown; use one of: {known}")
    loaded = load(found[name])
    return loaded if isinstance(loaded, MethodSpec) else spec_of_function(name, loaded)


def get(name: str, group: str = PLANNERS) -> Planner:
    """The planner (or bound) with a name, imported.

    Raises
    ------
    InputError
        As of :func:`spec`.
    """
    return adapted(name, spec(name, group).load())


def spec_of_function(name: str, planner: Any) -> MethodSpec:
    """Specification of a function without one, from its parameters.

    Raises
    ------
    InputError
        It cannot be called as planners are.
    """
    function = adapted(name, planner)
    return MethodSpec(
        name,
        planner,
        starts="start" in inspect.signature(function).parameters,
        uses_cores=any(each.name == "jobs" for each in fields(options_of(function))),
    )


def adapted(name: str, planner: Any) -> Planner:
    """An installed method in the form called here, with its options in a class.

    Raises
    ------
    InputError
        It cannot be called as planners are.
    """
    _check_signature(name, planner)
    made: Planner = planner if _options(planner) else _with_options(name, planner)
    return made


def _check_signature(name: str, planner: Any) -> None:
    """Refuse functions that cannot be called as planners.

    Raises
    ------
    InputError
        It is no function, or one that takes other arguments.
    """
    wanted = "planners are functions of (mission, *, seed, stop, progress)"
    if not callable(planner):
        raise InputError(
            f"method {name!r} is of type {type(planner).__name__} and cannot be called; {wanted}"
        )
    signature = inspect.signature(planner)
    try:
        signature.bind(None, seed=0, stop=None, progress=None)
    except TypeError as error:
        raise InputError(
            f"method {name!r} takes {signature} ({error}); {wanted}, and further parameters need "
            "defaults"
        ) from None


def options_of(planner: Planner) -> type[Options]:
    """Class of the options of a method from :func:`get`."""
    found = _options(planner)
    assert found is not None
    return type(found)


def _options(planner: Planner) -> Options | None:
    """The default options of a method, if it has a class for them."""
    parameter = inspect.signature(planner).parameters.get("options")
    default = None if parameter is None else parameter.default
    return default if isinstance(default, Options) else None


def _with_options(name: str, planner: Callable[..., Result]) -> Planner:
    """A method with keyword-only options, called with an options object."""
    signature = inspect.signature(planner)
    fixed: list[inspect.Parameter] = []
    declared: list[tuple[str, type, Any]] = []
    for parameter in signature.parameters.values():
        default: Any = parameter.default
        if parameter.kind is not parameter.KEYWORD_ONLY or parameter.name in FIXED:
            if parameter.kind is not parameter.VAR_KEYWORD:
                fixed.append(parameter)
        elif parameter.name == "jobs":
            jobs = option(default, "Number of cores; 0 for all.", least=0, most=MOST_JOBS)
            declared.append((parameter.name, int, jobs))
        else:
            # A list, for example, cannot be the default of a field.
            made = field(default_factory=partial(copy, default))
            declared.append((parameter.name, type(default), made))
    kind = make_dataclass(
        "ItsOptions", declared, bases=(Options,), frozen=True, namespace={"_method": name}
    )

    called = _with_keywords(planner)
    shown = inspect.Parameter("options", inspect.Parameter.KEYWORD_ONLY, default=kind())
    called.__dict__["__signature__"] = signature.replace(parameters=[*fixed, shown])
    return called


def _with_keywords(planner: Callable[..., Result]) -> Planner:
    """A function with keyword-only options, called with an options object."""

    @wraps(planner)
    def called(*given: Any, options: Any = None, **more: Any) -> Result:
        return planner(*given, **more, **({} if options is None else vars(options)))

    return called
