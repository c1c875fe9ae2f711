"""A dynamic programme in NumPy alone, over sets of targets, on matrices for every hour.

    python -m adr_opt matrix my.json --every 3600 --out costs.npz
    python examples/numpy_dynamic_programme.py my.json costs.npz

Costs of the hour before stand for those of the moment. No refuelling.
"""

import sys

import numpy as np
from coming_back import come_back

import adr_opt


def solve(matrix: str, budget_m_s: float, duration_s: float, most: int = 12) -> list[int]:
    """The most visits on one fuel load among the targets cheapest to reach from the station."""
    file = np.load(matrix)
    delta_v, duration = file["delta_v_m_s"], file["duration_s"] + file["service_s"]
    near = 1 + np.argsort(delta_v[:, 0, 1:].min(axis=0))[:most]
    best = {(0, 0): (budget_m_s, 0.0, [])}  # of (set, last target), the most ΔV left
    for mask in range(2**near.size):
        for last in (0, *near):
            left, now, order = best.get((mask, last), (-np.inf, 0.0, []))
            row = int(np.searchsorted(file["departures_s"], now, side="right")) - 1
            lefts, ends = left - delta_v[row, last], now + duration[row, last]
            for bit in np.flatnonzero((lefts[near] >= 0.0) & (ends[near] <= duration_s)):
                body, state = int(near[bit]), (mask | 1 << int(bit), int(near[bit]))
                if not mask >> int(bit) & 1 and lefts[body] > best.get(state, (-1.0,))[0]:
                    best[state] = lefts[body], ends[body], [*order, body]
    return max((order for _, _, order in best.values()), key=len)


if __name__ == "__main__":
    mission = adr_opt.Mission(adr_opt.load(sys.argv[1]))
    budget, duration = mission.instance.chaser.tank.delta_v_m_s, mission.instance.mission.duration_s
    come_back("DP", mission, solve(sys.argv[2], budget, duration))
