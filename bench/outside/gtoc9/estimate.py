"""The ΔV of legs of GTOC9 by the closed form of long transfers, and tables of it.

What planning is done with: :mod:`adr_opt.kernels.legs.drift` (docs/model.md section 3) between mean
orbits with secular J2 rates. No phase and no flight: J of this estimate and J of a flown plan are
two figures.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import drift_linear as drift

from ..reading import FloatArray
from .campaign import Removals
from .scoring import STAY_D, WITHIN_D

LIMITS_M = 6600e3, EARTH_RADIUS_M + 2000e3
"""Limits of the drift orbit, as radii. The contest asks for perigees above 6600 km; there is no
other limit in it, and none of the winning legs comes near this upper one."""


def legs_m_s(mission: Removals, rows: FloatArray) -> tuple[float, ...]:
    """ΔV of the legs of a mission at its times, by the estimate."""
    found = []
    for one, other in zip(mission.stops[:-1], mission.stops[1:], strict=True):
        pair = drift.prepare(rows[one.debris], rows[other.debris], *LIMITS_M, OBLATENESS_M2, 0.0)
        times = one.departure_d * DAY_S, other.arrival_d * DAY_S
        found.append(float(drift.delta_v(pair, *times)))
    return tuple(found)


@kernel
def pair_costs(pair, first, arrivals, spans, step, cost):
    """ΔV of a pair by arrival and span, on a grid.

    Parameters
    ----------
    pair : LinearPair
    first, step : float
        The first arrival and the step of the grid [s].
    arrivals, spans : int
        How many arrivals, and how many steps a transfer takes at most.
    cost : (arrivals, spans) float64
        Is filled: [a, s − 1] of the arrival at ``first + a step`` after s steps [m/s].
    """
    for a in range(arrivals):
        arrival = first + a * step
        node = drift.node_left(pair, arrival)
        shape = drift.shape_left(pair, arrival)
        for s in range(1, spans + 1):
            span = s * step
            climb = drift.climb_of(pair, span, node)
            cost[a, s - 1] = drift.cost_of(pair, span, node, shape, climb)


def connections(
    rows: FloatArray, origin: int, destination: int, begin_d: float, end_d: float, step_d: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """All legs of a pair on a grid of times.

    Departures are those of the chaser after its stay, no transfer is longer than the rules leave
    room for.

    Returns
    -------
    departure, arrival, delta_v : (connections,) float64
        [s] since MJD2000 0, [s], [m/s], in order of arrival.
    """
    spans = round((WITHIN_D - STAY_D) / step_d)
    arrivals = int((end_d - begin_d) / step_d + 1e-9)
    pair = drift.prepare(rows[origin], rows[destination], *LIMITS_M, OBLATENESS_M2, 0.0)
    cost = np.empty((arrivals, spans))
    first, step = (begin_d + step_d) * DAY_S, step_d * DAY_S
    pair_costs(pair, first, arrivals, spans, step, cost)
    a, s = np.indices(cost.shape)
    arrival = first + a * step
    departure = arrival - (s + 1) * step
    there = departure >= begin_d * DAY_S - 1e-6
    return departure[there], arrival[there], cost[there]


def matrices(
    rows: FloatArray, departures_d: Sequence[float], span_d: float
) -> tuple[FloatArray, FloatArray]:
    """Legs that all take the same time: what planners on matrices see.

    Returns
    -------
    duration, delta_v : (departures, debris, debris) float64
        [s], infinite from a debris to itself, and [m/s].
    """
    count = len(rows)
    duration = np.full((len(departures_d), count, count), span_d * DAY_S)
    delta_v = np.full(duration.shape, np.inf)
    duration[:, range(count), range(count)] = np.inf
    for i in range(count):
        for j in range(count):
            if i == j:
                continue
            pair = drift.prepare(rows[i], rows[j], *LIMITS_M, OBLATENESS_M2, 0.0)
            for place, leaves in enumerate(departures_d):
                times = leaves * DAY_S, (leaves + span_d) * DAY_S
                delta_v[place, i, j] = drift.delta_v(pair, *times)
    return duration, delta_v
