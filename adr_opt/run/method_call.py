"""Methods with everything settled but the mission: found, checked, and compiled by practice."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Any, Self

from ..common.errors import InputError
from ..common.options import read
from ..common.progress import Progress, silent
from ..common.stop import Stop
from ..common.wording import counted
from ..mission.build_legs import APPROXIMATE
from ..mission.campaign import Campaign, Problem
from ..mission.certified import certify_routes
from ..mission.result import Result, noted
from ..plan.cargo import loads_of, what_counts
from ..sources.generator import LARGEST_SEED
from .methods import (
    BOUNDS,
    EXPENSE,
    KITS,
    LIMITS,
    PLANNERS,
    Planner,
    campaign_form,
    get,
    known_rules,
    names,
    options_of,
    takes_jobs,
    takes_start,
)
from .start_plan import legal_beginning
from .warm_up import Practice, asking_mission, habits, practice_campaign, practice_mission

FALLBACK = "greedy-guarded"
"""Takes a millisecond: the least that any planner returns when its time is over."""

PUBLISHED = "greedy"
"""A baseline that stays as it is."""


class _Shown:
    """A stop that is asked about prizes by methods that think in worths (:meth:`Mission.shown`)."""

    def __init__(self, mission: Problem, stop: Stop) -> None:
        self._mission = mission
        self._stop = stop

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether it is enough."""
        return self._stop(self._mission.shown(incumbent), self._mission.shown(bound))

    def remaining_s(self) -> float:
        """Time that is left [s]."""
        return self._stop.remaining_s()


def _shown(mission: Problem, progress: Progress) -> Progress:
    """A progress that is told of prizes, likewise."""

    def tell(incumbent: float, bound: float) -> None:
        progress(mission.shown(incumbent), mission.shown(bound))

    return tell


@dataclass(frozen=True)
class Prepared:
    """A method with everything settled but the mission and the stop.

    Whoever runs several methods side by side prepares each and gives them one stop.

    Attributes
    ----------
    method : str
    function : Planner
    arguments : mapping
        Seed, start and options.
    notes : tuple of str
        What a reader of the result has to know; added to it.
    plans : bool
        Whether a plan is what it is asked for.
    """

    method: str
    function: Planner
    arguments: Mapping[str, Any]
    notes: tuple[str, ...] = ()
    plans: bool = True

    def __call__(self, mission: Problem, stop: Stop, progress: Progress = silent) -> Result:
        """Run the method."""
        result = form_for(mission, self.method, self.function)(
            mission, stop=_Shown(mission, stop), progress=_shown(mission, progress),
            **self.arguments,
        )  # fmt: skip
        _check_result(self.method, result)
        if self.plans and self.method != PUBLISHED and stop.remaining_s() <= 0.0:
            result = self._at_least_the_fallback(mission, result, stop, progress)
        return noted(result, self.notes)

    def beginning_from(
        self, mission: Problem, destinations: tuple[tuple[str, ...], ...], repair: bool
    ) -> Self:
        """The same from a start plan, or from as much of each of its routes as is legal."""
        notes, routes = self.notes, []
        done: set[str] = set()
        for each, wanted in zip(mission.missions, destinations, strict=True):
            # What was another chaser's is nobody else's; without repair it was refused.
            left = takewhile(lambda name: name not in done, wanted)
            sequence = legal_beginning(each, left, repair=repair)
            routes.append(sequence)
            done.update(each.names[j] for j in sequence if not each.rules.is_station[j])
            if len(sequence) < len(wanted):
                kept = f"only the first {len(sequence)}" if sequence else "none"
                legs = counted(len(wanted), "leg")
                whose = "" if len(destinations) == 1 else f" of {each.chaser.name!r}"
                notes = (*notes, f"{kept} of the start plan's {legs}{whose} could be kept")
        start = tuple(routes) if isinstance(mission, Campaign) else routes[0]
        return replace(self, arguments={**self.arguments, "start": start}, notes=notes)

    def _at_least_the_fallback(
        self, mission: Problem, result: Result, stop: Stop, progress: Progress
    ) -> Result:
        """What a method has that ran out of time, or the plan of :data:`FALLBACK` if better."""
        fallback = form_for(mission, FALLBACK, get(FALLBACK))
        quick = fallback(mission, seed=result.seed, stop=stop, progress=silent)
        if quick.objective <= result.objective:
            return result
        progress(quick.objective, result.upper_bound)
        said = [note for note in result.notes if note != APPROXIMATE]  # certify says it again
        return certify_routes(
            mission, self.method, quick.routes,
            seed=result.seed, runtime_s=result.runtime_s,
            upper_bound=mission.worth(result.upper_bound),
            evidence=result.evidence,
            counters=result.counters,
            notes=[*said, f"{self.method} ran out of time: the plan is that of {FALLBACK}"],
        )  # fmt: skip


def _check_result(method: str, result: object) -> None:
    """Refuse what is no result.

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
    """Find a method and check everything that it is to be called with but the start plan.

    Raises
    ------
    InputError
        As in :func:`adr_opt.solve`.
    """
    if not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"seed = {seed}: must be between 0 and {LARGEST_SEED}")
    function = method_of(method, group)
    chosen = dict(options or {})
    if jobs is not None:
        if not takes_jobs(function):
            raise InputError(
                f"jobs = {jobs}: method {method!r} uses one core; leave it out"
                f"{_others(group, takes_jobs)}"
            )
        if "jobs" in chosen:
            raise InputError("jobs is given twice, also as an option of the method; give it once")
        chosen["jobs"] = jobs
    if repair and not starts:
        raise InputError("repair mends a start plan, but none is given; give one with start")
    if starts and not takes_start(function):
        raise InputError(
            f"method {method!r} takes no start plan; leave it out{_others(group, takes_start)}"
        )
    arguments = {"seed": seed, "options": read(options_of(function), chosen)}
    return Prepared(method, function, arguments, plans=group == PLANNERS)


def method_of(name: str, group: str = PLANNERS) -> Planner:
    """The planner (or bound) of a name, ready to be called.

    Raises
    ------
    InputError
        There is none of that name, or it is declared but cannot be imported.
    """
    if group == BOUNDS and not names(group):
        raise InputError(
            f"bound {name!r} is unknown and none is installed; "
            f"install a package with an entry point in the group {BOUNDS!r}"
        )
    try:
        return get(name, group)
    except (ImportError, AttributeError) as error:
        raise InputError(
            f"method {name!r} is declared, but cannot be imported ({error}); "
            "install the package that declares it anew"
        ) from error


def _others(group: str, able: Callable[[Planner], bool]) -> str:
    """The end of a sentence that says which methods are able to do something."""
    found = []
    for name in names(group):
        try:
            if able(get(name, group)):
                found.append(name)
        except (ImportError, AttributeError, InputError):
            continue  # cannot be recommended; asked for by name, it says why
    return f", or use one of: {', '.join(found)}" if found else ""


def form_for(problem: Problem, name: str, function: Planner) -> Planner:
    """The function of a method that plans a mission or a campaign.

    Raises
    ------
    InputError
        It plans for one chaser, and there are several; or does not know a rule that counts.
    """
    if not isinstance(problem, Campaign):
        return function
    instance, found = problem.instance, campaign_form(function)
    counts = _rules_of(problem)
    if found is not None and counts <= known_rules(function):
        return found
    able = ", ".join(
        f"{other} ({group.rsplit('.', 1)[1]})" if group == BOUNDS else other
        for group in (PLANNERS, BOUNDS)
        for other in names(group)
        if _plans_campaigns(other, group, counts)
    )
    chasers = len(instance.chasers)
    why = f"is for one chaser, and {instance.name!r} has {chasers}"
    if found is not None or chasers == 1:
        unknown = sorted(counts - (known_rules(function) if found is not None else frozenset()))
        word = what_counts(instance) if unknown[0] == KITS else unknown[0]
        why = f"knows no {word}, and {_THEY[unknown[0]].format(instance.name)}"
    raise InputError(f"method {name!r} {why}; use one of: {able}")


_THEY = {
    KITS: "those of {!r} count",
    LIMITS: "those of {!r} do",
    EXPENSE: "that of {!r} is what plans are to have least of",
}
"""Why a rule counts for an instance of a name."""


def _rules_of(problem: Campaign) -> frozenset[str]:
    """The rules that count for a campaign, and that not every method knows."""
    instance = problem.instance
    loads = [loads_of(instance, chaser, problem.margin) for chaser in instance.chasers]
    counts = {
        KITS: any(each is not None for each in loads),
        LIMITS: bool(problem.limits),
        EXPENSE: instance.objective.cost == "expense",
    }
    return frozenset(word for word, does in counts.items() if does)


def _plans_campaigns(name: str, group: str, counts: frozenset[str]) -> bool:
    """Whether an installed method can be called for several chasers, by the rules that count."""
    try:
        method = get(name, group)
    except (ImportError, AttributeError, InputError):
        return False  # cannot be recommended; asked for by name, it says why
    return campaign_form(method) is not None and counts <= known_rules(method)


_warm: set[tuple[object, ...]] = set()
_warming = threading.RLock()


def warm_up(
    group: str,
    method: str,
    *stops: Stop,
    starts: bool = False,
    jobs: int | None = None,
    options: Mapping[str, Any] | None = None,
    drifts: bool = False,
    campaign: bool = False,
    asks: bool = False,
) -> Exception | None:
    """Let a method compile its kernels, by a run on a small mission, with the options asked for.

    Once in a process is enough for each choice of options.

    Parameters
    ----------
    group, method, jobs, options
        As in :func:`.front.run`.
    *stops : Stop
        They end the practice too.
    starts : bool
        Whether there will be a plan to begin from.
    drifts : bool
        Whether nodes will drift.
    campaign : bool
        Whether there will be several chasers.
    asks : bool
        Whether rows of the timetable will be worked out on demand.

    Returns
    -------
    Exception or None
        Why the method could not practise. On a mission of its own it will say so, or do better.

    Raises
    ------
    InputError
        There is no such method or option.
    """
    mission = practice_campaign(drifts) if campaign else practice_mission(drifts)
    mission = asking_mission() if asks else mission
    prepared = prepare(group, method, jobs=jobs, options=options)
    given, habit = prepared.arguments["options"], habits(prepared.function)
    # Numbers say how much is done, for which a method may have habits; texts and switches say what.
    chosen = {
        name: habit.options.get(name, value) if not isinstance(value, (str, bool)) else value
        for name, value in vars(given).items()
    }
    function = form_for(mission, method, prepared.function)
    begins = {}
    if starts and takes_start(function):
        begins["start"] = ((1,), ()) if campaign else (1,)
    told = sorted((name, repr(value)) for name, value in chosen.items())
    key = (group, method, drifts, campaign, asks, *begins, *told)
    with _warming:
        if key in _warm:
            return None
        _warm.add(key)
        try:
            result = function(
                mission, seed=0, stop=Practice(habit.rounds, *stops), progress=silent, **begins,
                options=read(type(given), chosen),
            )  # fmt: skip
            _check_result(method, result)
        except Exception as error:
            return error
    return None
