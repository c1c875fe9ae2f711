"""Replanning of the rest of a mission, from the chasers' current states and with changes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..common.clock import now_s
from ..common.errors import InputError
from ..common.stop import AnyOf, MaxRuntime, Stop
from ..mission.certified import certify_routes
from ..mission.mission import Mission
from ..mission.problem import Problem, problem_of
from ..mission.result import Result
from ..plan.cargo import kits_of
from ..plan.plan import Plan
from ..plan.routes import routes_of
from ..problem.instance import Instance
from ..problem.settings import KeepOutZone
from ..problem.tour_rules import refuse_tour_rules
from ..run.front import solve
from ..run.method_call import prepare, spec_of
from ..run.methods import PLANNERS
from .deviations import Deviations
from .launch_windows import in_order, is_usurped, kept_waiting
from .remaining_instance import crossings, remaining_instance
from .replanned import PlannedRest, Replanned, compared
from .restart_states import former_orders, orders_left, restart_states
from .state import ChaserState, states_at

QUICK, SEVERAL = "beam", "auto"
"""Default planners of the rest, for one chaser and for several."""

DEFAULT_TIME_LIMIT_S = 2.0

HURRY = 110.0 / 75.0
"""Value of an hour for the quick planner, as a multiple of the usual one."""

Finding = Callable[[Instance, list[list[str]]], Result]
"""A function that plans what is left, starting from the remaining orders."""


def replan(  # noqa: PLR0913
    instance: Instance,
    plan: Plan,
    at_s: float,
    *,
    zones: Iterable[KeepOutZone] = (),
    lost: Iterable[str] = (),
    failed: int | None = None,
    keep: int = 0,
    missed: Iterable[str] = (),
    retry: bool = False,
    services_s: Mapping[str, float] | None = None,
    costs_m_s: Mapping[int, float] | None = None,
    method: str | None = None,
    time_limit: float = DEFAULT_TIME_LIMIT_S,
    seed: int = 0,
    stop: Stop | None = None,
) -> Replanned:
    """Replan the rest of a mission.

    What has begun is finished (:func:`.state.states_at`). A chaser that has serviced a target
    since it refuelled last may refuel at once; to be full earlier is never worse, so that is one
    more beginning, by the connection that arrives first. Where the former plan is about to do so
    it is taken; where it had ended, less than half a tank is left, or the chaser has to end at a
    station, both are tried. The rest of the former plan, without what it cannot fly any more, is
    what the new one has to beat.

    A chaser with an object that it is still to tow is put onto that once more (:mod:`.putting`),
    and one that has begun its last tow goes on from the disposal orbit. The rules of the whole
    mission allow no wait there, so a note says so.

    Parameters
    ----------
    instance : Instance
    plan : Plan
        Of this instance.
    at_s : float
        Since the epoch [s].
    zones : iterable of KeepOutZone
        New ones, besides those of the instance.
    lost : iterable of str
        Targets that are not to be visited any more.
    failed : int, optional
        Number of a leg that has not begun, and does not begin when it was to. Those before it of
        its chaser are flown as planned, and the rest begins where it was to begin, later.
    keep : int
        Number of further legs of each chaser, not yet begun, that are flown as planned.
    missed : iterable of str
        Targets to which the leg has begun, and that are not serviced: the chaser is there all the
        same, with the kit, and without a tow.
    retry : bool
        Whether those may be tried again; else they are given up.
    services_s : mapping of str to float, optional
        How long the service of a target took, or the attempt at one that was missed [s].
    costs_m_s : mapping of int to float, optional
        What a leg took, by its number, without the tow that may follow [m/s].
    method : str, optional
        Planner of the rest; "beam" for one chaser and "auto" for several by default.
    time_limit : float
        Wall time of a run [s].
    seed, stop
        As :func:`adr_opt.solve` takes them.

    Raises
    ------
    InputError
        The plan is of another instance, the time is outside the mission, a name is no target or
        one that is done, a leg that is to be kept crosses a new zone, or what is told of the
        flight cannot have been.
    """
    began = now_s()
    if plan.instance.sha256 != instance.sha256:
        raise InputError("the plan belongs to another instance; give the one it was made for")
    refuse_tour_rules(instance, "replan")
    if any(chaser.max_exceptions is not None for chaser in instance.chasers):
        raise InputError(
            "exceptions that were used so far are not counted yet: replan cannot plan on where "
            "chasers[].max_exceptions is given; plan an instance of what is left"
        )
    went = Deviations(_each_once(missed), retry, dict(services_s or {}), dict(costs_m_s or {}))
    states = states_at(instance, plan, at_s, keep=keep, failed=failed, went=went)
    zoned = instance.replace(keep_out_zones=(*instance.keep_out_zones, *zones))
    notes = tuple(note for state in states for note in state.notes)
    notes += tuple(crossings(zoned, states, at_s, len(instance.keep_out_zones)))
    gone = _each_once(lost)
    former = former_orders(plan, states)
    states = in_order(zoned, states)

    def left(now: tuple[ChaserState, ...]) -> Instance | None:
        return remaining_instance(zoned, now, gone, at_s, went.given_up)

    def planned(beginning: Instance, orders: list[list[str]]) -> Result:
        return _planned(beginning, orders, method, time_limit, seed, stop)

    def flown_on(beginning: Instance, orders: list[list[str]]) -> Result:
        problem = problem_of(beginning)
        return _certified(problem, _flyable(problem, orders), seed, 0.0)

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
    notes = (*notes, *_waits(states, best))
    orders = tuple(former[state.chaser.name] for state in best.states)
    return compared(instance, best, orders, gone, went, notes, began)


def _each_once(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(names))


def _waits(states: Sequence[ChaserState], found: PlannedRest) -> Iterator[str]:
    """Notes on chasers that continue from a disposal orbit after waiting there."""
    released = {state.chaser.name for state in states if state.is_released}
    instance, begun, made = found
    flown = set() if made.plan is None else {each.chaser for each in made.plan.routes if each.legs}
    flown |= {state.chaser.name for state in begun if not state.is_released}
    for name in sorted(released & flown):
        yield (
            f"{name} goes on from a disposal orbit where it waits, which the rules of "
            f"{instance.name!r} allow and those of the whole mission do not"
        )


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


def _planned(
    beginning: Instance, orders: list[list[str]], method: str | None, time_limit: float, seed: int,
    stop: Stop | None,
) -> Result:  # fmt: skip
    """The better of a planner's result and the rest of the former plan."""
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
