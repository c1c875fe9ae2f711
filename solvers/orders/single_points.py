"""Shortcut for Pareto fronts that are evidently single points; see :mod:`.fronts`.

Where ΔV does not matter all fronts are, and orders are timed several times as fast by a bisection
or two for each target. A front takes a closer look where a later arrival might have more ΔV left by
a step, or where a station might help.
"""

from __future__ import annotations

from adr_opt.kernels.core.compile import inlined
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.lists import first_at

from ..beams.levels import STRAIGHT
from .connection_table import STEPS
from .fronts import first_by_end


@inlined
def arrives(connections, i, j, refuels, ready, tank, latest):
    """The front of :func:`.fronts.forwards` if it and the previous one are evidently one point.

    Parameters
    ----------
    connections, i, j, refuels, latest
        As of :func:`.fronts.forwards`.
    ready, tank : float
        The point before: ready since [s], ΔV left [m/s].

    Returns
    -------
    size : int
        0 if the target cannot be reached, −1 where it takes a closer look, otherwise 1.
    end, left : float
        The point.
    """
    begin, total = connections.first[i, j], connections.total[i, j]
    stop, size, at, left = begin + total, -1, latest, 0.0
    step, detour = connections.budget / STEPS, ready + connections.detour[i, j]
    low = first_at(connections.departure, begin, stop, earliest_taken(ready))
    place = total
    if low < stop:
        soonest = connections.departure[low] + connections.shortest[i, j]
        if soonest <= latest:
            place = first_by_end(connections, begin, total, soonest)
    while place < total:
        c = begin + connections.by_end[begin + place]
        at = connections.end[c]
        if at > latest:
            place = total
        elif c >= low and connections.delta_v[c] < tank:
            left = tank - connections.delta_v[c]
            break
        else:
            place += 1
    if place == total:
        if not refuels or detour > latest:
            size = 0
    # Neither does a later arrival have more left, nor one by a station.
    elif left >= tank - connections.least[i, j] - step and (
        not refuels
        or (detour >= at and left + step >= connections.budget - connections.from_station[i, j])
    ):
        size = 1
    return size, at, left


@inlined
def leaves(connections, i, j, latest, needed, earliest):
    """The front of :func:`.fronts_backward.backwards` if it and the next are evidently one point.

    Parameters
    ----------
    connections, i, j, earliest
        As of :func:`.fronts_backward.backwards`.
    latest, needed : float
        The point after: ready at the latest [s], ΔV needed [m/s].

    Returns
    -------
    size : int
        0 if nothing suffices, −1 where it takes a closer look, otherwise 1.
    departure, tank : float
        The point.
    """
    begin, total = connections.first[i, j], connections.total[i, j]
    size, departure, tank = -1, earliest, 0.0
    step, detour = connections.budget / STEPS, latest - connections.detour[i, j]
    until = latest - connections.shortest[i, j]
    c = begin - 1
    if total > 0 and until >= earliest:
        c = first_at(connections.departure, begin, begin + total, until) - 1
    while c >= begin:
        departure = connections.departure[c]
        tank = needed + connections.delta_v[c]
        if departure < earliest:
            c = begin - 1
        elif connections.end[c] <= latest and tank < connections.budget:
            break
        else:
            c -= 1
    if c < begin:
        if detour < earliest:
            size = 0
    # Neither does an earlier departure need less, nor one to a station.
    elif tank <= needed + connections.least[i, j] + step and (
        detour <= departure and tank <= connections.to_station[i, j] + step
    ):
        size = 1
    return size, departure, tank


@inlined
def set_single(front, place, time, tank):
    """Set a front of one point, reached straight; returns whether it was unchanged."""
    same = front.size[place] == 1 and front.time[place, 0] == time and front.tank[place, 0] == tank
    front.size[place] = 1
    front.time[place, 0], front.tank[place, 0] = time, tank
    front.parent[place, 0], front.via[place, 0] = 0, STRAIGHT
    return same
