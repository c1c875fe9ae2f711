"""Network of one window: every exact move that a better plan could make in it.

A node is a state of the chaser (body, free since, refuellings in the window) and an edge is one
move by the connection that the mission's choice makes. Nothing is rounded, so a path is a piece of
a plan and times itself. Every node also says what the *rest* of the plan, the moves after the
window, is worth when it is flown from there. Other connections may do better, never worse: the
best schedule of the whole order decides in the end.
"""

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.rules.resources import Resources
from adr_opt.kernels.rules.rules import State


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
