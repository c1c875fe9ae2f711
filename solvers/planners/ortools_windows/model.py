"""Windows as a CP-SAT model: the best path through each, with no target visited twice."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from ortools.sat.python import cp_model

from ...models.cp_sat import cp_sat
from .joined import Joined
from .window_network import SlackWorth

WORTH_STEPS = 1_000_000
"""Integer units per mean prize in the objective."""

DELTA_V_STEPS = 100
"""Integer units per m/s. ΔV is rounded up and tanks down, so that every path found is legal."""


@dataclass(frozen=True)
class WindowAnswer:
    """CP-SAT's answer for some windows.

    Attributes
    ----------
    paths : tuple of tuple of int, or None
        Bodies in order for each; None if no paths reach the goal, or none were found in time.
    closed : bool
        Whether the search was complete.
    """

    paths: tuple[tuple[int, ...], ...] | None
    closed: bool


def best_paths(
    joined: Joined,
    worth: SlackWorth,
    kept: npt.NDArray[np.int64],
    goal: float,
    *,
    unit: float,
    seed: int,
    effort: float,
    remaining_s: float,
) -> WindowAnswer:
    """Find the best path through each window.

    Parameters
    ----------
    joined, worth
        The windows, unrolled.
    kept : (edges,) int64
        Edges of the network to choose from.
    goal : float
        Least worth of interest, of all paths together.
    unit : float
        Mean prize: sets the scale of the integers.
    seed : int
        Of CP-SAT.
    effort : float
        Limit in CP-SAT's deterministic time, about seconds.
    remaining_s : float
        Wall time left, +inf for none: a cap in need only, so that results repeat.
    """
    model = cp_model.CpModel()
    net = joined.net
    tails = np.searchsorted(net.head, kept, side="right") - 1
    heads = net.tail[kept]
    bodies = net.body[heads]
    moves = [model.new_bool_var("") for _ in range(kept.size)]
    leaving: dict[int, list[cp_model.IntVar]] = {0: []}
    arriving: dict[int, list[cp_model.IntVar]] = {root: [] for root in joined.roots[1:].tolist()}
    visits: dict[int, list[cp_model.IntVar]] = {}
    for move, tail, head, body in zip(
        moves, tails.tolist(), heads.tolist(), bodies.tolist(), strict=True
    ):
        leaving.setdefault(tail, []).append(move)
        arriving.setdefault(head, []).append(move)
        if body >= joined.first_target:
            visits.setdefault(body, []).append(move)
    nodes = np.array(sorted({0, *arriving}), dtype=np.int64)
    exits = nodes[np.isfinite(net.rest_worth[nodes])]
    lasts = [model.new_bool_var("") for _ in range(exits.size)]
    for last, node, root in zip(lasts, exits.tolist(), net.onward[exits].tolist(), strict=True):
        leaving.setdefault(node, []).append(last)
        if root >= 0:
            arriving[root].append(last)

    # One path from the start of each window to an exit, and no target twice.
    model.add_exactly_one(leaving[0])
    for node, into in arriving.items():
        model.add(sum(leaving.get(node, [])) == sum(into))
    for calls in visits.values():
        model.add_at_most_one(calls)
    _hold_targets(model, joined, moves, heads)

    terms = [*moves, *lasts]
    _hold_tanks(
        model,
        terms,
        np.concatenate((net.tank[tails], net.tank[exits])),
        np.concatenate((net.delta_v[heads], net.rest_need[exits])),
        joined.tanks.tolist(),
    )
    gains = joined.prize[bodies] - worth.per_m_s * net.delta_v[heads]
    # The last window is left once: taking the goal off its exits keeps the integers small.
    ends = net.rest_worth[exits] - np.where(net.onward[exits] < 0, goal, 0.0)
    values = np.concatenate((gains, ends)) / unit
    value = cp_model.LinearExpr.weighted_sum(
        terms, np.rint(values * WORTH_STEPS).astype(np.int64).tolist()
    )
    model.add(value >= 0)
    model.maximize(value)

    solver = cp_sat(seed, remaining_s, effort)
    status = solver.solve(model)
    closed = status in (cp_model.OPTIMAL, cp_model.INFEASIBLE)
    if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        return WindowAnswer(None, closed)
    following = {
        tail: head
        for move, tail, head in zip(moves, tails.tolist(), heads.tolist(), strict=True)
        if solver.boolean_value(move)
    }
    paths = []
    for node in joined.roots.tolist():
        path = []
        while node in following:
            node = following[node]
            path.append(int(net.body[node]))
        paths.append(tuple(path))
    return WindowAnswer(tuple(paths), closed)


def _hold_targets(
    model: cp_model.CpModel,
    joined: Joined,
    moves: list[cp_model.IntVar],
    heads: npt.NDArray[np.int64],
) -> None:
    """Keep each chaser within its maximum number of targets."""
    bodies = joined.net.body[heads]
    windows = np.searchsorted(joined.roots, heads, side="right") - 1
    for number, most in enumerate(joined.most_targets.tolist()):
        its = np.flatnonzero((windows == number) & (bodies >= joined.first_target))
        if most < np.unique(bodies[its]).size:
            model.add(sum(moves[move] for move in its) <= most)


def _hold_tanks(
    model: cp_model.CpModel,
    terms: list[cp_model.IntVar],
    tank: npt.NDArray[np.int64],
    delta_v: npt.NDArray[np.float64],
    capacity: list[float],
) -> None:
    """Keep the ΔV drawn from each tank within its content."""
    needs = np.ceil(delta_v * DELTA_V_STEPS).astype(np.int64)
    for number, left in enumerate(capacity):
        inside = np.flatnonzero(tank == number)
        drawn = cp_model.LinearExpr.weighted_sum(
            [terms[index] for index in inside], needs[inside].tolist()
        )
        model.add(drawn <= math.floor(left * DELTA_V_STEPS))
