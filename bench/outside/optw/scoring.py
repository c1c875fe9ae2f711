"""Score of a tour, and the rules it breaks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..reading import FloatArray
from .reading import FIRST_MS, SLOT_MS, Places


@dataclass(frozen=True)
class Score:
    """Score of a tour.

    Attributes
    ----------
    score : float
        Of the places between the first and the last.
    end_ms : float
        Arrival at the last place, by the earliest times.
    violations : tuple of str
    """

    score: float
    end_ms: float
    violations: tuple[str, ...]


def travel_ms(travel: FloatArray, origin: int, destination: int, departure_ms: float) -> float:
    """Duration of a way [ms].

    Given are departures at the beginnings of slots; between two of them it is linear in the
    departure, as the authors of the instances have it, and after the last one constant. Then a
    later departure never arrives earlier.
    """
    given = travel[origin, destination]
    if given.size == 1:
        return float(given[0])
    place = (departure_ms - FIRST_MS) / SLOT_MS
    slot = min(max(math.floor(place), 0), given.size - 1)
    if slot == given.size - 1:
        return float(given[slot])
    return float(given[slot] + (place - slot) * (given[slot + 1] - given[slot]))


def score(places: Places, travel: FloatArray, tour: Sequence[int]) -> Score:
    """A tour at its earliest times.

    Service begins within the window of a place, after waiting where that is necessary, and may
    end after it.

    Parameters
    ----------
    places : Places
    travel : (places, places, slots) float64
        [ms].
    tour : sequence of int
        Numbers of places between the first and the last, in order.
    """
    last = places.count - 1
    broken = [f"place {one}: not between 0 and {last}" for one in tour if not 0 < one < last]
    if broken:
        return Score(0.0, math.nan, tuple(broken))
    broken += [f"place {one}: visited twice" for one in sorted({*tour}) if tour.count(one) > 1]
    begin = now = float(places.opens_ms[0])
    here = 0
    for one in (*tour, last):
        now = max(now + travel_ms(travel, here, one, now), float(places.opens_ms[one]))
        if now > places.closes_ms[one]:
            broken.append(
                f"place {one}: reached at {now:.0f}, closed since {places.closes_ms[one]:.0f}"
            )
        now, here = now + float(places.service_ms[one]), one
    if now > begin + places.longest_ms:
        broken.append(f"{now - begin:.0f} ms, longer than {places.longest_ms:.0f}")
    return Score(float(places.score[list(tour)].sum()), now, tuple(broken))
