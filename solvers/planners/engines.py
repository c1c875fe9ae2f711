"""The table of engines of ``auto`` and ``exact``: the first that serves a mission plans it.

The page *Planners and bounds* has the same table, made by :func:`page_table`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result
from adr_opt.problem.tours import tour_obstacle

from . import label_setting, many_routes, one_route, timed_routes, tours


class PlanCall(Protocol):
    """Interface of all engines."""

    def __call__(
        self,
        method: str,
        problem: Problem,
        *,
        seed: int,
        stop: Stop,
        progress: Progress,
        start: Iterable[Iterable[int]] | None,
        options: Any,
    ) -> Result:
        """Plan a problem that the engine serves, for the method whose options these are."""
        ...


@dataclass(frozen=True)
class PlanningEngine:
    """An engine: a planning method, the missions that it serves, and its proofs.

    Attributes
    ----------
    missions : str
        What it is for, in words.
    serves : callable
        The same of a problem.
    search : str
        How it finds plans.
    proves : mapping of str to str
        What it proves, and by what, for each method that uses it.
    plans : mapping of str to callable
        Its function for each of these methods.
    """

    missions: str
    serves: Callable[[Problem], bool]
    search: str
    proves: Mapping[str, str]
    plans: Mapping[str, PlanCall] = field(repr=False)


ENGINES = (
    PlanningEngine(
        "[launched chasers](campaigns.md#missions-one-after-another), all alike, that service all "
        "targets",
        lambda problem: tour_obstacle(problem.instance) is None,
        "up to eight targets: all orders and times; more: tours through time, annealed and crossed",
        {"auto": "nothing of the cost", "exact": "a bound on the expense: walks over time cells"},
        {"auto": tours.search, "exact": tours.prove},
    ),
    PlanningEngine(
        "arrivals that are [functions of time](given-costs.md#functions-of-time)",
        lambda problem: problem.missions[0].has_functions,
        "the route engine: ruin and recreate in continuous time",
        dict.fromkeys(
            ("auto", "exact"),
            "of one chaser, the least end of a tour of all of up to 100 targets: the earliest time "
            "of each set and place; else prizes, then the cost: as the last rows, on optimistic "
            "connections",
        ),
        dict.fromkeys(("auto", "exact"), timed_routes.plan),
    ),
    PlanningEngine(
        "[all targets as early as possible](given-costs.md#the-earliest-end-of-all-targets), on "
        "given connections",
        lambda problem: problem.asks_for_least_end,
        "the same",
        {"auto": "of up to 100 targets, the end: by sets and places"},
        {"auto": timed_routes.plan},
    ),
    PlanningEngine(
        "one chaser",
        lambda problem: problem.alone is not None,
        "beams, strings of targets taken out and put back",
        {
            "auto": "prizes: multipliers, then labels whose memory grows; then the cost, by labels",
            "exact": "prizes and, if asked for, the cost: the same, to the end",
        },
        {"auto": one_route.plan, "exact": label_setting.plan},
    ),
    PlanningEngine(
        "several chasers, loads, expense, limits of stations",
        lambda problem: True,
        "pools of routes, packed and exchanged",
        {
            "auto": "prizes: columns, cuts by three targets; then the cost, by columns",
            "exact": "prizes and, if asked for, the cost: the same, to the end",
        },
        dict.fromkeys(("auto", "exact"), many_routes.plan),
    ),
)
"""All engines. Of those that a method uses, the first that serves a problem plans it."""


def engine_for(method: str, problem: Problem) -> PlanningEngine:
    """The engine by which ``auto`` or ``exact`` plans a problem."""
    return next(each for each in ENGINES if method in each.plans and each.serves(problem))


def page_table() -> str:
    """The table of the page *Planners and bounds*, in Markdown."""
    rows = ["| mission: the first that applies | search | `auto` proves | `exact` proves |"]
    rows.append("|---|---|---|---|")
    for each in ENGINES:
        proven = (each.proves.get(method, "(not used)") for method in ("auto", "exact"))
        rows.append(f"| {each.missions} | {each.search} | {' | '.join(proven)} |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    print(page_table(), end="")
