"""The optimum of an instance of about twenty places, by all subsets of them.

The least time at which a set of places can be done, by the last of them (Held and Karp, 1962): no
bounds, no rounding, nothing shared with planners. A chaser that is earlier is never worse, since a
later departure never arrives earlier.
"""

from __future__ import annotations

import numpy as np

from adr_opt.common.errors import InputError
from adr_opt.kernels.core.compile import kernel

from ..reading import FloatArray
from .reading import FIRST_MS, SLOT_MS, Places

MOST_PLACES = 24
"""The times of all sets of more would not fit into a few gigabytes."""


@kernel
def _arrival(given, departure, slot, first):
    """Arrival of a way by its departure; as in scoring, but as a kernel."""
    if given.size == 1:
        return departure + given[0]
    place = (departure - first) / slot
    number = min(max(int(np.floor(place)), 0), given.size - 1)
    taken = given[number]
    if number < given.size - 1:
        taken += (place - number) * (given[number + 1] - given[number])
    return departure + taken


@kernel
def _best(travel, score, service, opens, closes, longest, slot, first, ready):  # noqa: PLR0913
    """The best set: its score, the set, the last place of it and when the tour ends.

    Parameters
    ----------
    ready : (sets, places) float64
        Is filled: when the service at the last place of a set has ended at the earliest; bit p − 1
        is place p.
    """
    count = score.size
    last = count - 1
    most = min(closes[last], opens[0] + longest)
    ready[:] = np.inf
    found, best_set, best_place, best_end = -1.0, 0, 0, np.inf
    direct = max(_arrival(travel[0, last], opens[0], slot, first), opens[last])
    if direct <= most:
        found, best_end = 0.0, direct
    for place in range(1, last):
        begin = max(_arrival(travel[0, place], opens[0], slot, first), opens[place])
        if begin <= closes[place]:
            ready[1 << (place - 1), place] = begin + service[place]
    for done in range(1, 1 << (last - 1)):
        total = 0.0
        for place in range(1, last):
            if done >> (place - 1) & 1:
                total += score[place]
        for here in range(1, last):
            now = ready[done, here]
            if now == np.inf:
                continue
            end = max(_arrival(travel[here, last], now, slot, first), opens[last])
            if end <= most and (total > found or (total == found and end < best_end)):
                found, best_set, best_place, best_end = total, done, here, end
            for place in range(1, last):
                bit = 1 << (place - 1)
                if done & bit:
                    continue
                begin = max(_arrival(travel[here, place], now, slot, first), opens[place])
                if begin <= closes[place]:
                    then = begin + service[place]
                    if then < ready[done | bit, place]:
                        ready[done | bit, place] = then
    return found, best_set, best_place, best_end


def optimum(places: Places, travel: FloatArray) -> tuple[float, tuple[int, ...]]:
    """The best score and a tour that has it.

    Raises
    ------
    InputError
        There are too many places, or no tour ends in time.
    """
    if places.count > MOST_PLACES:
        raise InputError(f"{places.name}: {places.count} places; at most {MOST_PLACES} fit")
    ready = np.empty((1 << (places.count - 2), places.count))
    columns = places.score, places.service_ms, places.opens_ms, places.closes_ms
    given = travel, *columns, places.longest_ms, SLOT_MS, FIRST_MS
    found, done, here, _ = _best(*given, ready)
    if found < 0.0:
        raise InputError(f"{places.name}: no tour ends in time")
    tour: list[int] = []
    while done:
        tour.append(here)
        then, before = ready[done, here], done & ~(1 << (here - 1))
        done, here = before, _last_before(places, travel, ready, before, here, float(then))
    return float(found), tuple(tour[::-1])


def _last_before(
    places: Places, travel: FloatArray, ready: FloatArray, before: int, here: int, then: float
) -> int:
    """The place that a set was left from, so that the service at the next one ends at a time."""
    off = {}
    for place in range(1, places.count - 1):
        if before and np.isfinite(ready[before, place]):
            arrival = _arrival(travel[place, here], ready[before, place], SLOT_MS, FIRST_MS)
            end = max(arrival, places.opens_ms[here]) + places.service_ms[here]
            off[place] = abs(end - then)
    return min(off, key=lambda place: off[place]) if off else 0
