"""The total ΔV of a plan for several chasers, and which rules it breaks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from adr_opt.common.constants import DAY_S

from ..reading import FloatArray
from .estimate import matrices

LOAD, LONGEST_S, MOST_M_S = 10, 365.0 * DAY_S, 25e3
"""Debris, time and ΔV of a chaser at most."""

SLACK_S = 1.0
"""A chaser that leaves earlier than it is there by less is let pass, as are plans of the source."""


class Route(NamedTuple):
    """Route of one chaser: debris in order, with departures [s]."""

    debris: tuple[int, ...]
    departures_s: tuple[float, ...]


@dataclass(frozen=True)
class Score:
    """Score of a plan.

    Attributes
    ----------
    total_m_s : float
    routes_m_s : tuple of float
        Of each chaser.
    ends_s : tuple of float
        When each has met its last debris.
    violations : tuple of str
    """

    total_m_s: float
    routes_m_s: tuple[float, ...]
    ends_s: tuple[float, ...]
    violations: tuple[str, ...]


def score(bodies: FloatArray, routes: Sequence[Route], load: int = LOAD) -> Score:
    """A plan at its departures.

    Parameters
    ----------
    bodies : (1 + debris, 6) float64
        The orbit on which chasers begin first; see :func:`.reading.with_centroid`.
    routes : sequence of Route
        Debris by their number from 0, as in the file.
    load : int
        Debris of a chaser at most.
    """
    count = len(bodies) - 1
    met = Counter(one for route in routes for one in route.debris)
    wrong = sorted({*met, *range(count)})
    broken = [f"debris {one}: met {met[one]} times" for one in wrong if met[one] != 1]
    if any(not 0 <= one < count for one in met):
        broken.append(f"debris are numbered from 0 to {count - 1}")
        return Score(np.nan, (), (), tuple(broken))
    totals, ends = [], []
    for number, route in enumerate(routes):
        duration, delta_v = matrices(bodies, np.array(route.departures_s))
        ready, spent, here = 0.0, 0.0, 0
        for leg, (one, departure) in enumerate(zip(*route, strict=True)):
            if departure < ready - SLACK_S:
                broken.append(f"chaser {number}: leaves at {departure:.0f} s, ready at {ready:.0f}")
            ready = departure + float(duration[leg, here, one + 1])
            spent += float(delta_v[leg, here, one + 1])
            here = one + 1
        if len(route.debris) > load:
            broken.append(f"chaser {number}: {len(route.debris)} debris")
        if ready > LONGEST_S + SLACK_S:
            broken.append(f"chaser {number}: {ready / DAY_S:.2f} d")
        if spent > MOST_M_S:
            broken.append(f"chaser {number}: {spent:.1f} m/s")
        totals.append(spent)
        ends.append(ready)
    return Score(sum(totals), tuple(totals), tuple(ends), tuple(broken))
