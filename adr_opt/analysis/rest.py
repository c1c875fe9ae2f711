"""Planning of what is left of a mission from its chasers' states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from ..common.stop import AnyOf, MaxRuntime, Stop
from ..mission.certified import certify_routes
from ..mission.mission import Mission
from ..mission.problem import Problem, problem_of
from ..mission.result import Result
from ..plan.cargo import kits_of
from ..plan.routes import routes_of
from ..problem.instance import Instance
from ..run.front import solve
from ..run.method_call import prepare, spec_of
from ..run.methods import PLANNERS
from .launch_windows import in_order, is_usurped, kept_waiting
from .replanned import PlannedRest
from .restart_states import Former, orders_left, restart_states
from .state import ChaserState

QUICK, SEVERAL = "beam", "auto"
"""Default planners of the rest, for one chaser and for several."""

HURRY = 110.0 / 75.0
"""Value of an hour for the quick planner, as a multiple of the usual one."""

Finding = Callable[[Instance, list[list[str]]], Result]
"""A function that plans what is left, starting from the remaining orders."""


class PlannerChoice(NamedTuple):
    """How the rest is planned.

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


def planned_rest(
    zoned: Instance,
    left: Callable[[tuple[ChaserState, ...]], Instance | None],
    states: tuple[ChaserState, ...],
    former: Former,
    choice: PlannerChoice,
) -> PlannedRest:
    """The best plan found of what is left: a new one, or the rest of the former one.

    Parameters
    ----------
    zoned : Instance
        The whole mission, with new zones if there are any.
    left : callable
        What is left of it from some states; None where stations do not allow it.
    states : tuple of ChaserState
        In order of the rest.
    former : mapping
        What the chasers were about to do, by name.
    choice : PlannerChoice
    """

    def planned(beginning: Instance, orders: list[list[str]]) -> Result:
        return _planned(beginning, orders, choice)

    def flown_on(beginning: Instance, orders: list[list[str]]) -> Result:
        problem = problem_of(beginning)
        return _certified(problem, _flyable(problem, orders), choice.seed, 0.0)

    def settled(found: Finding) -> PlannedRest:
        """The plan found when each chaser carries just the kits that it uses, or all it has."""
        now = states
        while True:
            best: PlannedRest | None = None
            for beginning, begun in restart_states(left, now, former):
                made = found(beginning, orders_left(beginning, former, begun, now))
                if best is None or _is_better(made, best.result):
                    best = PlannedRest(beginning, begun, made)
            assert best is not None
            if is_usurped(best.states, best.result):
                known = in_order(zoned, kept_waiting(now))
                if known == now:
                    return settled(flown_on)
            else:
                # Kits that are not left behind weigh on, which that plan did not know.
                known = _carrying(now, best)
            if known == now:
                return best
            now = known

    best = settled(planned)
    if any(state.idle_kits for state in best.states):
        # Planned with other kits, the former rest was none of those that it was compared with.
        own = settled(flown_on)
        if _is_better(own.result, best.result):
            best = own
    return best


def _carrying(states: tuple[ChaserState, ...], found: PlannedRest) -> tuple[ChaserState, ...]:
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
    """The better of a planner's result and the rest of the former plan."""
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
    """The rest of the former plan, as a result."""
    moves = [
        mission.numbers(order) for mission, order in zip(problem.missions, orders, strict=True)
    ]
    return certify_routes(problem, "former", moves, seed=seed, runtime_s=runtime_s)


def _quickly(problem: Problem, time_limit: float, seed: int, stop: Stop | None) -> Result:
    """The plan of the quick planner, without steps that take longer than itself."""
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
    """Whether it collects more."""
    if made.plan is None or best.plan is None:
        return made.plan is not None
    return made.objective > best.objective
