"""Mission rules: legal moves and their effect (docs/model.md section 5).

The one place where they stand. Everything that plans, and the environment, asks these kernels;
only ``check`` states them a second time, on purpose.

A move goes to a body by the connection that the timetable's choice makes. :func:`step` makes it:
from the state before to the state after, whose resources :mod:`.resources` extends, and whether
that is legal. Which targets are done is no part of the state, since search methods keep that in a
form of their own; :func:`may_go` asks about it.

The slack of the model (:mod:`adr_opt.common.constants`) is in the limits that :class:`Rules` holds
and in the next event, and nowhere else: what is left of a tank includes it, so that it is granted
once a tank and not once a leg, and every bound on moves under these rules holds with it.
"""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from ..core.memory import borrowed
from ..core.windows import Windows, service_end
from ..tables import timetable
from . import resources as resource_kernels
from .falls import Falls, lost_at
from .loads import Loads, flown_in_service, most_kits
from .resources import CountLimits, Resources


class Rules(NamedTuple):
    """A mission as kernels see it.

    Bodies are numbered stations first, then the orbit of the start if that is no station's, then
    the targets.

    Attributes
    ----------
    table : Table
    service : (bodies,) float64
        Time at each body after arrival: service, with the tow that follows, or refuelling at a
        station [s].
    windows : Windows
        When services may begin, with the slack.
    prize : (bodies,) float64
        What each target is worth to a planner at most; 0 for other bodies. Required targets are
        worth more than all others together, see :class:`adr_opt.mission.mission.Mission`.
    is_station, may_end : (bodies,) bool
        Where the tank is filled, and where the mission may end.
    stations, first_target : int
        Number of stations, and of the first target.
    start : int
        Body at which the chaser is in the beginning.
    ready : float
        Since when [s].
    limits : CountLimits
        On what it may count, as on targets that it services.
    returns : bool
        Whether there are bodies where the mission may not end.
    budget : float
        Full ΔV budget with the slack of the model, which is no limit to be met exactly; where loads
        count, the most that is ever left [m/s].
    duration : float
        End of the mission, with the slack [s].
    shortest_sortie : float
        Least time from the departure from a station to the end of a service [s].
    loads : Loads or None
        What the chaser carries; None where that makes no difference.
    falls : Falls or None
        Losses of prizes with time; None where none falls.
    """

    table: timetable.Table
    service: np.ndarray
    windows: Windows
    prize: np.ndarray
    is_station: np.ndarray
    may_end: np.ndarray
    stations: int
    first_target: int
    start: int
    ready: float
    limits: CountLimits
    returns: bool
    budget: float
    duration: float
    shortest_sortie: float
    loads: Loads | None = None
    falls: Falls | None = None


class State(NamedTuple):
    """Position and resources of a chaser."""

    body: int | np.int64
    resources: Resources


@inlined
def beginning(rules):
    """Initial state of a mission, with the maximum number of kits."""
    return beginning_with(rules, most_kits(rules.loads))


@inlined
def beginning_with(rules, kits):
    """Initial state of a mission with a given number of kits."""
    return State(
        np.int64(rules.start),
        resource_kernels.at_start(rules.ready, kits, rules.loads, rules.budget),
    )


@inlined
def looked_at(rules):
    """Number of destinations that searches examine from each body."""
    return timetable.looked_at(rules.table, rules.service.size - rules.first_target)


@inlined
def destination(rules, body, time, place):
    """A destination that searches examine from a body: any target, or one of the nearest at a time.

    Among the nearest there are stations, too.
    """
    return timetable.destination(rules.table, rules.first_target, body, time, place)


@inlined
def fits(rules, body, time, left, destination):
    """Cost of a move, and whether it fits the remaining ΔV and time.

    Parameters
    ----------
    rules : Rules
    body : int
        Where the chaser is.
    time : float
        Since when it is free [s].
    left : float
        ΔV left [m/s].
    destination : int

    Returns
    -------
    fits : bool
    delta_v : float
        [m/s], +inf where there is no transfer.
    end : float
        End of the service there [s].
    """
    delta_v, arrival = timetable.lookup(rules.table, body, destination, time)
    end = service_end(rules.windows, destination, arrival, rules.service[destination])
    return delta_v <= left and end <= rules.duration, delta_v, end


@inlined
def step(rules, state, destination):
    """Make a move.

    Parameters
    ----------
    rules : Rules
    state : State
    destination : int
        Another body; whether it is a target that is done already is for :func:`may_go` to say.

    Returns
    -------
    legal : bool
    delta_v : float
        Of the transfer and of a tow [m/s], +inf where there is no transfer.
    after : State
        The state after the move; of no meaning if it is not legal.
    """
    here = state.resources
    legal, delta_v, end = fits(rules, state.body, here.time, here.left, destination)
    refuels = rules.is_station[destination]
    after = resource_kernels.extend(
        here, destination, refuels, delta_v, end, rules.loads, rules.budget
    )
    if refuels:
        legal = legal and here.since > 0
    else:
        delta_v += flown_in_service(rules.loads, destination)
        legal = legal and resource_kernels.may_service(here, rules.limits) and after.left >= 0.0
    if rules.returns and legal and not rules.may_end[destination]:
        legal = _reaches_an_end(rules, destination, end, after.left)
    return legal, delta_v, State(np.int64(destination), after)


@kernel
def _reaches_an_end(rules, body, time, left):
    """Whether a chaser can still reach a body where the mission may end."""
    for s in range(rules.stations):
        if rules.may_end[s] and s != body and fits(rules, body, time, left, s)[0]:
            return True
    return False


@inlined
def may_go(rules, state, visited, destination):
    """Whether a destination differs from the current body and is neither serviced nor a left orbit.

    Parameters
    ----------
    visited : (bodies,) bool
        Targets that are done.
    """
    if destination == state.body:
        return False
    return rules.is_station[destination] or (
        destination >= rules.first_target and not visited[destination]
    )


@inlined
def has_way_back(rules, state):
    """Refuelling guard: whether a chaser at a target can still refuel, or need not.

    It need not when nothing could be serviced after refuelling, at any station, before the mission
    ends. Where no transfer leads to a station at any time, that is no matter of time: its way is
    taken to be none. A mission without stations knows no guard.
    """
    worth_it, has = False, state.resources
    for s in range(rules.stations):
        _, back, refuelled = fits(rules, state.body, has.time, has.left, s)
        if back <= has.left:
            return True
        if back == np.inf and fits(rules, state.body, rules.ready, has.left, s)[1] == np.inf:
            refuelled = has.time + rules.service[s]
        if refuelled <= rules.duration - rules.shortest_sortie:
            worth_it = True
    return not worth_it


@kernel
def shortest_sortie(table, service, budget, stations, first_target):
    """Least time from the departure from a station to the end of a service [s]; +inf for none."""
    shortest = math.inf
    for s in range(stations):
        for j in range(first_target, service.size):
            for event in range(timetable.events(table, s, j)):
                delta_v, arrival = timetable.entry_at(table, s, j, event)
                if delta_v <= budget:
                    departure = timetable.departure_at(table, s, j, event)
                    shortest = min(shortest, arrival - departure + service[j])
    return shortest


@kernel
def legal_moves(rules, state, visited, mask):
    """All legal moves of a state.

    Parameters
    ----------
    visited : (bodies,) bool
    mask : (bodies,) bool
        Written: True where the move is legal.

    Returns
    -------
    count : int
    """
    rules = borrowed(rules)
    count = 0
    for j in range(rules.service.size):
        legal = False
        if may_go(rules, state, visited, j):
            legal = step(rules, state, j)[0]
        mask[j] = legal
        count += legal
    return count


@kernel
def replay(rules, sequence, state, visited, ends, lefts):
    """Apply the moves of a sequence in order, as long as they are legal.

    Parameters
    ----------
    sequence : (moves,) int64
        Bodies in order, stations for refuelling.
    state : State
        To begin with.
    visited : (bodies,) bool
        Updated.
    ends, lefts : (moves,) float64
        Written: end of service [s] and ΔV left [m/s] after each move.

    Returns
    -------
    made : int
        Index of the first move that is not legal; the length of the sequence if all are.
    delta_v : float
        ΔV of the moves made [m/s].
    state : State
        The state after them.
    """
    rules = borrowed(rules)
    total = 0.0
    for index in range(sequence.size):
        j = sequence[index]
        if not may_go(rules, state, visited, j):
            return index, total, state
        legal, delta_v, after = step(rules, state, j)
        if not legal:
            return index, total, state
        total += delta_v
        visited[j] = not rules.is_station[j]
        state = after
        ends[index], lefts[index] = state.resources.time, state.resources.left
    return sequence.size, total, state


@inlined
def worth_at(rules, body, end):
    """Worth of the service of a body that ends at a time [s]."""
    return rules.prize[body] - lost_at(rules.falls, body, end)


@kernel
def collected(rules, sequence, ends):
    """Sum of the worths of a sequence of bodies, by the ends of their services [s]."""
    total = 0.0
    for index in range(sequence.size):
        total += worth_at(rules, sequence[index], ends[index])
    return total
