"""End of a tour, driven zone by zone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from .reading import Roads


class Score(NamedTuple):
    """When a tour ends, and the rules that it breaks."""

    end: float
    violations: tuple[str, ...]


def arrival(roads: Roads, origin: int, destination: int, departure: float) -> float:
    """When somebody arrives who leaves at a time: with the speed of each zone until all is driven.

    Infinite after the last zone, and where there is no way.
    """
    cluster, left = (
        int(roads.cluster[origin, destination]),
        float(roads.distance[origin, destination]),
    )
    if cluster < 0:
        return math.inf
    now = departure
    for zone, until in enumerate(roads.edges[1:].tolist()):
        if until <= now:
            continue
        speed = float(roads.speeds[cluster, zone])
        if left <= speed * (until - now):
            return now + left / speed
        left, now = left - speed * (until - now), until
    return now if left <= 1e-9 else math.inf


def score(roads: Roads, tour: Sequence[int]) -> Score:
    """A tour at its earliest times, from the start depot at once to the end depot.

    Parameters
    ----------
    roads : Roads
    tour : sequence of int
        The customers in order.
    """
    broken = []
    if sorted(tour) != roads.customers:
        broken.append("not every customer once")
    now, here = float(max(roads.edges[0], roads.opens[roads.start])), roads.start
    for place in (*tour, roads.end):
        now = max(arrival(roads, here, place, now), float(roads.opens[place]))
        if not now <= roads.closes[place] + 1e-6:
            broken.append(
                f"place {place}: reached at {now:g}, closed since {roads.closes[place]:g}"
            )
        here = place
    if now > roads.latest + 1e-6:
        broken.append(f"ends at {now:g}, after the horizon")
    return Score(now, tuple(broken))
