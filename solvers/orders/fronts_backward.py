"""Backward Pareto fronts: the least resources for the rest of an order, see :mod:`.fronts`."""

from __future__ import annotations

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.lists import first_at
from adr_opt.kernels.core.memory import borrowed

from ..beams.levels import STRAIGHT
from .connection_table import STEPS
from .fronts import AT_STATION, BY_STATION, DIRECT, MOST_POINTS, first_by_end, put


@kernel
def _fly_back(connections, i, j, there, at, earliest, workspace, to):
    """Points from which a pair's connections lead to others, from a time on.

    They are written into the parts of the workspace at ``to``.
    """
    connections = borrowed(connections)
    there = borrowed(there)
    workspace = borrowed(workspace)
    here, budget = workspace.parts, connections.budget
    step = budget / STEPS
    begin, total = connections.first[i, j], connections.total[i, j]
    size = there.size[at]
    if total == 0 or there.tank[at, size - 1] + connections.least[i, j] > budget:
        return 0
    latest = there.time[at, 0]
    # To a single point the ΔV needed is not worked out beforehand; most searches end early.
    alone = size == 1
    point, last = np.int64(0), np.int64(0)
    if not alone:
        last = first_by_end(connections, begin, total, latest)
    while (
        not alone
        and last < total
        and connections.end[begin + connections.by_end[begin + last]] <= latest
    ):
        last += 1
    for place in range(last - 1, -1, -1):
        which = np.int64(connections.by_end[begin + place])
        end = connections.end[begin + which]
        if end < earliest:
            break
        while point + 1 < size and there.time[at, point + 1] >= end:
            point += 1
        workspace.tank[which] = there.tank[at, point] + connections.delta_v[begin + which]
    least = there.tank[at, point] + connections.least[i, j] + step
    count, best = 0, budget + step
    until = latest - connections.shortest[i, j]
    for c in range(
        first_at(connections.departure, begin, begin + total, until) - begin - 1, -1, -1
    ):
        departure = connections.departure[begin + c]
        if departure < earliest:
            break
        tank = there.tank[at, 0] + connections.delta_v[begin + c] if alone else workspace.tank[c]
        if connections.end[begin + c] > latest or tank > budget or tank >= best - step:
            continue
        best = tank
        count = put(here, to, count, departure, best, 0, STRAIGHT)
        if count == MOST_POINTS or best <= least:
            break
    return count


@kernel
def _needed_full(connections, s, j, there, earliest):
    """Latest refuelling at a station that suffices; −inf if none does [s]."""
    connections = borrowed(connections)
    there = borrowed(there)
    begin, total = connections.first[s, j], connections.total[s, j]
    size, latest = there.size[j], there.time[j, 0]
    until = latest - connections.shortest[s, j]
    for c in range(first_at(connections.departure, begin, begin + total, until) - 1, begin - 1, -1):
        if connections.departure[c] < earliest:
            break
        end = connections.end[c]
        if end > latest:
            continue
        low, high = 0, size
        while low < high:
            middle = (low + high) // 2
            if there.time[j, middle] >= end:
                low = middle + 1
            else:
                high = middle
        if there.tank[j, low - 1] + connections.delta_v[c] <= connections.budget:
            return connections.departure[c]
    return -np.inf


@kernel
def _merge_back(count, parts, rest, step, to, at):
    """Merge two descending fronts at indices 0 and 1 of ``parts``."""
    parts = borrowed(parts)
    to = borrowed(to)
    a, b, size, best = 0, 0, 0, np.inf
    while (a < count or b < rest) and size < MOST_POINTS:
        if b == rest or (a < count and parts.time[0, a] >= parts.time[1, b]):
            place, point = 0, a
            a += 1
        else:
            place, point = 1, b
            b += 1
        if parts.tank[place, point] < best - step:
            best = parts.tank[place, point]
            size = put(to, at, size, parts.time[place, point], best, 0, STRAIGHT)
    to.size[at] = size
    return size


@kernel
def backwards(rules, connections, i, j, there, earliest, workspace, to):
    """Sufficient front at a target before one with a known front, from a time on.

    Parameters as of :func:`.fronts.forwards`, from the front of ``there`` at ``j`` back to ``i``,
    for the place ``to`` of the trial. From a target the chaser may always go by a station.
    """
    connections, there = borrowed(connections), borrowed(there)
    workspace = borrowed(workspace)
    parts, here = workspace.parts, workspace.trial
    step = connections.budget / STEPS
    count = _fly_back(connections, i, j, there, j, earliest, workspace, DIRECT)
    size = _merge_back(count, parts, 0, step, here, to)
    for s in range(rules.stations):
        if s == i or connections.total[i, s] == 0 or connections.total[s, j] == 0:
            continue
        full = _needed_full(connections, s, j, there, earliest)
        if full == -np.inf:
            continue
        parts.size[AT_STATION] = 1
        parts.time[AT_STATION, 0], parts.tank[AT_STATION, 0] = full, 0.0
        rest = _fly_back(connections, i, s, parts, AT_STATION, earliest, workspace, BY_STATION)
        if rest > 0:
            for a in range(size):
                put(parts, DIRECT, a, here.time[to, a], here.tank[to, a], 0, STRAIGHT)
            size = _merge_back(size, parts, rest, step, here, to)
    return size


@kernel
def finish(rules, connections, i, earliest, workspace, to):
    """Sufficient front at the last target of an order, at index ``to`` of the trial."""
    size, parts, here = np.int64(0), workspace.parts, workspace.trial
    if rules.may_end[i]:
        size = put(here, to, size, rules.duration, 0.0, 0, STRAIGHT)
        here.size[to] = size
        return size
    here.size[to] = 0
    step = connections.budget / STEPS
    for s in range(rules.stations):
        if s != i and rules.may_end[s]:
            parts.size[AT_STATION] = 1
            parts.time[AT_STATION, 0], parts.tank[AT_STATION, 0] = rules.duration, 0.0
            rest = _fly_back(connections, i, s, parts, AT_STATION, earliest, workspace, BY_STATION)
            for a in range(size):
                put(parts, DIRECT, a, here.time[to, a], here.tank[to, a], 0, STRAIGHT)
            size = _merge_back(size, parts, rest, step, here, to)
    return size
