"""Route enumeration: all routes of possible better plans, and whether they form one.

With multipliers π and the most v_k that a route of each kind is worth, less multipliers, no plan
exceeds L = Σ π + Σ v_k over the chasers. A plan that reaches a goal loses no more than L − goal of
that, whatever it loses it by; so each of its routes is worth at least v_k − (L − goal) (Baldacci,
Christofides and Mingozzi 2008). Labels find a route for every set of targets above this value,
and a set packing decides whether some of them make such a plan.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import Enum

import numpy as np
from scipy.optimize import LinearConstraint

from adr_opt.mission.evidence import Cut
from adr_opt.mission.problem import Problem, Routes
from adr_opt.plan.station_limits import Use

from ..labels.label_search import LabelSearch as Search
from ..routes.digits import beside, has_large, in_units, reaching
from ..routes.route_pool import dealt
from ..routes.set_packing import Packed, cheapest_of, packing
from ..walks.walks import WalkBound

MOST_ROUTES = 100_000
"""Maximum number of routes in the packing model."""

SCALE, PACKING_OFF = 1e4, 1e-4
"""Scaled largest prize in the packing model, whose tolerance is 10⁻⁶, and its largest error."""

LEAST_OFF = 1e-6
"""Margin below a goal from which routes are sought, as a share of the largest prize."""


def worth_a_goal(
    problem: Problem,
    worths: Sequence[float],
    goal: float,
    constraints: Sequence[LinearConstraint],
    time_limit_s: float,
) -> Packed:
    """The most valuable columns that satisfy some constraints, if they reach a goal.

    Parameters
    ----------
    problem : Problem
    worths : sequence of float
        Of the columns.
    goal : float
    constraints : sequence of LinearConstraint
    time_limit_s : float
    """
    scale = SCALE / (float(problem.planning_prizes.max(initial=0.0)) or 1.0)
    scaled = scale * np.array(worths)
    if goal <= 0.0 or not has_large(problem):
        row = LinearConstraint(scaled[None, :], scale * goal - PACKING_OFF, np.inf)
        return cheapest_of(-scaled, [*constraints, row], time_limit_s)
    row, carries = reaching(*in_units(problem, worths, goal))
    costs = np.append(-scaled, np.zeros(carries))
    wider = [beside(each, carries) for each in constraints]
    return cheapest_of(costs, [*wider, row], time_limit_s, carries=carries)


class EnumerationAnswer(Enum):
    """Answer of the search for a better plan."""

    NONE = "there is none"
    FOUND = "there is one"
    UNKNOWN = "nobody knows"


class Finish:
    """Searches for plans that reach a goal.

    Parameters
    ----------
    problem : Problem
    bounds : sequence of (WalkBound, int)
        Of each kind, and its number there; their values are overwritten.
    """

    def __init__(self, problem: Problem, bounds: Sequence[tuple[WalkBound, int]]) -> None:
        self._problem = problem
        self._searches = tuple(Search(bound, start=start, all_sets=True) for bound, start in bounds)
        self._largest = float(problem.planning_prizes.max(initial=0.0)) or 1.0
        self._cuts = 0.0

    def cut(self, cuts: Sequence[Cut]) -> None:
        """Make routes pay for cuts, all of whose targets they remember."""
        self._cuts = math.fsum(cut.multiplier for cut in cuts)
        for search in self._searches:
            search.cut(cuts, forgetful=False)

    @property
    def labels_made(self) -> int:
        """Total number of labels."""
        return sum(search.labels_made for search in self._searches)

    def ask(
        self,
        goal: float,
        multipliers: np.ndarray,
        most_worth: np.ndarray,
        most_labels: int,
        enough: Callable[[], bool],
        remaining_s: Callable[[], float],
    ) -> tuple[EnumerationAnswer, Routes | None]:
        """Whether a plan reaches a goal, and that plan.

        Parameters
        ----------
        goal : float
        multipliers : (bodies,) float64
        most_worth : (kinds,) float64
            Proven: no route of a kind is worth more, less these multipliers and those of cuts.
        most_labels : int
            Maximum number of labels; beyond it, give up.
        enough : callable
            Whether to give up.
        remaining_s : callable
            How much time is left, for the packing: asked when it begins [s].
        """
        counts = [len(kind.chasers) for kind in self._problem.kinds]
        total = self._problem.limits.total(multipliers) + self._cuts
        bound = math.fsum([total, *(counts * most_worth)])
        routes: list[tuple[int, tuple[int, ...]]] = []
        for kind, search in enumerate(self._searches):
            search.use(multipliers)
            # No route is worth less than all that it may pay: also where there is no plan yet.
            least = max(most_worth[kind] - (bound - goal), -total)
            least -= LEAST_OFF * self._largest
            finished, _, _, _ = search.search(search.total + least, most_labels, enough)
            if not finished:
                return EnumerationAnswer.UNKNOWN, None
            found = search.plans(MOST_ROUTES + 1)
            routes += [(kind, route) for route in found]
            if len(routes) > MOST_ROUTES:
                return EnumerationAnswer.UNKNOWN, None
        return self._pack(goal, routes, remaining_s)

    def _pack(
        self,
        goal: float,
        routes: list[tuple[int, tuple[int, ...]]],
        remaining_s: Callable[[], float],
    ) -> tuple[EnumerationAnswer, Routes | None]:
        """Whether some of the routes form a plan that reaches the goal.

        Where stations have limits a route of the same targets may keep to them that was not
        listed: then there is no plan only if there is none without limits.
        """
        if not routes:
            return EnumerationAnswer.NONE, None
        answer, taken = self._packed(
            goal, routes, remaining_s(), limited=bool(self._problem.limits)
        )
        if answer is EnumerationAnswer.NONE and self._problem.limits:
            if (
                self._packed(goal, routes, remaining_s(), limited=False)[0]
                is not EnumerationAnswer.NONE
            ):
                answer = EnumerationAnswer.UNKNOWN
        return answer, taken

    def _packed(
        self,
        goal: float,
        routes: list[tuple[int, tuple[int, ...]]],
        time_limit_s: float,
        *,
        limited: bool,
    ) -> tuple[EnumerationAnswer, Routes | None]:
        """Packing of given routes, with or without the limits of stations."""
        problem, first = self._problem, self._problem.instance.first_target
        sets = [(kind, frozenset(j for j in route if j >= first)) for kind, route in routes]
        uses = [self._use(*each) for each in routes] if limited else None
        worths = [self._worth(*each) for each in routes]
        packed = packing(problem, sets, uses, all_flown=True)
        found = worth_a_goal(problem, worths, goal, [packed], time_limit_s)
        if found.taken is None:
            return EnumerationAnswer.NONE if found.solved else EnumerationAnswer.UNKNOWN, None
        taken = [routes[at] for at in found.taken]
        return EnumerationAnswer.FOUND, dealt(problem, taken)

    def _worth(self, kind: int, route: tuple[int, ...]) -> float:
        """Worth of a route, by the ends of its services where prizes fall."""
        first = self._problem.instance.first_target
        if self._problem.falls is None:
            return self._problem.collected(j for j in route if j >= first)
        mission = self._problem.kinds[kind].mission
        return self._problem.in_steps(mission.time(mission.closed(route)).objective)

    def _use(self, kind: int, route: tuple[int, ...]) -> Use:
        """Use of station supplies by a route."""
        mission = self._problem.kinds[kind].mission
        moves = mission.closed(route)
        schedule = mission.time(moves)
        return self._problem.use(mission, moves[: schedule.made], schedule.delta_vs)
