"""Planning of what remains of a mission from its chasers' states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from ...common.stop import AnyOf, MaxRuntime, Stop
from ...mission.certified import certify_routes
from ...mission.mission import Mission
from ...mission.problem import Problem, problem_of
from ...mission.result import Result
from ...plan.cargo import kits_of
from ...plan.routes import routes_of
from ...problem.instance import Instance
from ...run.front import solve
from ...run.method_call import prepare, spec_of
from ...run.methods import PLANNERS
from . import starts
from .chaser_states import ChaserState
from .replanned import RemainingPlan
from .starts import Former, Remaining

QUICK, SEVERAL = "beam", "auto"
"""Default planners of what remains, for one chaser and for several."""

HURRY = 110.0 / 75.0
"""Value of an hour for the quick planner, as a multiple of the usual one."""


class PlannerChoice(NamedTuple):
    """Settings for planning the rest of a mission.

    Attributes
    ----------
    method : str or None
        Planner; by default "beam" for one chaser and "auto" for several.
    time_limit : float
        Wall time of a run [s].
    seed : int
    stop : Stop or None
    jobs : int
        Cores of a planner that can use several; 0 for all.
    """

    method: str | None
    time_limit: float
    seed: int
    stop: Stop | None
    jobs: int = 0


@dataclass(frozen=True)
class _Task:
    """Data that stay the same while the rest is planned repeatedly."""

    instance: Instance
    remaining: Remaining
    former: Former
    choice: PlannerChoice

    def new_plan(self, beginning: Instance, orders: list[list[str]]) -> Result:
        """The better of a planner's result and the former orders."""
        return _planned(beginning, orders, self.choice)

    def former_plan(self, beginning: Instance, orders: list[list[str]]) -> Result:
        """The former orders, as far as they can still be flown."""
        problem = problem_of(beginning)
        return _certified(problem, _flyable(problem, orders), self.choice.seed, 0.0)


Planning = Callable[[Instance, list[list[str]]], Result]
"""A function that plans an instance, given the former orders of its chasers."""


def plan_remaining(
    instance: Instance,
    remaining: Remaining,
    states: tuple[ChaserState, ...],
    former: Former,
    choice: PlannerChoice,
) -> RemainingPlan:
    """The best plan found of what remains: a new one, or the former one where that is better.

    Parameters
    ----------
    instance : Instance
        The whole mission, with new zones if there are any.
    remaining : callable
        Makes the instance that remains of it from states.
    states : tuple of ChaserState
        In order of their starts.
    former : mapping
        What the chasers were about to do, by name.
    choice : PlannerChoice
    """
    task = _Task(instance, remaining, former, choice)
    best = _consistent(task, states, task.new_plan)
    if any(state.idle_kits for state in best.states):
        # That plan was compared with the former one under other kits, so it is once more.
        as_before = _consistent(task, states, task.former_plan)
        if _is_better(as_before.result, best.result):
            return as_before
    return best


def _consistent(task: _Task, states: tuple[ChaserState, ...], planning: Planning) -> RemainingPlan:
    """A plan consistent with the states from which it starts.

    Two parts of a state depend on the plan. Kits that no target takes are carried along, and their
    mass is known once the plan is. And a chaser that is still to tow an object has to be the first
    one there, or the others wait. So the states are corrected by what a plan shows, and what
    remains is planned again, until a plan corrects nothing. Kits in use only become fewer, and
    nobody waits longer than until all such chasers have begun. Where even that does not help, the
    former plan is taken: in that, each chaser begins with its own object.
    """
    known = states
    while True:
        best = _best_start(task, known, planning)
        is_usurped = starts.is_usurped(best.states, best.result)
        if is_usurped:
            corrected = starts.in_order(task.instance, starts.kept_waiting(known))
        else:
            corrected = _carrying(known, best)
        if corrected != known:
            known = corrected
        elif is_usurped:
            return _consistent(task, states, task.former_plan)
        else:
            return best


def _best_start(task: _Task, states: tuple[ChaserState, ...], planning: Planning) -> RemainingPlan:
    """The best plan over all starts: each chaser as it is, or refuelled first."""
    best: RemainingPlan | None = None
    for beginning, begun in starts.possible_starts(task.remaining, states, task.former):
        orders = starts.orders_left(beginning, task.former, begun, states)
        found = RemainingPlan(beginning, begun, planning(beginning, orders))
        if best is None or _is_better(found.result, best.result):
            best = found
    assert best is not None  # chasers can always start as they are
    return best


def _carrying(states: tuple[ChaserState, ...], found: RemainingPlan) -> tuple[ChaserState, ...]:
    """States with the kits used by a new plan; additional kits aboard stay there."""
    instance, _, made = found
    flown = () if made.plan is None else routes_of(instance, made.plan)
    needed = {
        route.chaser.name: kits_of(instance, (body for body, _ in route.spent)) for route in flown
    }

    def carrying(state: ChaserState) -> ChaserState:
        if state.is_new or state.kits is None or state.chaser.kit_mass_kg == 0.0:
            return state
        kits = needed.get(state.chaser.name, 0)
        return replace(state, kits=kits, idle_kits=state.idle_kits + state.kits - kits)

    return tuple(carrying(state) for state in states)


def _planned(beginning: Instance, orders: list[list[str]], choice: PlannerChoice) -> Result:
    """The better of a planner's result and the former orders, as far as they can be flown."""
    method, time_limit, seed, stop, jobs = choice
    problem = problem_of(beginning)
    if method is None and problem.alone is not None:
        # One choice of connections for all that plans: a second timetable would take as long.
        hurry = HURRY * beginning.time_value_m_s_per_h
        connecting = problem.connecting
        problem = Problem.of(Mission(beginning, time_value_m_s_per_h=hurry, connecting=connecting))
        flyable = _flyable(problem, orders)
        found = _quickly(problem, time_limit, seed, stop)
    else:
        flyable = _flyable(problem, orders)
        method, more = method or SEVERAL, dict[str, Any]()
        if spec_of(method).starts and any(flyable):
            start = flyable if len(beginning.chasers) > 1 else flyable[0]
            more = {"start": start, "repair": True}
        if jobs and spec_of(method).uses_cores:
            more["jobs"] = jobs
        found = solve(problem, method, time_limit=time_limit, seed=seed, stop=stop, **more)
    own = _certified(problem, flyable, seed, found.runtime_s)
    if own.plan is not None and (found.plan is None or own.objective > found.objective):
        return own
    return found


def _certified(problem: Problem, orders: list[list[str]], seed: int, runtime_s: float) -> Result:
    """Orders of the former plan, as a result."""
    moves = [
        mission.numbers(order) for mission, order in zip(problem.missions, orders, strict=True)
    ]
    return certify_routes(problem, "former", moves, seed=seed, runtime_s=runtime_s)


def _quickly(problem: Problem, time_limit: float, seed: int, stop: Stop | None) -> Result:
    """The plan of the quick planner, without slower preparatory steps."""
    options = {"time_value_m_s_per_h": problem.missions[0].time_value_m_s_per_h}
    prepared = prepare(PLANNERS, QUICK, seed=seed, options=options)
    limits = [MaxRuntime(time_limit), *([] if stop is None else [stop])]
    return prepared(problem, AnyOf(*limits))


def _flyable(problem: Problem, orders: list[list[str]]) -> list[list[str]]:
    """The orders without bodies that can no longer be reached, removed one by one."""
    kept = []
    for mission, order in zip(problem.missions, orders, strict=True):
        moves = mission.numbers(order).tolist()
        while (made := mission.time(moves).made) < len(moves):
            del moves[made]
        kept.append([mission.names[j] for j in moves])
    return kept


def _is_better(made: Result, best: Result) -> bool:
    """Whether one plan collects more than another."""
    if made.plan is None or best.plan is None:
        return made.plan is not None
    return made.objective > best.objective
