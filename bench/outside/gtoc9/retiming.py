"""The best times of a mission whose debris and their order are given, on a grid.

By dynamic programming backwards: the least mass on arrival at each stop at each time. The rocket
equation makes less mass after a leg less mass before it, so that this is exact on the grid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from adr_opt.common.constants import DAY_S, OBLATENESS_M2
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import drift_linear as drift

from ..reading import FloatArray
from .campaign import Removals, Stop
from .estimate import LIMITS_M, pair_costs
from .expense import DRY_KG, EXHAUST_M_S, KIT_KG
from .phases import Latitude, phased_costs
from .scoring import STAY_D, WITHIN_D


@kernel
def _before(after, cost, stay, within, exhaust, kit, mass, leaves, arrives):  # noqa: PLR0913
    """Least masses on arrival at a stop from those at the next, and the leg that gives them.

    Parameters
    ----------
    after : (times,) float64
        Least mass on arrival at the next stop at each time, its kit still on board [kg].
    cost : (times, spans) float64
        ΔV by arrival and span in steps [m/s].
    stay, within : int
        Least stay, and most from arrival to arrival [steps].
    exhaust, kit : float
        [m/s], [kg].
    mass, leaves, arrives : (times,) float64, int64, int64
        Are filled; infinite mass where there is no way on.
    """
    times, spans = cost.shape
    best = np.empty(spans + 1)
    of_span = np.empty(spans + 1, np.int64)
    mass[:] = np.inf
    for a in range(times):
        if after[a] == np.inf:
            continue
        # The cheapest span up to each, since a chaser that is ready may wait.
        best[0], of_span[0] = np.inf, 0
        for s in range(1, spans + 1):
            best[s], of_span[s] = best[s - 1], of_span[s - 1]
            if cost[a, s - 1] < best[s]:
                best[s], of_span[s] = cost[a, s - 1], s
        for s in range(1, min(within - stay, a - stay) + 1):
            t = a - s - stay
            found = after[a] * math.exp(best[s] / exhaust) + kit
            if found < mass[t]:
                mass[t], leaves[t], arrives[t] = found, a - of_span[s], a


def retimed(
    mission: Removals,
    rows: FloatArray,
    step_d: float,
    begin_d: float | None = None,
    end_d: float | None = None,
    latitudes: Sequence[Latitude] | None = None,
) -> Removals:
    """The mission at its best times on a grid, by the estimate.

    Parameters
    ----------
    mission : Removals
    rows : (debris, columns) float64
    step_d : float
        Of the grid, which begins at ``begin_d``; stay and longest leg are whole numbers of it [d].
    begin_d, end_d : float, optional
        Between which it lies; those of the mission without [d, MJD2000].
    latitudes : sequence of Latitude, optional
        Of all debris: with them legs must also meet the debris on their orbits.

    Raises
    ------
    ValueError
        There is no way through on the grid.
    """
    begin = mission.begin_d if begin_d is None else begin_d
    end = mission.end_d if end_d is None else end_d
    stay, within = round(STAY_D / step_d), round(WITHIN_D / step_d)
    times = math.floor((end - begin) / step_d + 1e-6) + 1
    order = [stop.debris for stop in mission.stops]
    mass = np.full(times, np.inf)
    mass[: max(times - stay, 0)] = DRY_KG + KIT_KG
    choices = []
    cost = np.empty((times, within - stay))
    for one, other in zip(order[-2::-1], order[:0:-1], strict=True):
        pair = drift.prepare(rows[one], rows[other], *LIMITS_M, OBLATENESS_M2, 0.0)
        grid = begin * DAY_S, times, within - stay, step_d * DAY_S
        if latitudes is None:
            pair_costs(pair, *grid, cost)
        else:
            phased_costs(pair, latitudes[one], latitudes[other], *grid, cost)
        earlier, leaves, arrives = np.empty(times), np.zeros(times, int), np.zeros(times, int)
        _before(mass, cost, stay, within, EXHAUST_M_S, KIT_KG, earlier, leaves, arrives)
        choices.append((leaves, arrives))
        mass = earlier
    now = int(np.argmin(mass))
    if not np.isfinite(mass[now]):
        raise ValueError(f"no times from {begin:.3f} to {end:.3f} on a grid of {step_d:g} d")
    stops = []
    for one, (leaves, arrives) in zip(order[:-1], choices[::-1], strict=True):
        stops.append(Stop(one, begin + now * step_d, begin + leaves[now] * step_d))
        now = int(arrives[now])
    arrival = begin + now * step_d
    stops.append(Stop(order[-1], arrival, arrival + STAY_D))
    return Removals(tuple(stops))
