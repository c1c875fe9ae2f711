"""Network of one window: every exact move that a better plan could make in it.

A node is a state of the chaser (body, free since, refuellings in the window) and an edge is one
move by the connection that the mission's choice makes. Nothing is rounded, so a path is a piece of
a plan and times itself. Every node also says what the *rest* of the plan, the moves after the
window, is worth when it is flown from there. Other connections may do better, never worse: the
best schedule of the whole order decides in the end.
"""

import heapq
import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed, write
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.rules.resources import Resources
from adr_opt.kernels.rules.rules import State
from adr_opt.kernels.tables import timetable as table_kernels


class SlackWorth(NamedTuple):
    """Worth of slack: a plan's worth is its prize less these losses.

    Attributes
    ----------
    per_s : float
        Loss per second by which the plan ends later [prize/s].
    per_m_s : float
        Loss per m/s of ΔV [prize/(m/s)].
    """

    per_s: float
    per_m_s: float


class Window(NamedTuple):
    """The part of a plan that is replanned.

    Attributes
    ----------
    body : int
        Where the chaser is at the start of the window.
    time : float
        Since when it is free there [s].
    left : float
        ΔV left there [m/s].
    open_targets : (targets,) int64
        Targets that the window may visit: neither visited before nor in the rest.
    rest : (moves,) int64
        The moves after the window.
    horizon : float
        No move of the window ends later [s].
    refuels, most_targets : int
        Most refuellings, and most targets, in the window.
    pace_ends, pace_values : (moves + 1,) float64
        When the present plan ends each of its moves in the window, its start first [s], and its
        worth since then.
    """

    body: int
    time: float
    left: float
    open_targets: np.ndarray
    rest: np.ndarray
    horizon: float
    refuels: int
    most_targets: int
    pace_ends: np.ndarray
    pace_values: np.ndarray


class UnrollLimits(NamedTuple):
    """Limits on the unrolling of a window.

    Attributes
    ----------
    nodes : int
        Most nodes.
    width : int
        Moves to targets kept per node, those with the least ΔV + time_value · duration.
    time_value : float
        [m/s per s].
    lag : float
        How far a path may fall behind the present plan [prize].
    """

    nodes: int
    width: int
    time_value: float
    lag: float


class WindowNetwork(NamedTuple):
    """Nodes in order of time, the initial state of the window first, with their edges.

    Attributes
    ----------
    body : (nodes,) int64
    end : (nodes,) float64
        Since when the chaser is free there [s].
    delta_v : (nodes,) float64
        ΔV of the move that leads there, the same for every edge into it [m/s].
    tank : (nodes,) int64
        Number of refuellings in the window up to the node, its own included.
    rest_worth : (nodes,) float64
        Worth of leaving the window here and flying the rest; −inf if its first move is illegal.
    rest_need : (nodes,) float64
        ΔV that the rest needs from the present tank [m/s].
    onward : (nodes,) int64
        Where the path of the next chaser begins after leaving the window here; −1 for none.
    head : (nodes + 1,) int64
        The edges of node n are ``tail[head[n]:head[n + 1]]``.
    tail : (edges,) int64
        Node that an edge leads to.
    """

    body: np.ndarray
    end: np.ndarray
    delta_v: np.ndarray
    tank: np.ndarray
    rest_worth: np.ndarray
    rest_need: np.ndarray
    onward: np.ndarray
    head: np.ndarray
    tail: np.ndarray


@inlined
def state_at(rules, body, time, left):
    """State of a chaser that is free at a body; serviced targets are tracked elsewhere."""
    earned = np.int64(1 if body >= rules.first_target else 0)
    return State(np.int64(body), Resources(time, left, earned, np.int64(0), np.int64(0)))


@kernel
def fly_rest(rules, worth, rest, body, time):
    """Fly the rest of a plan from a state, with spare ΔV until its first refuelling.

    Returns
    -------
    value : float
        Worth of its legal moves and of its end; −inf if there is a rest and no move is legal.
    need : float
        ΔV of the moves until the first refuelling [m/s].
    """
    rules = borrowed(rules)
    value, need = 0.0, 0.0
    state = state_at(rules, body, time, math.inf)
    made = 0
    for j in rest:
        if j == state.body:
            break
        legal, delta_v, after = rule_kernels.step(rules, state, j)
        if not legal:
            break
        if state.resources.left == math.inf:
            if need + delta_v > rules.budget:
                break
            need += delta_v
        value += rules.prize[j] - worth.per_m_s * delta_v
        state = after
        made += 1
    if made == 0 and rest.size > 0:
        return -math.inf, 0.0
    return value - worth.per_s * state.resources.time, need


@kernel
def grow(rules, worth, window, limits):
    """Unroll a window in order of time.

    A move that fits no path's ΔV is left out, and so is everything after a node whose best path
    is more than ``limits.lag`` behind the present plan.

    Parameters
    ----------
    rules : Rules
    worth : SlackWorth
    window : Window
    limits : UnrollLimits

    Returns
    -------
    WindowNetwork
    """
    rules = borrowed(rules)
    most, width, targets = limits.nodes, limits.width, window.open_targets
    body = np.empty(most, dtype=np.int64)
    origin = np.empty(most, dtype=np.int64)
    end = np.empty(most)
    delta_v = np.empty(most)
    tank = np.empty(most, dtype=np.int64)
    # Over all paths to a node: the least ΔV out of the present tank, and the most worth.
    used = np.empty(most)
    value = np.empty(most)
    order = np.empty(most, dtype=np.int64)
    edges = np.empty((most, width + rules.stations), dtype=np.int64)
    degree = np.zeros(most, dtype=np.int64)
    known, base, local = _slots(rules, window)

    body[0], origin[0], end[0], delta_v[0], tank[0] = window.body, -1, window.time, 0.0, 0
    used[0], value[0] = 0.0, 0.0
    count, taken, move = 1, 0, 0
    cost, move_delta_v = np.empty(targets.size), np.empty(targets.size)
    move_end = np.empty(targets.size)
    heap = [(window.time, 0)]
    while len(heap) > 0:
        now, n = heapq.heappop(heap)
        order[taken] = n
        taken += 1
        while move + 1 < window.pace_ends.size and window.pace_ends[move + 1] <= now:
            move += 1
        pace = window.pace_values[move]
        if move + 1 < window.pace_ends.size:
            share = (now - window.pace_ends[move]) / (
                window.pace_ends[move + 1] - window.pace_ends[move]
            )
            pace += share * (window.pace_values[move + 1] - pace)
        if value[n] - worth.per_s * (now - window.time) < pace - limits.lag:
            continue
        i = body[n]
        spare = (window.left if tank[n] == 0 else rules.budget) - used[n]
        state = state_at(rules, i, now, spare)
        for c in range(targets.size):
            j = targets[c]
            cost[c] = math.inf
            if j != i and j != origin[n]:
                legal, move_delta_v[c], after = rule_kernels.step(rules, state, j)
                move_end[c] = after.resources.time
                if legal and move_end[c] <= window.horizon:
                    cost[c] = move_delta_v[c] + limits.time_value * (move_end[c] - now)
        for choice in range(width + rules.stations):
            if choice >= width:
                # Last, the stations.
                j = choice - width
                if j == i or tank[n] == window.refuels:
                    continue
                legal, step, after = rule_kernels.step(rules, state, j)
                done = after.resources.time
                if not legal or done > window.horizon:
                    continue
            else:
                best, least = -1, math.inf
                for c in range(targets.size):
                    if cost[c] < least:
                        best, least = c, cost[c]
                if best < 0:
                    continue
                cost[best] = math.inf
                j, step, done = targets[best], move_delta_v[best], move_end[best]
            event = _taken(rules.table, i, j, now)
            slot = base[local[i], local[j]] + event
            there = value[n] + rules.prize[j] - worth.per_m_s * step
            drawn = 0.0 if rules.is_station[j] else used[n] + step
            m = known[tank[n], slot]
            if m < 0:
                if count == most:
                    break
                m = count
                count += 1
                known[tank[n], slot] = m
                body[m], origin[m], end[m], delta_v[m] = j, i, done, step
                tank[m] = tank[n] + rules.is_station[j]
                used[m], value[m] = drawn, there
                heapq.heappush(heap, (done, m))
            else:
                used[m] = min(used[m], drawn)
                value[m] = max(value[m], there)
            edges[n, degree[n]] = m
            degree[n] += 1

    place = np.empty(count, dtype=np.int64)
    head = np.zeros(count + 1, dtype=np.int64)
    for index in range(count):
        place[order[index]] = index
        head[index + 1] = head[index] + degree[order[index]]
    tail = np.empty(head[count], dtype=np.int64)
    rest_worth, rest_need = np.empty(count), np.empty(count)
    for index in range(count):
        n = order[index]
        for e in range(degree[n]):
            tail[head[index] + e] = place[edges[n, e]]
        rest_worth[index], rest_need[index] = fly_rest(rules, worth, window.rest, body[n], end[n])
    order, onward = order[:count], np.full(count, -1, dtype=np.int64)
    return WindowNetwork(
        body[order],
        end[order],
        delta_v[order],
        tank[order],
        rest_worth,
        rest_need,
        onward,
        head,
        tail,
    )


@inlined
def _taken(table, i, j, ready):
    """Event taken by a chaser that is ready at a time: it waits for one worth the wait.

    Chasers that wait for the same one are then at the same node.
    """
    event = table_kernels.next_event(table, i, j, ready)
    arrival = table_kernels.entry_at(table, i, j, event)[1]
    while (
        event + 1 < table_kernels.events(table, i, j)
        and table_kernels.entry_at(table, i, j, event + 1)[1] == arrival
    ):
        event += 1
    return event


@kernel
def _slots(rules, window):
    """One slot per (refuellings, origin, destination, departure event in the window).

    Returns
    -------
    known : (refuels + 1, slots) int32
        −1 everywhere: no node yet.
    base : (places, places) int64
        Slot of a pair's event number 0.
    local : (bodies,) int64
        Place of each body of the window.
    """
    table, targets, stations = rules.table, window.open_targets, rules.stations
    members = np.empty(stations + 1 + targets.size, dtype=np.int64)
    for s in range(stations):
        members[s] = s
    members[stations] = window.body
    write(members[stations + 1 :], targets)
    local = np.full(rules.service.size, -1, dtype=np.int64)
    for place in range(members.size):
        local[members[place]] = place
    base = np.zeros((members.size, members.size), dtype=np.int64)
    slots = 0
    for p in range(members.size):
        for q in range(members.size):
            i, j = members[p], members[q]
            if i != j:
                first = table_kernels.next_event(table, i, j, window.time)
                base[p, q] = slots - first
                slots += table_kernels.next_event(table, i, j, window.horizon) - first + 1
    return np.full((window.refuels + 1, slots), -1, dtype=np.int32), base, local


@kernel
def nearest(rules, stops, times, candidates, time_value, cost):
    """Least cost of reaching each candidate from any of the stops.

    Parameters
    ----------
    stops : (stops,) int64
        Bodies.
    times : (stops,) float64
        Since when the chaser is free there [s].
    candidates : (targets,) int64
    time_value : float
        [m/s per s].
    cost : (targets,) float64
        Written: least ΔV + time_value · duration; +inf if there is no move.
    """
    rules = borrowed(rules)
    cost[:] = math.inf
    for s in range(stops.size):
        for c in range(candidates.size):
            if candidates[c] == stops[s]:
                continue
            state = state_at(rules, stops[s], times[s], rules.budget)
            legal, delta_v, after = rule_kernels.step(rules, state, candidates[c])
            if legal:
                cost[c] = min(cost[c], delta_v + time_value * (after.resources.time - times[s]))
