"""Unrolling of a window into its network: all moves from all nodes, in order of time."""

import heapq
import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed, write
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.tables import timetable as table_kernels

from .window_network import WindowNetwork, fly_rest, state_at


class Moves(NamedTuple):
    """Moves from a node.

    Attributes
    ----------
    body : (moves,) int64
        Where they lead.
    delta_v : (moves,) float64
        [m/s].
    end : (moves,) float64
        Since when the chaser is free there [s].
    """

    body: np.ndarray
    delta_v: np.ndarray
    end: np.ndarray


class UnrolledNodes(NamedTuple):
    """Nodes in the order in which they are first met, as in :class:`WindowNetwork` but for these.

    Attributes
    ----------
    body, end, delta_v, tank : (nodes,)
    origin : (nodes,) int64
        The body that the move into a node comes from; −1 for the first one.
    used : (nodes,) float64
        The least ΔV out of the present tank, of all paths to a node [m/s].
    value : (nodes,) float64
        The most worth of all paths to a node, but for the loss by time.
    degree : (nodes,) int64
        Number of edges out of a node.
    tail : (nodes, moves) int64
        Where they lead.
    order : (nodes,) int64
        The nodes in order of time.
    """

    body: np.ndarray
    end: np.ndarray
    delta_v: np.ndarray
    tank: np.ndarray
    origin: np.ndarray
    used: np.ndarray
    value: np.ndarray
    degree: np.ndarray
    tail: np.ndarray
    order: np.ndarray


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
    most = limits.nodes
    nodes = UnrolledNodes(
        np.empty(most, dtype=np.int64),
        np.empty(most),
        np.empty(most),
        np.empty(most, dtype=np.int64),
        np.empty(most, dtype=np.int64),
        np.empty(most),
        np.empty(most),
        np.zeros(most, dtype=np.int64),
        np.empty((most, limits.width + rules.stations), dtype=np.int64),
        np.empty(most, dtype=np.int64),
    )
    count = _unroll(rules, worth, window, limits, nodes)
    return _in_order(rules, worth, window, nodes, count)


@kernel
def _unroll(rules, worth, window, limits, nodes):
    """Fill the nodes, each after all nodes that lead to it; returns their number.

    The heap gives nodes in order of time, and a move takes time: when a node comes out of it, all
    edges into it are known, and with them the best that any path brings there.
    """
    rules, nodes = borrowed(rules), borrowed(nodes)
    known, base, local = _slots(rules, window)
    targets = window.open_targets.size
    offers = Moves(window.open_targets, np.empty(targets), np.empty(targets))
    cost, choices = np.empty(targets), nodes.tail.shape[1]
    moves = Moves(np.empty(choices, dtype=np.int64), np.empty(choices), np.empty(choices))
    nodes.body[0], nodes.end[0], nodes.delta_v[0] = window.body, window.time, 0.0
    nodes.tank[0], nodes.origin[0], nodes.used[0], nodes.value[0] = 0, -1, 0.0, 0.0
    count, taken, move = 1, 0, 0
    heap = [(window.time, 0)]
    while len(heap) > 0:
        now, n = heapq.heappop(heap)
        nodes.order[taken] = n
        taken += 1
        pace, move = _pace(window, now, move)
        if nodes.value[n] - worth.per_s * (now - window.time) < pace - limits.lag:
            continue
        i, tank = nodes.body[n], nodes.tank[n]
        spare = (window.left if tank == 0 else rules.budget) - nodes.used[n]
        state = state_at(rules, i, now, spare)
        chosen = _target_moves(rules, window, limits, state, nodes.origin[n], offers, cost, moves)
        if tank < window.refuels:
            chosen = _station_moves(rules, window.horizon, state, moves, chosen)
        for choice in range(chosen):
            j, delta_v = moves.body[choice], moves.delta_v[choice]
            slot = base[local[i], local[j]] + _taken(rules.table, i, j, now)
            value = nodes.value[n] + rules.prize[j] - worth.per_m_s * delta_v
            used = 0.0 if rules.is_station[j] else nodes.used[n] + delta_v
            m = known[tank, slot]
            if m < 0:
                if count == nodes.body.size:
                    break
                m = count
                count += 1
                known[tank, slot] = m
                nodes.body[m], nodes.end[m], nodes.delta_v[m] = j, moves.end[choice], delta_v
                nodes.tank[m], nodes.origin[m] = tank + rules.is_station[j], i
                nodes.used[m], nodes.value[m] = used, value
                heapq.heappush(heap, (moves.end[choice], m))
            else:
                nodes.used[m] = min(nodes.used[m], used)
                nodes.value[m] = max(nodes.value[m], value)
            nodes.tail[n, nodes.degree[n]] = m
            nodes.degree[n] += 1
    return count


@inlined
def _pace(window, now, move):
    """Worth of the current plan at a time, interpolated between the ends of its moves.

    Returns
    -------
    value : float
    move : int
        The last of its moves that has ended by then, at least the given one.
    """
    ends, values = window.pace_ends, window.pace_values
    while move + 1 < ends.size and ends[move + 1] <= now:
        move += 1
    value = values[move]
    if move + 1 < ends.size:
        share = (now - ends[move]) / (ends[move + 1] - ends[move])
        value += share * (values[move + 1] - value)
    return value, move


@inlined
def _target_moves(rules, window, limits, state, origin, offers, cost, moves):
    """The cheapest moves to targets, cheapest first, but not back at once.

    Parameters
    ----------
    state : State
    origin : int
        The body before.
    offers, cost : Moves, (targets,) float64
        Scratch: the move to each target of the window, and what it costs.
    moves : Moves
        Those kept are written here.

    Returns
    -------
    int
        How many there are.
    """
    now = state.resources.time
    for c in range(cost.size):
        j, cost[c] = offers.body[c], math.inf
        if j != state.body and j != origin:
            legal, offers.delta_v[c], after = rule_kernels.step(rules, state, j)
            offers.end[c] = after.resources.time
            if legal and offers.end[c] <= window.horizon:
                cost[c] = offers.delta_v[c] + limits.time_value * (offers.end[c] - now)
    for choice in range(limits.width):
        best, least = -1, math.inf
        for c in range(cost.size):
            if cost[c] < least:
                best, least = c, cost[c]
        if best < 0:
            return choice
        cost[best] = math.inf
        moves.body[choice] = offers.body[best]
        moves.delta_v[choice], moves.end[choice] = offers.delta_v[best], offers.end[best]
    return limits.width


@inlined
def _station_moves(rules, horizon, state, moves, chosen):
    """Append the moves to stations to those chosen; returns the new number."""
    for j in range(rules.stations):
        if j != state.body:
            legal, delta_v, after = rule_kernels.step(rules, state, j)
            if legal and after.resources.time <= horizon:
                moves.body[chosen], moves.delta_v[chosen] = j, delta_v
                moves.end[chosen] = after.resources.time
                chosen += 1
    return chosen


@kernel
def _in_order(rules, worth, window, nodes, count):
    """The network of some nodes, numbered in order of time, with the rest flown from each."""
    rules, order = borrowed(rules), nodes.order[:count]
    place, head = np.empty(count, dtype=np.int64), np.zeros(count + 1, dtype=np.int64)
    for index in range(count):
        place[order[index]] = index
        head[index + 1] = head[index] + nodes.degree[order[index]]
    tail = np.empty(head[count], dtype=np.int64)
    rest_worth, rest_need = np.empty(count), np.empty(count)
    for index in range(count):
        n = order[index]
        for e in range(nodes.degree[n]):
            tail[head[index] + e] = place[nodes.tail[n, e]]
        flown = fly_rest(rules, worth, window.rest, nodes.body[n], nodes.end[n])
        rest_worth[index], rest_need[index] = flown
    return WindowNetwork(
        nodes.body[order],
        nodes.end[order],
        nodes.delta_v[order],
        nodes.tank[order],
        rest_worth,
        rest_need,
        np.full(count, -1, dtype=np.int64),
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
