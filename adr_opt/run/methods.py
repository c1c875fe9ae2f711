"""What a planner is, and where planners and bounds are found."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from copy import copy
from dataclasses import field, fields, make_dataclass
from functools import partial, wraps
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Protocol, TypeVar

from ..common.errors import InputError
from ..common.options import MOST_JOBS, Options, option
from ..common.progress import Progress
from ..common.stop import Stop
from ..mission.result import Result

PLANNERS = "adr_opt.planners"
BOUNDS = "adr_opt.bounds"
"""Entry-point groups; a package that declares one of them shows up by being installed."""

Method = TypeVar("Method", bound=Callable[..., object])

FIXED = frozenset({"seed", "stop", "progress", "start"})
"""Parameters of methods that are no options."""


class Planner(Protocol):
    """A planner or a bound: same mission, seed and work, same result.

    A method that can begin from a known plan has a parameter ``start``, a sequence of bodies or
    None; one that has options has a parameter ``options``, whose default is those of its own
    subclass of :class:`adr_opt.common.options.Options`. One that can use several cores has an
    option ``jobs``, 0 for all of them. One that plans for several chasers is decorated with
    :func:`for_campaigns`.
    """

    def __call__(
        self, mission: Any, *, seed: int, stop: Stop, progress: Progress, **more: Any
    ) -> Result:
        """Plan (or bound) a mission until it is enough."""
        ...


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
        There is none of that name; the sentence lists those there are. Or what is installed under
        it cannot be called as planners are.
    """
    found = _found(group)
    if name not in found:
        known = ", ".join(found) or "none is installed"
        raise InputError(f"method {name!r} is unknown; use one of: {known}")
    return adapted(name, found[name].load())


def adapted(name: str, planner: Any) -> Planner:
    """What is installed under a name, as it is called here: its options are those of a class.

    Raises
    ------
    InputError
        It cannot be called as planners are.
    """
    _check_signature(name, planner)
    several = campaign_form(planner)
    if several is not None:
        _check_signature(f"{name} for several chasers", several)
    made: Planner = planner if _options(planner) else _with_options(name, planner)
    return made


def _check_signature(name: str, planner: Any) -> None:
    """Refuse what cannot be called as planners are.

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


_CAMPAIGN, _KNOWN, _EVIDENCE = "campaign_form", "known_rules", "shows_evidence"

KITS, LIMITS, EXPENSE = "kits", "stations that run empty", "expense"
"""Rules of campaigns that not every method knows."""


def shows_evidence(method: Method) -> Method:
    """Decorate a method whose results say what their bounds rest on."""
    setattr(method, _EVIDENCE, True)
    return method


def for_campaigns(
    planner: Callable[..., Result], *, kits: bool = True, limits: bool = True, expense: bool = True
) -> Callable[[Method], Method]:
    """Decorate a method with the function that does the same for several chasers.

    Parameters
    ----------
    planner : Planner
        Takes a :class:`adr_opt.mission.campaign.Campaign` in place of a mission, and for ``start``,
        if it takes one, a route for each chaser.
    kits : bool
        Whether it plans with what chasers carry, where that counts (``rules.loads``).
    limits : bool
        Whether it keeps to what stations have for all chasers together.
    expense : bool
        Whether it plans for little expense.
    """
    known = {KITS: kits, LIMITS: limits, EXPENSE: expense}

    def decorate(method: Method) -> Method:
        setattr(method, _CAMPAIGN, planner)
        setattr(method, _KNOWN, frozenset(word for word, knows in known.items() if knows))
        return method

    return decorate


def campaign_form(planner: Planner) -> Planner | None:
    """The function that does for several chasers what a method does for one; None without one."""
    found: Planner | None = getattr(planner, _CAMPAIGN, None)
    return found


def known_rules(planner: Planner) -> frozenset[str]:
    """The rules of :data:`KITS`, :data:`LIMITS` and :data:`EXPENSE` that a method plans with."""
    found: frozenset[str] = getattr(planner, _KNOWN, frozenset())
    return found


def has_evidence(planner: Planner) -> bool:
    """Whether the results of a method say what their bounds rest on."""
    return bool(getattr(planner, _EVIDENCE, False))


_ALL_PAIRS = "bounds_all_pairs"


def bounds_all_pairs(method: Method) -> Method:
    """Decorate a method whose bounds hold of all pairs of bodies, whatever the timetable has."""
    setattr(method, _ALL_PAIRS, True)
    return method


def knows_all_pairs(planner: Planner) -> bool:
    """Whether bounds of a method hold of all pairs of bodies."""
    return bool(getattr(planner, _ALL_PAIRS, False))


_ON_DEMAND = "plans_on_demand"


def plans_on_demand(
    unless: Callable[[Any], bool] = lambda options: False,
) -> Callable[[Method], Method]:
    """Decorate a method that looks up what is chosen of few pairs, and needs no table of them.

    Parameters
    ----------
    unless : callable
        Whether it does need one with options of its own.
    """

    def decorate(method: Method) -> Method:
        setattr(method, _ON_DEMAND, unless)
        return method

    return decorate


def needs_no_table(planner: Planner, options: Any) -> bool:
    """Whether rows of the timetable may be worked out on demand for a method with some options."""
    unless: Callable[[Any], bool] | None = getattr(planner, _ON_DEMAND, None)
    return unless is not None and not unless(options)


def options_of(planner: Planner) -> type[Options]:
    """The class of the options of a method that :func:`get` has found."""
    found = _options(planner)
    assert found is not None
    return type(found)


def takes_start(planner: Planner) -> bool:
    """Whether a method can begin from a known plan."""
    return "start" in inspect.signature(planner).parameters


def takes_jobs(planner: Planner) -> bool:
    """Whether a method can use several cores."""
    return any(each.name == "jobs" for each in fields(options_of(planner)))


def _options(planner: Planner) -> Options | None:
    """The default options of a method, if it has a class for them."""
    parameter = inspect.signature(planner).parameters.get("options")
    default = None if parameter is None else parameter.default
    return default if isinstance(default, Options) else None


def _with_options(name: str, planner: Callable[..., Result]) -> Planner:
    """A method whose options are keyword-only parameters, called with an object of a class."""
    signature = inspect.signature(planner)
    fixed: list[inspect.Parameter] = []
    declared: list[tuple[str, type, Any]] = []
    for parameter in signature.parameters.values():
        default: Any = parameter.default
        if parameter.kind is not parameter.KEYWORD_ONLY or parameter.name in FIXED:
            if parameter.kind is not parameter.VAR_KEYWORD:
                fixed.append(parameter)
        elif parameter.name == "jobs":
            jobs = option(default, "Cores, 0 for all.", least=0, most=MOST_JOBS)
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
    several = campaign_form(planner)
    if several is not None and "options" not in inspect.signature(several).parameters:
        setattr(called, _CAMPAIGN, _with_keywords(several))
    return called


def _with_keywords(planner: Callable[..., Result]) -> Planner:
    """A function with keyword-only options, called with an object of a class."""

    @wraps(planner)
    def called(*given: Any, options: Any = None, **more: Any) -> Result:
        return planner(*given, **more, **({} if options is None else vars(options)))

    return called
