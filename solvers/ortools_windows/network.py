"""The network of one window: every exact move that a better plan could make in it.

A node is a state of the chaser (body, free since, refuellings in the window) and an edge is one
move at the departure event that the rules give. There is no waiting and no rounding, so a path is
a piece of a plan and times itself. Every node also says what the *rest* of the plan, the moves
after the window, is worth when it is flown from there.
"""

import heapq
import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels import timetable as table_kernels
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION
from adr_opt.kernels.memory import write


class Worth(NamedTuple):
    """What slack is worth: a plan's worth is its prize less these losses.

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
    """The part of a plan that is planned anew.

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
    refuels : int
        Most refuellings in the window.
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
    pace_ends: np.ndarray
    pace_values: np.ndarray


class Limits(NamedTuple):
    """How much of a window is unrolled.

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


class Network(NamedTuple):
    """Nodes in order of time, the state at the start of the window first, and their edges.

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
    head: np.ndarray
    tail: np.ndarray


@kernel
def fly_rest(rules, worth, rest, body, time):
    """Fly the rest of a plan from a state, with ΔV to spare until its first refuelling.

    Returns
    -------
    value : float
        Worth of its legal moves and of its end; −inf if there is a rest and no move is legal.
    need : float
        ΔV of the moves until the first refuelling [m/s].
    """
    value, need, left = 0.0, 0.0, math.inf
    made = 0
    for j in rest:
        legal, delta_v, end = rule_kernels.fits(rules, body, time, left, j)
        if not legal or j == body:
            break
        if left == math.inf:
            if need + delta_v > rules.budget:
                break
            need += delta_v
        left = rule_kernels.left_after(rules, left, delta_v, j)
        value += rules.prize[j] - worth.per_m_s * delta_v
        body, time = j, end
        made += 1
    if made == 0 and rest.size > 0:
        return -math.inf, 0.0
    return value - worth.per_s * time, need


@kernel
def fly(rules, worth, body, time, moves):
    """Fly legal moves from a state and keep account.

    Returns
    -------
    ends : (moves + 1,) float64
        Since when the chaser is free, the first state included [s].
    values : (moves + 1,) float64
        Worth gained since the first state.
    """
    ends, values = np.empty(moves.size + 1), np.empty(moves.size + 1)
    ends[0], values[0] = time, 0.0
    for index in range(moves.size):
        j = moves[index]
        _, delta_v, end = rule_kernels.fits(rules, body, ends[index], math.inf, j)
        gain = rules.prize[j] - worth.per_m_s * delta_v - worth.per_s * (end - ends[index])
        values[index + 1] = values[index] + gain
        body, ends[index + 1] = j, end
    return ends, values


@kernel
def grow(rules, worth, window, limits):
    """Unroll a window in order of time.

    A move that fits no path's ΔV is left out, and so is everything after a node whose best path
    is more than ``limits.lag`` behind the present plan.

    Parameters
    ----------
    rules : Rules
    worth : Worth
    window : Window
    limits : Limits

    Returns
    -------
    Network
    """
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
    edges = np.empty((most, width + 1), dtype=np.int64)
    degree = np.zeros(most, dtype=np.int64)
    known, base, local = _slots(rules.table, window)

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
        for c in range(targets.size):
            j = targets[c]
            cost[c] = math.inf
            if j != i and j != origin[n]:
                legal, move_delta_v[c], move_end[c] = rule_kernels.fits(rules, i, now, spare, j)
                if legal and move_end[c] <= window.horizon:
                    cost[c] = move_delta_v[c] + limits.time_value * (move_end[c] - now)
        for choice in range(width + 1):
            if choice == width:
                # Last, the station: at a target, so that the refuelling is earned.
                if i == STATION or tank[n] == window.refuels:
                    break
                j = STATION
                legal, step, done = rule_kernels.fits(rules, i, now, spare, j)
                if not legal or done > window.horizon:
                    break
            else:
                best, least = -1, math.inf
                for c in range(targets.size):
                    if cost[c] < least:
                        best, least = c, cost[c]
                if best < 0:
                    continue
                cost[best] = math.inf
                j, step, done = targets[best], move_delta_v[best], move_end[best]
            event = table_kernels.next_event(rules.table, i, j, now)
            slot = base[local[i], local[j]] + event
            there = value[n] + rules.prize[j] - worth.per_m_s * step
            drawn = 0.0 if j == STATION else used[n] + step
            m = known[tank[n], slot]
            if m < 0:
                if count == most:
                    break
                m = count
                count += 1
                known[tank[n], slot] = m
                body[m], origin[m], end[m], delta_v[m] = j, i, done, step
                tank[m] = tank[n] + (j == STATION)
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
    order = order[:count]
    return Network(
        body[order], end[order], delta_v[order], tank[order], rest_worth, rest_need, head, tail
    )


@kernel
def _slots(table, window):
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
    targets = window.open_targets
    members = np.empty(targets.size + 2, dtype=np.int64)
    members[0], members[1] = STATION, window.body
    write(members[2:], targets)
    local = np.full(table.spacing.size, -1, dtype=np.int64)
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
    """How cheaply each candidate can be reached from one of the stops.

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
    cost[:] = math.inf
    for s in range(stops.size):
        for c in range(candidates.size):
            legal, delta_v, end = rule_kernels.fits(
                rules, stops[s], times[s], rules.budget, candidates[c]
            )
            if legal and candidates[c] != stops[s]:
                cost[c] = min(cost[c], delta_v + time_value * (end - times[s]))
