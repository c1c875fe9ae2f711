"""One window of a plan, planned anew."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from adr_opt.kernels.rules import Rules
from adr_opt.mission import Mission
from adr_opt.schedule import Schedule

from . import network
from .model import best_path
from .order import Order, Pace, filled, flown
from .prices import edge_worths

GAIN = 0.005
"""Least gain of interest, in mean prizes: no window is planned anew for a few seconds."""

TARGETS = 60
"""Most targets open to a window."""

SUBGRADIENT_STEPS = 60


@dataclass(frozen=True)
class Choice:
    """Which window, and how it is judged.

    Attributes
    ----------
    begin, end : int
        The moves ``begin`` to ``end`` − 1 of the plan.
    delta_v_share : float
        Worth of the whole ΔV of the plan relative to its prize.
    seed : int
        Of CP-SAT.
    """

    begin: int
    end: int
    delta_v_share: float
    seed: int


@dataclass(frozen=True)
class Replanned:
    """A plan with one window planned anew.

    Attributes
    ----------
    order : Order or None
        None if the window gave nothing better.
    counters : mapping
        What happened, as counts to add up.
    """

    order: Order | None
    counters: Mapping[str, int]


def replan(
    layer: Mission,
    present: Order,
    choice: Choice,
    *,
    time_share: float,
    limits: network.Limits,
    edges: int,
    effort: float,
    remaining_s: float,
) -> Replanned:
    """Plan one window anew, and fill the plan up.

    Parameters
    ----------
    layer : Mission
        The mission with the connections that windows choose from.
    present : Order
        With at least one move.
    choice : Choice
    time_share : float
        Worth of the mission's duration relative to the prize of the plan.
    limits : Limits
    edges : int
        Most edges that CP-SAT gets.
    effort, remaining_s
        See :func:`.model.best_path`.
    """
    rules, timing = layer.rules, present.timing
    unit = float(rules.prize[rules.prize > 0.0].mean())
    worth = worth_of(rules, timing, time_share, choice.delta_v_share)
    pace = present.pace(worth)
    window = _window(rules, present, pace, choice, worth, limits.time_value)
    # What the present plan is worth from there on by the connections that a path has. The best
    # schedule may have others, and the moves not be possible by these: then a visit less will do,
    # and it is for the schedule of the new order to be better.
    from_here = present.moves[choice.begin :]
    by_layer, need = network.fly_rest(rules, worth, from_here, window.body, window.time)
    prize = float(rules.prize[from_here].sum())
    drawn = float(pace.costs[-1] - pace.costs[choice.begin])
    exactly = prize - worth.per_m_s * drawn - worth.per_s * float(pace.times[-1])
    if need > window.left:
        by_layer = -math.inf
    goal = max(by_layer, exactly - unit) + GAIN * unit
    net = network.grow(rules, worth, window, limits)
    _, worths = edge_worths(rules, worth, net, window, goal, SUBGRADIENT_STEPS)
    counters = {"full_networks": int(net.body.size == limits.nodes)}
    kept = np.flatnonzero(worths >= goal)
    if kept.size == 0:
        return Replanned(None, counters | {"closed_by_prices": 1})
    if kept.size > edges:
        kept = np.sort(np.argpartition(-worths, edges)[:edges])
    answer = best_path(
        rules, worth, net, kept, window, goal,
        unit=unit, seed=choice.seed, effort=effort, remaining_s=remaining_s,
    )  # fmt: skip
    counters |= {"solves": 1, "solves_completed": int(answer.closed)}
    if answer.path is None:
        return Replanned(None, counters)
    path = np.array(answer.path, dtype=np.int64)
    changed = flown(layer, np.concatenate((present.moves[: choice.begin], path, window.rest)))
    if changed is None:
        return Replanned(None, counters | {"grounded": 1})
    changed = filled(layer, changed, worth, limits.time_value)
    if changed.pace(worth).value <= pace.value:
        return Replanned(None, counters | {"no_gains": 1})
    return Replanned(changed, counters | {"gains": 1})


def worth_of(
    rules: Rules, timing: Schedule, time_share: float, delta_v_share: float
) -> network.Worth:
    """What time and ΔV are worth beside the prize of a plan."""
    scale = max(timing.objective, float(rules.prize[rules.prize > 0.0].mean()))
    return network.Worth(
        time_share * scale / rules.duration, delta_v_share * scale / max(timing.delta_v, 1.0)
    )


def _window(
    rules: Rules,
    present: Order,
    pace: Pace,
    choice: Choice,
    worth: network.Worth,
    time_value: float,
) -> network.Window:
    """The window of a choice."""
    plan, begin, end = present.moves, choice.begin, choice.end
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
    taken[plan] = True
    new = np.flatnonzero(~taken & (rules.prize > 0.0))
    if new.size > TARGETS:
        cost = np.empty(new.size)
        stops = np.concatenate((pace.bodies[begin : begin + 1], inside))
        network.nearest(rules, stops, ends[: moves + 1], new, time_value, cost)
        new = new[np.argsort(cost, kind="stable")[:TARGETS]]
    stations = rules.is_station[inside]
    return network.Window(
        int(pace.bodies[begin]),
        float(ends[0]),
        float(pace.lefts[begin]),
        np.sort(np.concatenate((inside[~stations], new))),
        rest,
        latest,
        (int(np.count_nonzero(stations)) + 1) if rules.stations else 0,
        int(rules.most_targets) - present.targets + int(np.count_nonzero(~stations)),
        ends[: moves + 1],
        values[: moves + 1],
    )
