"""Rows on demand: entries of a timetable, computed when a search first asks for them.

A timetable of all pairs grows with the square of the bodies, and planning on it uses a
thousandth of what it holds. Here nothing is held: of the departure events from a ready time on as
many are looked at as can still win, which are a few, since every half period of waiting costs
time.

Where events are regular this is what a table holds, to the last bit. Where connections are listed
it is what they are listed from, before they are sifted: at the same events the cheapest sequence to
each crossing of the target, which may differ from those of a list by its resolution (of nearly
coplanar pairs by more), and nothing that one has to wait for longer than two days. So a search may
ask for it, and a schedule has to be made of lists.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ...common.constants import DAY_S, TURN_RAD
from ..core.compile import inlined, kernel
from ..core.events import earliest_taken, first_counted
from ..core.windows import last_begin, service_begin
from ..legs import co_elliptic, free_burns, precession, sequences, zones
from ..legs.departure_events import least_speed, listed_at
from ..legs.fixed_points import BAND_S
from ..orbits.ephemeris import EPOCH_S, revolution_at


class Source(NamedTuple):
    """Data from which transfers are computed.

    Attributes
    ----------
    leaving, arriving : (bodies, columns) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`, of bodies as they are left
        and as they are arrived at.
    extra_delta_v : (bodies, bodies) float64
        What matching the eccentricity vectors alone would cost [m/s].
    rule : TransferRule
        With the value of time of the choice.
    limits : adr_opt.kernels.tables.timetable_making.ServiceLimits
    near : (periods, bodies, ranks) int32
        Destinations of each body that searches look at, the nearest first, in each of some periods
        of the mission.
    period : float
        How long each is [s].
    is_listed : bool
        Whether events are not regular.
    interval : float
        Between departure events of a pair, at least, where they are not [s].
    most : float
        Largest useful ΔV of a transfer there [m/s].
    """

    leaving: np.ndarray
    arriving: np.ndarray
    extra_delta_v: np.ndarray
    rule: co_elliptic.TransferRule
    limits: Any
    near: np.ndarray
    period: float
    is_listed: bool
    interval: float
    most: float


class Chosen(NamedTuple):
    """A connection that is chosen: ``delta_v`` is +inf if there is none.

    Attributes
    ----------
    delta_v : float
        [m/s].
    arrival, departure : float
        [s].
    revolutions : int
        Of phasing.
    """

    delta_v: float
    arrival: float
    departure: float
    revolutions: int


PATIENCE_S = 2.0 * DAY_S
"""Longest wait for a departure after a ready time, where events are irregular [s]."""

TURNED, TURNED_M_S = 0.03, 10.0
"""Largest overestimate of a sequence's cost before it is solved, as ε turns its plane a little: a
share of its ΔV, plus the second [m/s]."""


@kernel
def chosen(source, i, j, ready):
    """The connection chosen among all that leave once a chaser is ready at i.

    Parameters
    ----------
    source : Source
    i, j : int
        Origin and destination.
    ready : float
        [s].

    Returns
    -------
    delta_v : float
        [m/s]; +inf where there is none.
    arrival : float
        End of the approach, before service [s].
    """
    if i == j:
        return math.inf, math.inf
    if source.is_listed:
        return _of_listed(source, i, j, ready)
    found = at_regular_events(source, i, j, ready)
    return found.delta_v, found.arrival


@inlined
def _begin(source, j, stand_off, approach):
    """Start of the service that follows an approach, less the duration of the approach [s]."""
    return service_begin(source.limits.windows, j, stand_off + approach) - approach


@kernel
def at_regular_events(source, i, j, ready):
    """The chosen connection with all its data, where events are regular.

    Returns
    -------
    Chosen
    """
    rule, limits = source.rule, source.limits
    best_delta_v, best_arrival, best_cost = math.inf, math.inf, math.inf
    left, revolutions = math.inf, 0
    pair = co_elliptic.prepare(
        source.leaving[i], source.arriving[j], source.extra_delta_v[i, j], rule, EPOCH_S
    )
    first, half_turns = co_elliptic.first_departure(pair)
    half_period = 0.5 * revolution_at(source.leaving[i], EPOCH_S)
    approach = rule.approach_revolutions * TURN_RAD / pair.rate_j
    event = first_counted(first, half_period, earliest_taken(max(ready, limits.ready)))
    while True:
        departure = first + event * half_period
        soonest = rule.time_value * _begin(source, j, departure + pair.shortest, approach)
        if departure > limits.duration or soonest + pair.floor_delta_v > best_cost:
            return Chosen(best_delta_v, best_arrival, left, revolutions)
        lead = co_elliptic.target_lead(pair, departure, half_turns + event)
        best = sequences.best_sequence(
            pair,
            rule,
            departure,
            lead,
            limits.windows,
            j,
            departure + approach,
            best_cost - rule.time_value * departure,
        )
        begin = _begin(source, j, departure + best.flight_time, approach)
        cost = best.delta_v + rule.time_value * begin
        if cost < best_cost:
            best_cost, best_delta_v = cost, best.delta_v
            best_arrival = departure + best.flight_time + approach
            left, revolutions = departure, best.revolutions
        event += 1


@kernel
def _first_from(pair, steps, time):
    """Approximately the first event of a pair from a time on, among those that space departures."""
    first = precession.first_event(pair, 0.0)
    alpha_i, alpha_j, _ = precession.line(pair, pair.lag + pair.lag_rate * time)
    alpha_i = precession.near(alpha_i, first.alpha_i)
    alpha_j = precession.near(alpha_j, first.alpha_j)
    turned = (co_elliptic.latitude_of_i(pair, time) - alpha_i) / math.pi
    number = max(0, math.ceil((turned - first.half_turns) / steps))
    half_turns = first.half_turns + steps * number
    about = time + (half_turns - turned) * math.pi / pair.rate_i
    return precession.event_at(pair, half_turns, about, alpha_i, alpha_j)


@kernel
def _later(pair, event, steps, spacing, apart, until):
    """The next event before which planes cannot have approached each other by an angle.

    They approach no faster than their nodes.
    """
    number, rest = 1.0, until - event.time
    if apart > 0.0:
        number = max(1.0, math.floor(apart / (0.9 * abs(pair.lag_rate) * spacing + 1e-12)))
    number = int(min(number, max(1.0, math.ceil(rest / spacing) + 1.0)))
    if number == 1:
        return precession.later_event(pair, event, steps, spacing)
    return _first_from(pair, steps, event.time + (number - 0.5) * spacing)


@kernel
def _of_listed(source, i, j, ready):
    """The chosen connection where events are irregular."""
    rule, limits = source.rule, source.limits
    worth = rule.time_value
    best_delta_v, best_arrival, best_cost = math.inf, math.inf, math.inf
    pair = co_elliptic.prepare(
        source.leaving[i], source.arriving[j], source.extra_delta_v[i, j], rule, EPOCH_S
    )
    steps = max(1, math.ceil(source.interval * pair.rate_i / math.pi - 1e-9))
    lap, spacing = TURN_RAD / pair.rate_j, steps * math.pi / pair.rate_i
    approach = rule.approach_revolutions * lap
    closes = last_begin(limits.windows, j) - approach
    earliest = earliest_taken(max(ready, limits.ready))
    event = _first_from(pair, steps, earliest)
    slowest, until = least_speed(pair, rule), min(earliest + PATIENCE_S, limits.duration)
    while True:
        soonest = worth * _begin(source, j, event.time + pair.shortest - BAND_S, approach)
        if event.time > until or soonest + pair.floor_delta_v > best_cost:
            return best_delta_v, best_arrival
        turn = slowest * math.sin(min(0.9 * event.theta, 0.5 * math.pi))
        if turn > source.most or soonest + turn > best_cost:
            apart = 0.9 * event.theta - math.asin(min(1.0, source.most / slowest))
            event = _later(pair, event, steps, spacing, apart, until)
            continue
        about = event.time + pair.shortest - BAND_S + 0.5 * lap
        met = precession.meeting(pair, rule, event.half_turns, event.alpha_j, about)
        while met <= closes + BAND_S:
            if not worth * _begin(source, j, met - BAND_S, approach) < best_cost:
                break
            best_delta_v, best_arrival, best_cost = _cheapest_met(
                source, pair, j, event, met, earliest, (best_delta_v, best_arrival, best_cost)
            )
            met += lap
            if pair.acceleration_j != 0.0:
                met = precession.meeting(pair, rule, event.half_turns, event.alpha_j, met)
            if met - event.time > pair.longest + (
                rule.max_phasing_revolutions * pair.longest_lap + BAND_S
            ):
                break
        event = precession.later_event(pair, event, steps, spacing)


@kernel
def _cheapest_met(source, pair, j, event, met, earliest, best):
    """The best sequence so far, or a better one of an event that meets the target near a time."""
    rule = source.rule
    best_delta_v, best_arrival, best_cost = best
    approach = rule.approach_revolutions * TURN_RAD / pair.rate_j
    time, turn = met - event.time, 4.0 * math.sin(0.5 * event.theta) ** 2
    for k in range(rule.max_phasing_revolutions + 1):
        if pair.shortest + k * pair.shortest_lap > time + BAND_S:
            break
        if pair.longest + k * pair.longest_lap < time - BAND_S:
            continue
        if pair.free_speed > 0.0:
            seems = free_burns.least(pair, k, time, turn)
        else:
            r = co_elliptic.phasing_radius(pair, rule, k, time)
            seems = co_elliptic.turned_delta_v(pair, rule, k, r, turn, 0.0)
        least = (1.0 - TURNED) * seems - TURNED_M_S
        begin = max(met, _begin(source, j, met - BAND_S, approach))
        if least > source.most or least + rule.time_value * begin > best_cost:
            continue
        found = precession.fixed_point(
            pair, rule, event.half_turns, k, event.time, met, event.alpha_i, event.alpha_j
        )
        cost = found.delta_v + rule.time_value * _begin(source, j, found.stand_off, approach)
        if not cost < best_cost or found.delta_v > source.most:
            continue
        if listed_at(event.time, found.departure) < earliest:
            continue
        if rule.zones.shape[0] > 0 and zones.is_blocked(
            pair, rule, k, found.radius, found.departure
        ):
            continue
        best_delta_v, best_arrival, best_cost = found.delta_v, found.stand_off + approach, cost
    return best_delta_v, best_arrival, best_cost


@kernel
def shortest_sortie(source, stations, first_target):
    """Lower bound on the time from a station's departure to the end of a service [s]."""
    shortest = math.inf
    for s in range(stations):
        for j in range(first_target, source.arriving.shape[0]):
            pair = co_elliptic.prepare(
                source.leaving[s],
                source.arriving[j],
                source.extra_delta_v[s, j],
                source.rule,
                EPOCH_S,
            )
            approach = source.rule.approach_revolutions * TURN_RAD / pair.rate_j
            shortest = min(shortest, pair.shortest + approach + source.limits.service[j])
    return shortest
