"""Specifications of planners and bounds: their abilities, stated without importing them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from ..problem.rules import FIRST, TOURS, Follower, check_words


@dataclass(frozen=True)
class Practice:
    """Practice of a method in :func:`.front.warm_up`, which compiles its kernels.

    Attributes
    ----------
    rounds : int
        How often it may ask whether it is enough.
    options : mapping
        Numbers that it is called with.
    more : str
        ``module:function`` that compiles, for a problem, what a short run need not reach.
    """

    rounds: int = 3
    options: Mapping[str, Any] = field(default_factory=dict)
    more: str = ""


def named(reference: str) -> Callable[..., Any]:
    """The function of a ``module:function``."""
    module, _, function = reference.partition(":")
    found: Callable[..., Any] = getattr(import_module(module), function)
    return found


@dataclass(frozen=True)
class MethodSpec:
    """Abilities of a planner or a bound.

    Entry points of the groups ``adr_opt.planners`` and ``adr_opt.bounds`` name one, or a function,
    which is then a method for one chaser that can do what its parameters say, and no more.

    Attributes
    ----------
    name : str
    function : str or callable
        Where the method is, ``"package.module:function"``, imported by :meth:`load`.
    follows : frozenset of str
        Words of :data:`adr_opt.problem.rules.RULES`: instances with other rules are refused. With
        "several chasers" it is given an :class:`adr_opt.mission.problem.Problem`, with one start
        route for each chaser, and otherwise the :class:`adr_opt.mission.mission.Mission` of the
        only chaser, with its route. By default what every method of 1.0 followed.
    starts : bool
        Whether it can begin from a known plan.
    uses_cores : bool
        Whether it has an option ``jobs``.
    shows_evidence : bool
        Whether its results say what their bounds rest on, so that certificates can be made.
    bounds_all_pairs : bool
        Whether its bounds hold of all pairs of bodies, whatever the timetable has.
    on_demand : bool
        Whether it looks up chosen connections of few pairs only, and needs no table of all pairs.
    orders_all : bool
        Whether it needs no timetable where all targets are put in order
        (:attr:`adr_opt.mission.problem.Problem.asks_for_least_end`).
    begins : str
        ``module:function`` that gives the first routes of a problem before there is a timetable, or
        none; it takes the problem, ``seed``, ``stop`` and ``progress``.
    quick : str
        ``module:function`` that gives the method's routes of a problem in no time, or none.
    table_options : tuple of str
        Options that make it need that table if they are set.
    practice : Practice
    """

    name: str
    function: str | Callable[..., Any]
    follows: frozenset[str] = FIRST
    starts: bool = False
    uses_cores: bool = False
    shows_evidence: bool = False
    bounds_all_pairs: bool = False
    on_demand: bool = False
    orders_all: bool = False
    begins: str = ""
    quick: str = ""
    table_options: tuple[str, ...] = ()
    practice: Practice = field(default_factory=Practice)

    def __post_init__(self) -> None:
        check_words(f"method {self.name!r}", self.follows)

    @property
    def follower(self) -> Follower:
        """The method as one that follows rules."""
        return Follower(f"method {self.name!r}", self.follows)

    @property
    def several(self) -> bool:
        """Whether it plans for several chasers, and takes an adr_opt.mission.problem.Problem."""
        return "several chasers" in self.follows

    @property
    def tours(self) -> bool:
        """Whether it plans tours through time (:mod:`adr_opt.problem.tours`), with no timetable."""
        return self.follows >= TOURS

    def load(self) -> Any:
        """The method itself, imported.

        Raises
        ------
        ImportError, AttributeError
            It is not where it is said to be.
        """
        if not isinstance(self.function, str):
            return self.function
        return named(self.function)

    def needs_table(self, options: object) -> bool:
        """Whether a method with some options needs all pairs in the timetable."""
        return not self.on_demand or any(getattr(options, name) for name in self.table_options)
