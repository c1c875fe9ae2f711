"""Plan the rest of a mission anew: from where its chasers are, with what has changed meanwhile."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import PurePath
from typing import Any

import numpy as np

from ..bodies import Station
from ..campaign import Problem, is_campaign, problem_of
from ..cargo import kits_of
from ..errors import InputError
from ..front import solve
from ..given import among
from ..instance import Instance
from ..keep_out import crossed
from ..kernels.constants import SLACK_M_S
from ..limits import limits_of
from ..mission import Mission
from ..numbering import Numbering
from ..plan import Leg, Plan
from ..planner import PLANNERS, takes_start
from ..prepared import method_of, prepare, warm_up
from ..pricing import burns_of, transfer_of
from ..result import Result, certify_routes
from ..routes import routes_of, weighed
from ..settings import KeepOutZone
from ..station_limits import StationLimits
from ..stop import AnyOf, MaxRuntime, Stop
from .putting import in_order, is_usurped, kept_waiting
from .replanned import Replanned, compared
from .state import State, as_flown, going_on, heavier, put_s, states_at

QUICK, SEVERAL = "beam", "auto"
"""Planners of the rest, where nobody names one: for one chaser and for several."""

DEFAULT_TIME_LIMIT_S = 2.0

HURRY = 110.0 / 75.0
"""What an hour is worth to the quick planner, as a multiple of what it is usually worth."""

NEAR_EMPTY = 0.5
"""With less of a tank than this it is tried to refuel first."""

Found = tuple[Instance, tuple[State, ...], Result]
"""What is left of the mission, where chasers go on from, and a plan of it."""

Former = Mapping[str, tuple[str, ...]]
"""What each chaser was about to do, by its name."""

Finding = Callable[[Instance, list[list[str]]], Result]
"""A plan of what is left, from what is left of the former orders."""


def replan(
    instance: Instance,
    plan: Plan,
    at_s: float,
    *,
    zones: Iterable[KeepOutZone] = (),
    lost: Iterable[str] = (),
    failed: int | None = None,
    keep: int = 0,
    method: str | None = None,
    time_limit: float = DEFAULT_TIME_LIMIT_S,
    seed: int = 0,
    stop: Stop | None = None,
) -> Replanned:
    """Plan the rest of a mission anew.

    What has begun is finished (:func:`.state.states_at`). A chaser that has serviced a target
    since it refuelled last may refuel at once; to be full earlier is never worse, so that is one
    more beginning, by the connection that arrives first. Where the former plan is about to do so
    it is taken; where it had ended, less than half a tank is left, or the chaser has to end at a
    station, both are tried. The rest of the former plan, without what it cannot fly any more, is
    what the new one has to beat.

    A chaser with an object that it is still to tow is put onto that once more (:mod:`.putting`),
    and one that has begun its last tow goes on from the disposal orbit. There nobody waits by the
    rules of the whole mission, so a note says so.

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
        Number of a leg that is not flown as planned.
    keep : int
        So many legs of each chaser that have not begun are flown as planned.
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
        one that is done, or a leg that is to be kept crosses a new zone.
    """
    began = time.perf_counter()
    if plan.instance.sha256 != instance.sha256:
        raise InputError("the plan belongs to another instance; give the one it was made for")
    states = states_at(instance, plan, at_s, keep=keep, failed=failed)
    zoned = instance.replace(keep_out_zones=(*instance.keep_out_zones, *zones))
    notes = tuple(_crossings(zoned, states, at_s, len(instance.keep_out_zones)))
    gone = tuple(dict.fromkeys(lost))
    former = _former(plan, states)
    states = in_order(zoned, states)

    def left(now: tuple[State, ...]) -> Instance | None:
        return _rest(zoned, now, gone, at_s)

    def planned(beginning: Instance, orders: list[list[str]]) -> Result:
        return _planned(beginning, orders, method, time_limit, seed, stop)

    def flown_on(beginning: Instance, orders: list[list[str]]) -> Result:
        problem = problem_of(beginning)
        return _certified(problem, _flyable(problem, orders), seed, 0.0)

    def settled(found: Finding) -> Found:
        """What is found where each chaser has the kits aboard that it leaves behind, or carries."""
        now = states
        while True:
            best: Found | None = None
            for beginning, begun in _beginnings(left, now, former):
                made = found(beginning, _orders(beginning, former, begun, now))
                if best is None or _is_better(made, best[2]):
                    best = beginning, begun, made
            assert best is not None
            if is_usurped(*best[1:]):
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
    if any(state.idle_kits for state in best[1]):
        # Planned with other kits, the former rest was none of those that it was compared with.
        own = settled(flown_on)
        if _is_better(own[2], best[2]):
            best = own
    notes = (*notes, *_waits(states, best))
    orders = tuple(former[state.chaser.name] for state in best[1])
    return compared(instance, *best, orders, gone, notes, began)


def _waits(states: Sequence[State], found: Found) -> Iterator[str]:
    """What is said of chasers that go on from a disposal orbit where they have waited."""
    released = {state.chaser.name for state in states if state.is_released}
    instance, begun, made = found
    flown = set() if made.plan is None else {each.chaser for each in made.plan.routes if each.legs}
    flown |= {state.chaser.name for state in begun if not state.is_released}
    for name in sorted(released & flown):
        yield (
            f"{name} goes on from a disposal orbit where it waits, which the rules of "
            f"{instance.name!r} allow and those of the whole mission do not"
        )


def _carrying(states: tuple[State, ...], found: Found) -> tuple[State, ...]:
    """The states with the kits that a new rest leaves behind; more that are aboard stay there."""
    instance, _, made = found
    flown = () if made.plan is None else routes_of(instance, made.plan)
    needed = {
        route.chaser.name: kits_of(instance, (body for body, _ in route.spent)) for route in flown
    }

    def carrying(state: State) -> State:
        if state.is_new or state.kits is None or state.chaser.kit_mass_kg == 0.0:
            return state
        kits = needed.get(state.chaser.name, 0)
        return replace(state, kits=kits, idle_kits=state.idle_kits + state.kits - kits)

    return tuple(carrying(state) for state in states)


def _crossings(zoned: Instance, states: Sequence[State], at_s: float, before: int) -> Iterator[str]:
    """What is said of legs that cross new zones and cannot be helped.

    Raises
    ------
    InputError
        One has not begun.
    """
    for state in states:
        for leg in state.legs:
            new = [which for which in crossed(zoned, leg) if which >= before]
            if not new or leg.end_s <= at_s:
                continue
            said = f"to {leg.destination!r} crosses new zone {new[0] - before + 1}"
            if leg.leaves_s >= at_s:
                raise InputError(f"the leg {said}, and is to be kept; keep fewer legs")
            yield f"the leg under way {said}, and is finished all the same"


def _rest(
    zoned: Instance, states: Sequence[State], lost: Sequence[str], at_s: float
) -> Instance | None:
    """The instance that is left, with chasers where they are; None where a station has run out."""
    done = {leg.destination for state in states for leg in state.legs}
    names = {target.name for target in zoned.targets}
    for name in lost:
        if name not in names:
            raise InputError(f"lost {name!r}: not a target of {zoned.name!r}")
        if name in done:
            raise InputError(f"lost {name!r}: it is done by then, or the leg to it has begun")
    put = {state.body: put_s(zoned, state) for state in states if state.is_put}
    targets = tuple(
        # What is still to be towed is worth nothing any more, and there for who is put onto it.
        target.replace(prize=0.0, required=True, window_s=put[target.name])
        if target.name in put
        else target
        for target in zoned.targets
        if target.name in put or (target.name not in done and target.name not in lost)
    )
    chasers = tuple(going_on(zoned, state) for state in states)
    # Launches are apart by their times then, and who is put somewhere is not launched.
    mission = zoned.mission.replace(launch_separation_s=None) if put else zoned.mission
    name = f"{zoned.name}-from-{at_s:.0f}s"
    stations = _stations_left(zoned, states)
    if stations is None:
        return None
    return _changed(
        zoned, states, name=name, targets=targets, chasers=chasers, stations=stations,
        mission=mission,
    )  # fmt: skip


def _changed(instance: Instance, states: Sequence[State], **changes: Any) -> Instance:
    """The instance with changes, and its given connections as they lead on from where chasers are.

    They lead from a start by its name, so that it takes over those of the target that it is at.
    """
    of_all = instance.transfer.given
    if instance.given is None or of_all is None:
        return instance.replace(**changes)
    parts = [changes.get(part, getattr(instance, part)) for part in Numbering.__annotations__]
    starts = {
        state.body: state.chaser.name for state in states if state.body and state.is_at_target
    }
    given = among(instance.given, Numbering(*parts).names, starts)
    # Beside the file of all of them, and of no other rest.
    file = f"{PurePath(of_all.file).stem}-{given.sha256[:8]}.parquet"
    emptied = instance.with_given(among(instance.given, ()))
    return emptied.replace(**changes).with_given(given, file)


def _stations_left(instance: Instance, states: Sequence[State]) -> tuple[Station, ...] | None:
    """The stations with what is left of their limits; None where more was taken than there is."""
    limits = StationLimits(instance)
    uses = [
        limits.use(as_flown(state), [(leg.destination, leg.delta_v_m_s) for leg in state.legs])
        for state in states
    ]
    if not limits.allow(uses):
        return None
    left = iter(limits.left(uses).tolist())
    return tuple(
        station.replace(
            max_refuellings=None if station.max_refuellings is None else round(next(left)),
            max_propellant_kg=None if station.max_propellant_kg is None else next(left),
        )
        for station in instance.stations
    )


def _former(plan: Plan, states: Sequence[State]) -> Former:
    """What the plan was about to do after what is fixed."""
    flown = {route.chaser: route.legs for route in plan.routes}
    if len(states) == 1:
        flown = {states[0].chaser.name: plan.legs}
    fixed = {state.chaser.name: len(state.legs) for state in states}
    return {
        name: tuple(leg.destination for leg in flown.get(name, ())[count:])
        for name, count in fixed.items()
    }


def _beginnings(
    left: Callable[[tuple[State, ...]], Instance | None], states: tuple[State, ...], former: Former
) -> Iterator[tuple[Instance, tuple[State, ...]]]:
    """The instances that the rest may begin with: chasers as they are, or refuelled first.

    The last one is that of chasers as they are, where no other one is possible.
    """
    rest = left(states)
    assert rest is not None  # what is flown kept to the limits
    ways = []
    for number, state in enumerate(states):
        order = former[state.chaser.name]
        about_to = bool(order) and order[0] in rest.station_names
        low = not order or state.left_m_s < NEAR_EMPTY * state.chaser.tank.delta_v_m_s
        may = about_to or low or state.has_to_return
        more = list(_refuelled(rest, state, number)) if may else []
        ways.append(more if about_to and more else [state, *more])
    found = 0
    for chosen in product(*ways):
        beginning = rest if chosen == states else left(chosen)
        if beginning is not None:
            yield beginning, chosen
            found += 1
    if not found:
        yield rest, states


def _refuelled(rest: Instance, state: State, number: int) -> Iterator[State]:
    """The chaser as it is after refuelling first, at each station that it can reach."""
    if not state.is_at_target or not (rest.targets or state.has_to_return):
        return
    if state.is_put:  # by the rules of the rest it may refuel at once
        return
    mission = Mission(rest, chaser=number)
    connecting, limits = mission.connecting, limits_of(rest, number)
    i, chaser = rest.starts[number], heavier(rest.chasers[number], state.kits or 0)
    full_m_s = chaser.tank.delta_v_m_s
    for station, name in enumerate(rest.station_names):
        found = connecting.of_pair(i, station, connecting.planning_resolution_m_s)
        found = found.after(state.free_s)
        delta_v = found.delta_v - connecting.spent_m_s(i)
        paid = delta_v <= state.left_m_s + SLACK_M_S
        ends = np.where(paid, found.arrival, math.inf) + limits.service[station]
        if not ends.size or ends.min() > limits.duration:
            continue
        taken = int(np.lexsort((found.delta_v, ends))[0])
        revolutions = int(found.revolutions[taken])
        flown = transfer_of(
            mission, i, station, float(found.departure[taken]), float(found.arrival[taken]),
            revolutions,
        )  # fmt: skip
        leg = Leg(
            kind=flown.kind,
            origin=state.body or chaser.name,
            destination=name,
            ready_s=state.legs[-1].free_s,
            departure_s=flown.departure,
            arrival_s=float(found.arrival[taken]),
            end_s=float(ends[taken]),
            delta_v_m_s=connecting.modelled(i, station, revolutions, float(found.delta_v[taken])),
            delta_v_left_m_s=full_m_s,
            phasing_revolutions=max(revolutions, 0),
            eccentricity_delta_v_m_s=flown.shape,
            burns=burns_of(flown),
        )
        (leg,) = weighed(rest, chaser.replace(kits=None), [leg])
        yield replace(
            state, legs=(*state.legs, leg), body=name, free_s=leg.end_s,
            left_m_s=full_m_s, propellant_kg=None, since_refuelling=0,
        )  # fmt: skip


def _orders(
    beginning: Instance, former: Former, states: tuple[State, ...], before: tuple[State, ...]
) -> list[list[str]]:
    """The former rest as far as there are such bodies; a stop that is made already is left out.

    It begins with the target that a chaser is put onto.
    """
    names, stations = set(beginning.names), beginning.station_names
    orders = []
    for state, former_state in zip(states, before, strict=True):
        left = [name for name in former[state.chaser.name] if name in names]
        if state is not former_state and left and left[0] in stations:
            left = left[1:]
        orders.append([state.body, *left] if state.is_put and state.body else left)
    return orders


def _planned(
    beginning: Instance, orders: list[list[str]], method: str | None, time_limit: float, seed: int,
    stop: Stop | None,
) -> Result:  # fmt: skip
    """The best of what a planner finds and of what is left of the former rest."""
    several = is_campaign(beginning)
    quick = method is None and not several
    if quick:
        # One choice of connections for all that plans: a second timetable would take as long.
        mission = Mission(beginning, time_value_m_s_per_h=HURRY * beginning.time_value_m_s_per_h)
        problem: Problem = mission
        flyable = _flyable(mission, orders)
        found = _quickly(mission, time_limit, seed, stop)
    else:
        problem = problem_of(beginning)
        flyable = _flyable(problem, orders)
        method, more = method or SEVERAL, dict[str, Any]()
        if takes_start(method_of(method)) and any(flyable):
            start = flyable if len(beginning.chasers) > 1 else flyable[0]
            more = {"start": start, "repair": True}
        found = solve(problem, method, time_limit=time_limit, seed=seed, stop=stop, **more)
    own = _certified(problem, flyable, seed, found.runtime_s)
    if own.plan is not None and (found.plan is None or own.objective > found.objective):
        return own
    return found


def _certified(problem: Problem, orders: list[list[str]], seed: int, runtime_s: float) -> Result:
    """What is left of the former rest, as a result."""
    moves = [
        mission.numbers(order) for mission, order in zip(problem.missions, orders, strict=True)
    ]
    return certify_routes(problem, "former", moves, seed=seed, runtime_s=runtime_s)


_practised: set[bool] = set()
"""For which kinds of timetable the quick planner has been compiled in this process."""


def _quickly(problem: Mission, time_limit: float, seed: int, stop: Stop | None) -> Result:
    """The plan of the quick planner, without all that takes longer than it does."""
    drifts = problem.connecting.drifts
    if drifts not in _practised:
        warm_up(PLANNERS, QUICK, drifts=drifts)
        _practised.add(drifts)
    options = {"time_value_m_s_per_h": problem.time_value_m_s_per_h}
    prepared = prepare(PLANNERS, QUICK, seed=seed, options=options)
    limits = [MaxRuntime(time_limit), *([] if stop is None else [stop])]
    return prepared(problem, AnyOf(*limits))


def _flyable(problem: Problem, orders: list[list[str]]) -> list[list[str]]:
    """The orders without the bodies that cannot be flown to any more, one after the other."""
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
