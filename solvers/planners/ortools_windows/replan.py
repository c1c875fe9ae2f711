"""Joint replanning of windows of some chasers' orders."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from adr_opt.kernels.rules.rules import Rules

from .fleet import Fleet
from .joined import joined
from .model import best_paths
from .order import ClosedOrder, Pace, filled, flown
from .prices import edge_worths
from .unrolling import grow
from .window_network import SlackWorth, UnrollLimits, Window, fly_rest, nearest

GAIN = 0.005
"""Least gain in mean prizes; no window is replanned for a few seconds."""

TARGETS = 60
"""Maximum number of unvisited targets offered to a window."""

SUBGRADIENT_STEPS = 60


@dataclass(frozen=True)
class WindowChoice:
    """A choice of windows, with their evaluation.

    Attributes
    ----------
    spans : mapping of int to (int, int)
        By the number of a chaser: the moves from the first number to before the second one.
    delta_v_share : float
        Worth of the whole ΔV of an order relative to its prize.
    seed : int
        Of CP-SAT.
    """

    spans: Mapping[int, tuple[int, int]]
    delta_v_share: float
    seed: int


@dataclass(frozen=True)
class ReplannedWindows:
    """A plan with some windows replanned.

    Attributes
    ----------
    fleet : Fleet or None
        None if the windows gave nothing better.
    counters : mapping
        What happened, as counts to add up.
    """

    fleet: Fleet | None
    counters: Mapping[str, int]


def replan(
    present: Fleet,
    choice: WindowChoice,
    *,
    time_share: float,
    limits: UnrollLimits,
    edges: int,
    effort: float,
    remaining_s: float,
) -> ReplannedWindows:
    """Replan some windows, and fill the plan up.

    Parameters
    ----------
    present : Fleet
        With at least one move.
    choice : WindowChoice
    time_share : float
        Worth of the mission's duration relative to the prize of an order.
    limits : Limits
    edges : int
        Most edges that CP-SAT gets.
    effort, remaining_s
        See :func:`.model.best_paths`.
    """
    unit, chasers = present.unit, tuple(choice.spans)
    worth = present.worth(chasers, time_share, choice.delta_v_share)
    orders = {chaser: present.orders[chaser] for chaser in chasers}
    layers = {chaser: present.offered(chaser, anew=chasers) for chaser in chasers}
    paces = {chaser: order.pace(worth) for chaser, order in orders.items()}
    windows = {
        chaser: _window(
            layers[chaser].rules, chaser, orders, paces[chaser], choice, worth, limits.time_value
        )
        for chaser in chasers
    }
    by_layer, exactly = 0.0, 0.0
    for chaser in chasers:
        rules, window = layers[chaser].rules, windows[chaser]
        begin = choice.spans[chaser][0]
        one, other = _worth_from(rules, orders[chaser], begin, paces[chaser], window, worth)
        by_layer, exactly = by_layer + one, exactly + other
    goal = max(by_layer, exactly - unit) + GAIN * unit
    nets = [grow(layers[k].rules, worth, windows[k], limits) for k in chasers]
    parts = [(layers[k].rules, windows[k], net) for k, net in zip(chasers, nets, strict=True)]
    together = joined(parts)
    _, worths = edge_worths(together, worth, goal, SUBGRADIENT_STEPS)
    counters = {"full_networks": sum(int(net.body.size == limits.nodes) for net in nets)}
    kept = np.flatnonzero(worths >= goal)
    if kept.size == 0:
        return ReplannedWindows(None, counters | {"closed_by_prices": 1})
    if kept.size > edges:
        kept = np.sort(np.argpartition(-worths, edges)[:edges])
    answer = best_paths(
        together,
        worth,
        kept,
        goal,
        unit=unit,
        seed=choice.seed,
        effort=effort,
        remaining_s=remaining_s,
    )
    counters |= {"solves": 1, "solves_completed": int(answer.closed)}
    if answer.paths is None:
        return ReplannedWindows(None, counters)
    changed: dict[int, ClosedOrder] = {}
    for chaser, path in zip(chasers, answer.paths, strict=True):
        before, after = orders[chaser].moves[: choice.spans[chaser][0]], windows[chaser].rest
        moves = np.concatenate((before, np.array(path, dtype=np.int64), after))
        order = flown(layers[chaser], moves)
        if order is None:
            return ReplannedWindows(None, counters | {"grounded": 1})
        changed[chaser] = order
    fleet = filled_up(present.with_orders(changed), chasers, worth, limits.time_value)
    value = math.fsum(fleet.orders[chaser].pace(worth).value for chaser in chasers)
    if value <= math.fsum(pace.value for pace in paces.values()):
        return ReplannedWindows(None, counters | {"no_gains": 1})
    return ReplannedWindows(fleet, counters | {"gains": 1})


def filled_up(
    fleet: Fleet, chasers: tuple[int, ...], worth: SlackWorth, time_value: float
) -> Fleet:
    """A plan with the orders of some chasers filled up, one after another."""
    for chaser in chasers:
        layer = fleet.offered(chaser)
        order = filled(layer, fleet.orders[chaser], worth, time_value)
        fleet = fleet.with_orders({chaser: order})
    return fleet


def _worth_from(
    rules: Rules, order: ClosedOrder, begin: int, pace: Pace, window: Window, worth: SlackWorth
) -> tuple[float, float]:
    """Worth of the current order from its window on.

    By the connections that a path has, and by its best schedule. That may have others, and the
    moves not be possible by these: then a visit less will do, and it is for the schedule of the new
    order to be better.
    """
    from_here = order.moves[begin:]
    by_layer, need = fly_rest(rules, worth, from_here, window.body, window.time)
    prize = float(rules.prize[from_here].sum())
    drawn = float(pace.costs[-1] - pace.costs[begin])
    exactly = prize - worth.per_m_s * drawn - worth.per_s * float(pace.times[-1])
    return (by_layer if need <= window.left else -math.inf), exactly


def _window(
    rules: Rules,
    chaser: int,
    orders: Mapping[int, ClosedOrder],
    pace: Pace,
    choice: WindowChoice,
    worth: SlackWorth,
    time_value: float,
) -> Window:
    """Window of a chaser, open to the targets of all windows and to unvisited ones."""
    order, (begin, end) = orders[chaser], choice.spans[chaser]
    plan = order.moves
    inside, rest = plan[begin:end], plan[end:]
    ends = pace.times[begin:]
    gained = np.concatenate(([0.0], np.cumsum(rules.prize[plan[begin:]])))
    values = (
        gained
        - worth.per_m_s * (pace.costs[begin:] - pace.costs[begin])
        - worth.per_s * (ends - ends[0])
    )
    moves = inside.size
    # The rest may start later by as much as the plan ends early.
    latest = rules.duration - float(ends[-1] - ends[moves]) if rest.size else rules.duration
    taken = np.zeros(rules.prize.size, dtype=np.bool_)
    for each in orders.values():
        taken[each.moves] = True
    new = np.flatnonzero(~taken & (rules.prize > 0.0))
    if new.size > TARGETS:
        cost = np.empty(new.size)
        stops = np.concatenate((pace.bodies[begin : begin + 1], inside))
        nearest(rules, stops, ends[: moves + 1], new, time_value, cost)
        new = new[np.argsort(cost, kind="stable")[:TARGETS]]
    given_up = [orders[other].moves[slice(*span)] for other, span in choice.spans.items()]
    stations = rules.is_station[inside]
    return Window(
        int(pace.bodies[begin]),
        float(ends[0]),
        float(pace.lefts[begin]),
        np.sort(np.concatenate((*(some[some >= rules.first_target] for some in given_up), new))),
        rest,
        latest,
        (int(np.count_nonzero(stations)) + 1) if rules.stations else 0,
        int(rules.limits.targets) - order.targets + int(np.count_nonzero(~stations)),
        ends[: moves + 1],
        values[: moves + 1],
    )
