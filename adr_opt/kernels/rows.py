"""Rows on demand: what a timetable would hold for who is ready, worked out when somebody asks.

A timetable of all pairs grows with the square of the bodies, and whoever plans on it asks for a
thousandth of what it holds. Here nothing is held: of the departure events from a ready time on as
many are looked at as can still win, which are a few, since every half period of waiting costs
time. Only where events are regular.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from . import orbits, sequences, transfer
from .compile import kernel
from .events import earliest_taken, first_counted


class Source(NamedTuple):
    """What transfers follow from.

    Attributes
    ----------
    leaving, arriving : (bodies, columns) float64
        Rows of :data:`adr_opt.kernels.orbits.ORBIT_COLUMNS`, of bodies as they are left and as they
        are arrived at.
    extra_delta_v : (bodies, bodies) float64
        What matching the eccentricity vectors alone would cost [m/s].
    rule : TransferRule
        With the value of time of the choice.
    limits : adr_opt.kernels.timetable_making.Limits
    near : (bodies, ranks) int32
        Destinations of each body that searches look at, the nearest first.
    """

    leaving: np.ndarray
    arriving: np.ndarray
    extra_delta_v: np.ndarray
    rule: transfer.TransferRule
    limits: Any
    near: np.ndarray


@kernel
def chosen(source, i, j, ready):
    """The connection chosen of all that leave when a chaser is ready at i, or later.

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
    rule, limits = source.rule, source.limits
    best_delta_v, best_arrival, best_cost = math.inf, math.inf, math.inf
    if i == j:
        return best_delta_v, best_arrival
    pair = transfer.prepare(source.leaving[i], source.arriving[j], source.extra_delta_v[i, j], rule)
    first, half_turns = transfer.first_departure(pair)
    half_period = 0.5 * orbits.revolution(source.leaving[i])
    approach = rule.approach_revolutions * transfer.TWO_PI / pair.rate_j
    opens = limits.opens[j] - approach
    closes = limits.closes[j] - limits.service[j] - approach
    event = first_counted(first, half_period, earliest_taken(max(ready, limits.ready)))
    while True:
        departure = first + event * half_period
        soonest = rule.time_value * max(departure + pair.shortest, opens)
        if departure > limits.duration or soonest + pair.floor_delta_v > best_cost:
            return best_delta_v, best_arrival
        lead = transfer.target_lead(pair, departure, half_turns + event)
        best = sequences.best_sequence(
            pair,
            rule,
            departure,
            lead,
            opens - departure,
            closes - departure,
            best_cost - rule.time_value * departure,
        )
        cost = best.delta_v + rule.time_value * max(departure + best.flight_time, opens)
        if cost < best_cost:
            best_cost, best_delta_v = cost, best.delta_v
            best_arrival = departure + best.flight_time + approach
        event += 1


@kernel
def shortest_sortie(source, stations, first_target):
    """No departure from a station leads to the end of a service sooner than after this [s]."""
    shortest = math.inf
    for s in range(stations):
        for j in range(first_target, source.arriving.shape[0]):
            pair = transfer.prepare(
                source.leaving[s], source.arriving[j], source.extra_delta_v[s, j], source.rule
            )
            approach = source.rule.approach_revolutions * transfer.TWO_PI / pair.rate_j
            shortest = min(shortest, pair.shortest + approach + source.limits.service[j])
    return shortest
