"""Tables of the estimate for planning: ΔV by pair, gap from arrival to arrival, and arrival."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import DAY_S, OBLATENESS_M2
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import drift_linear as drift

from ..reading import FloatArray
from .estimate import LIMITS_M
from .scoring import FIRST_D, LAST_D, STAY_D, WITHIN_D

UNIT_M_S = 0.1


@kernel
def fill_pair(pair, first, step, stay, most, least_gap, slack, fine, unit, table):  # noqa: PLR0913
    """Fill the costs of a pair.

    Parameters
    ----------
    pair : LinearPair
    first, step, stay, most : float
        Of the grid; least stay, and longest transfer [s].
    least_gap : int
    slack : float
        How much longer transfers may take than the grid leaves room for [s].
    fine : int
        So many lengths of transfers are tried within a step.
    unit : float
        [m/s].
    table : (gaps, times) uint16
    """
    gaps, times = table.shape
    lengths = math.floor(most / step * fine + 1e-6)
    best = np.empty(lengths + 1)
    for g in range(gaps):
        for t in range(times):
            table[g, t] = 65535
    for arrives in range(least_gap, times):
        arrival = first + arrives * step
        node, shape = drift.node_left(pair, arrival), drift.shape_left(pair, arrival)
        best[0] = np.inf
        for s in range(1, lengths + 1):
            span = s * step / fine
            found = drift.cost_of(pair, span, node, shape, drift.climb_of(pair, span, node))
            best[s] = min(best[s - 1], found)
        for g in range(min(gaps, arrives - least_gap + 1)):
            room = (least_gap + g) * step - stay + slack
            s = min(math.floor(room / step * fine + 1e-6), lengths)
            if s > 0 and best[s] / unit < 65000.0:
                table[g, arrives - least_gap - g] = np.uint16(best[s] / unit)


def table(rows: FloatArray, step_d: float, slack_d: float, fine: int) -> npt.NDArray[np.uint16]:
    """ΔV of all legs on a grid.

    Returns
    -------
    (debris, debris, gaps, times) uint16
        [0.1 m/s], by the two debris, the gap from the stay to the longest leg, and the arrival at
        the first debris.
    """
    count, times = len(rows), math.floor((LAST_D - STAY_D - FIRST_D) / step_d + 1e-9) + 1
    least = round(STAY_D / step_d)
    gaps = round(WITHIN_D / step_d) - least + 1
    found = np.full((count, count, gaps, times), 65535, np.uint16)
    for i in range(count):
        for j in range(count):
            if i != j:
                pair = drift.prepare(rows[i], rows[j], *LIMITS_M, OBLATENESS_M2, 0.0)
                fill_pair(
                    pair, FIRST_D * DAY_S, step_d * DAY_S, STAY_D * DAY_S,
                    (WITHIN_D - STAY_D) * DAY_S, least, slack_d * DAY_S, fine, UNIT_M_S,
                    found[i, j],
                )  # fmt: skip
    return found
