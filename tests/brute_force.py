"""Every legal plan, one by one: the yardstick for planners and bounds on small instances."""

from __future__ import annotations

import numpy as np

from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION
from adr_opt.mission import Mission


@kernel
def _search(rules, body, now, left, since_refuel, visited, path, depth, prize, spent, best, found):
    """Depth first over all legal moves; best = (prize, ΔV, moves), found = its sequence."""
    if prize > best[0] or (prize == best[0] and spent < best[1]):
        best[0], best[1], best[2] = prize, spent, depth
        found[:depth] = path[:depth]
    for j in range(rules.service.size):
        if not rule_kernels.may_go(body, since_refuel, visited, j):
            continue
        legal, delta_v, end = rule_kernels.fits(rules, body, now, left, j)
        if not legal:
            continue
        path[depth] = j
        visited[j] = j != STATION
        _search(
            rules,
            j,
            end,
            rule_kernels.left_after(rules, left, delta_v, j),
            0 if j == STATION else since_refuel + 1,
            visited,
            path,
            depth + 1,
            prize + rules.prize[j],
            spent + delta_v,
            best,
            found,
        )
        visited[j] = False


def brute_force(mission: Mission) -> tuple[float, float, tuple[int, ...]]:
    """The best objective, its least ΔV [m/s], and a sequence of bodies that has both."""
    rules = mission.rules
    size = len(mission.names)
    best = np.array([-np.inf, np.inf, 0.0])
    found = np.zeros(2 * size, dtype=np.int64)
    visited = np.zeros(size, dtype=np.bool_)
    path = np.zeros(2 * size, dtype=np.int64)
    _search(rules, STATION, 0.0, rules.budget, 0, visited, path, 0, 0.0, 0.0, best, found)
    return float(best[0]), float(best[1]), tuple(int(j) for j in found[: int(best[2])])
