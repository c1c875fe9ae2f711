"""Method calls with everything settled but the mission: found, checked and warmed up."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import chain, takewhile
from typing import Any, Self, TypeVar

from ..common.errors import InputError
from ..common.options import read
from ..common.progress import Progress, Relayed, silent
from ..common.stop import Stop
from ..common.wording import counted
from ..mission.build_legs import ON_PRICES
from ..mission.certified import certify_routes
from ..mission.problem import Problem, Routes
from ..mission.result import Result, noted
from ..problem import support
from ..problem.instance import Instance
from ..problem.tours import tour_obstacle
from ..sources.generator import LARGEST_SEED
from .legal_moves import legal_beginning
from .method_spec import MethodSpec, named
from .methods import BOUNDS, PLANNERS, Planner, adapted, names, options_of, spec
from .warm_up import USUAL, PracticeKind, PracticeStop

Taken = TypeVar("Taken")

FALLBACK = "greedy-guarded"
"""Planner that takes a millisecond: when time runs out, no planner returns a worse plan."""

PUBLISHED = "greedy"
"""Baseline planner that never changes."""


class _Shown:
    """A stopping criterion in prizes, for methods that use worths (:meth:`Mission.shown`)."""

    def __init__(self, problem: Problem, stop: Stop) -> None:
        self._problem = problem
        self._stop = stop

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self._stop(self._problem.shown(incumbent), self._problem.shown(bound))

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return self._stop.remaining_s()


def _shown(problem: Problem, progress: Progress) -> Progress:
    """A progress callback that receives prizes, for methods that use worths."""

    def tell(incumbent: float, bound: float) -> None:
        progress(problem.shown(incumbent), problem.shown(bound))

    return Relayed(tell, progress)


@dataclass(frozen=True)
class Prepared:
    """A method call with everything settled but the mission and the stopping criterion.

    To run several methods side by side, prepare each and give them one stop.

    Attributes
    ----------
    spec : MethodSpec
    function : Planner
    arguments : mapping
        Seed, start and options.
    notes : tuple of str
        What a reader of the result has to know; added to it.
    plans : bool
        Whether a plan is what it is asked for.
    begun : sequence of sequences of int, optional
        Routes of :data:`FALLBACK` from before there was a timetable.
    hurried : bool
        Whether there is time for these alone.
    """

    spec: MethodSpec
    function: Planner
    arguments: Mapping[str, Any]
    notes: tuple[str, ...] = ()
    plans: bool = True
    begun: Routes | None = None
    hurried: bool = False

    @property
    def method(self) -> str:
        """Its name."""
        return self.spec.name

    @property
    def on_demand(self) -> bool:
        """Whether its timetable rows may be computed on demand."""
        return not self.spec.needs_table(self.arguments["options"])

    def __call__(self, problem: Problem, stop: Stop, progress: Progress = silent) -> Result:
        """Run the method."""
        if self.hurried:
            result = Result(self.method, seed=self.arguments["seed"])
        else:
            given, told = given_to(problem, self.spec), _shown(problem, progress)
            asked = _Shown(problem, stop)
            result = self.function(given, stop=asked, progress=told, **self.arguments)
            _check_result(self.method, result)
        late = stop.remaining_s() <= 0.0 and not is_tour(problem, self.spec)
        late = late and not problem.missions[0].has_functions
        late = late or self.hurried or self.begun is not None
        if self.plans and self.method not in (PUBLISHED, FALLBACK) and late:
            result = self._at_least_the_fallback(problem, result, progress)
        return noted(result, self.notes)

    def beginning_from(
        self, problem: Problem, destinations: tuple[tuple[str, ...], ...], repair: bool
    ) -> Self:
        """The same call from a start plan, or from the legal beginning of each of its routes."""
        notes, routes = self.notes, []
        done: set[str] = set()
        for each, wanted in zip(problem.missions, destinations, strict=True):
            # Targets of earlier chasers are dropped here; without repair this was refused.
            left = takewhile(lambda name: name not in done, wanted)
            sequence = legal_beginning(each, left, repair=repair)
            routes.append(sequence)
            done.update(each.names[j] for j in sequence if not each.rules.is_station[j])
            if len(sequence) < len(wanted):
                kept = f"only the first {len(sequence)}" if sequence else "none"
                legs = counted(len(wanted), "leg")
                whose = "" if len(destinations) == 1 else f" of {each.chaser.name!r}"
                notes = (*notes, f"{kept} of the start plan's {legs}{whose} could be kept")
        start = tuple(routes) if self.spec.several else routes[0]
        return replace(self, arguments={**self.arguments, "start": start}, notes=notes)

    def _at_least_the_fallback(
        self, problem: Problem, result: Result, progress: Progress
    ) -> Result:
        """The result of a method that ran out of time, or that of :data:`FALLBACK` if better."""
        fallback = spec(FALLBACK)
        if not fallback.quick or not support.follows_all(problem.instance, fallback.follows):
            return result
        routes = self.begun or named(fallback.quick)(problem)
        # Certifying takes longer than planning, and most methods began from these routes.
        if problem.shown(problem.collected(chain.from_iterable(routes))) <= result.objective:
            return result
        said = [note for note in result.notes if note not in ON_PRICES]  # certify says it again
        why = "found no better plan" if self.begun and not self.hurried else "ran out of time"
        made = certify_routes(
            problem,
            self.method,
            routes,
            seed=result.seed,
            runtime_s=result.runtime_s,
            upper_bound=problem.worth(result.upper_bound),
            evidence=result.evidence,
            counters=result.counters,
            notes=[*said, f"{self.method} {why}: the plan is that of {FALLBACK}"],
        )
        if made.objective <= result.objective:
            return result
        progress(made.objective, made.upper_bound)
        return made


def _check_result(method: str, result: object) -> None:
    """Refuse an invalid result.

    Raises
    ------
    InputError
        A method returned something else.
    """
    if not isinstance(result, Result):
        returned = "None" if result is None else f"an object of type {type(result).__name__}"
        raise InputError(
            f"method {method!r} returned {returned} in place of a Result; let it return what "
            "adr_opt.mission.certified.certify makes"
        )


def prepare(
    group: str,
    method: str,
    *,
    seed: int = 0,
    starts: bool = False,
    repair: bool = False,
    jobs: int | None = None,
    options: Mapping[str, Any] | None = None,
) -> Prepared:
    """Find a method and check all its arguments except the start plan.

    Raises
    ------
    InputError
        As in :func:`adr_opt.solve`.
    """
    if not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"seed = {seed}: must be between 0 and {LARGEST_SEED}")
    # Looking up what is installed takes milliseconds: once for both.
    known, function = _installed(method, group, lambda one: (one, _loaded(one)))
    chosen = dict(options or {})
    if jobs is not None:
        if not known.uses_cores:
            raise InputError(
                f"jobs = {jobs}: method {method!r} uses one core; leave it out"
                f"{_others(group, lambda other: other.uses_cores)}"
            )
        if "jobs" in chosen:
            raise InputError("jobs is given twice, also as an option of the method; give it once")
        chosen["jobs"] = jobs
    if repair and not starts:
        raise InputError("repair needs a start plan, but none is given; give one with start")
    if starts and not known.starts:
        raise InputError(
            f"method {method!r} takes no start plan; leave it out"
            f"{_others(group, lambda other: other.starts)}"
        )
    arguments = {"seed": seed, "options": read(options_of(function), chosen)}
    return Prepared(known, function, arguments, plans=group == PLANNERS)


def method_of(name: str, group: str = PLANNERS) -> Planner:
    """The planner (or bound) with a name, ready to be called.

    Raises
    ------
    InputError
        There is none of that name, or it is declared but cannot be imported.
    """
    return _installed(name, group, _loaded)


def spec_of(name: str, group: str = PLANNERS) -> MethodSpec:
    """Specification of the planner (or bound) with a name.

    Raises
    ------
    InputError
        As of :func:`method_of`.
    """
    return _installed(name, group, lambda known: known)


def _loaded(known: MethodSpec) -> Planner:
    return adapted(known.name, known.load())


def _installed(name: str, group: str, taken: Callable[[MethodSpec], Taken]) -> Taken:
    """Read a specification, with a sentence for each possible error."""
    if group == BOUNDS and not names(group):
        raise InputError(
            f"bound {name!r} is unknown and none is installed; "
            f"install a package with an entry point in the group {BOUNDS!r}"
        )
    try:
        return taken(spec(name, group))
    except (ImportError, AttributeError) as error:
        raise InputError(
            f"method {name!r} is declared, but cannot be imported ({error}); "
            "reinstall the package that declares it"
        ) from error


def _others(group: str, can: Callable[[MethodSpec], bool]) -> str:
    """End of a sentence that lists the methods with an ability."""
    found = [name for name in names(group) if _can(name, group, can)]
    return f", or use one of: {', '.join(found)}" if found else ""


def _can(name: str, group: str, ability: Callable[[MethodSpec], bool]) -> bool:
    """Whether an installed method can be called and has an ability."""
    try:
        return ability(spec(name, group))
    except (ImportError, AttributeError, InputError):
        return False  # cannot be recommended; asked for by name, it says why


def given_to(problem: Problem, method: MethodSpec) -> Any:
    """The argument of a method: the problem, or the mission of the only chaser."""
    return problem if method.several else problem.missions[0]


def is_tour(problem: Problem, method: MethodSpec) -> bool:
    """Whether a method plans a problem as a tour through time."""
    return method.tours and tour_obstacle(problem.instance) is None


def refuse_unable(problem: Problem, method: MethodSpec, group: str = PLANNERS) -> None:
    """Refuse a problem that sets what a method does not follow; say which of its group do.

    Raises
    ------
    InputError
    """
    if not support.follows_all(problem.instance, method.follows):
        support.refuse(problem.instance, method.follower, able=able(problem.instance, group))


def able(instance: Instance, group: str = PLANNERS) -> list[str]:
    """Installed planners, or bounds, that follow all rules of an instance."""
    return [
        name
        for name in names(group)
        if _can(name, group, lambda other: support.follows_all(instance, other.follows))
    ]


def warm_up(
    group: str,
    method: str,
    kind: PracticeKind = USUAL,
    *,
    jobs: int | None = None,
    options: Mapping[str, Any] | None = None,
) -> Exception | None:
    """Let a method compile its kernels by a run on a small mission, with the requested options.

    Parameters
    ----------
    group, method, jobs, options
        As in :func:`.front.run`.
    kind : PracticeKind
        Of the mission.

    Returns
    -------
    Exception or None
        Why the method could not practise. On a mission of its own it will say so, or do better.

    Raises
    ------
    InputError
        There is no such method or option.
    """
    problem = kind.problem()
    prepared = prepare(group, method, jobs=jobs, options=options)
    given, habit = prepared.arguments["options"], prepared.spec.practice
    # Numbers say how much is done, for which a method may have habits; texts and switches say what.
    chosen = {
        name: habit.options.get(name, value) if not isinstance(value, (str, bool)) else value
        for name, value in vars(given).items()
    }
    refuse_unable(problem, prepared.spec, group)
    begins: dict[str, Any] = {}
    if kind.starts and prepared.spec.starts:
        routes = ((1,), *[()] * (len(problem.missions) - 1))
        begins["start"] = routes if prepared.spec.several else routes[0]
    try:
        result = prepared.function(
            given_to(problem, prepared.spec),
            seed=0,
            stop=PracticeStop(habit.rounds),
            progress=silent,
            **begins,
            options=read(type(given), chosen),
        )
        _check_result(method, result)
        if habit.more:
            named(habit.more)(problem)
    except Exception as error:
        return error
    return None
