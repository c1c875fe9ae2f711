"""One window of a plan, planned anew."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.constants import STATION
from adr_opt.mission import Mission
from adr_opt.schedule import Schedule

from . import fill, network
from .model import best_path
from .prices import edge_worths

Bodies = npt.NDArray[np.int64]

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
    sequence : (moves,) int64 or None
        None if the window gave nothing better.
    counters : mapping
        What happened, as counts to add up.
    """

    sequence: Bodies | None
    counters: Mapping[str, int]


def replan(
    mission: Mission,
    plan: Bodies,
    timing: Schedule,
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
    mission : Mission
    plan : (moves,) int64
        Legal, with at least one move.
    timing : Schedule
        Of the plan.
    choice : Choice
    time_share : float
        Worth of the mission's duration relative to the prize of the plan.
    limits : Limits
    edges : int
        Most edges that CP-SAT gets.
    effort, remaining_s
        See :func:`.model.best_path`.
    """
    rules = mission.rules
    unit = float(rules.prize[rules.prize > 0.0].mean())
    scale = max(timing.objective, unit)
    worth = network.Worth(
        time_share * scale / rules.duration,
        choice.delta_v_share * scale / max(timing.delta_v, 1.0),
    )
    window, present = _window(mission, plan, timing, choice, worth, limits.time_value)
    goal = present + GAIN * unit
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
    changed = np.concatenate((plan[: choice.begin], path, window.rest))
    return Replanned(fill.filled(rules, changed, limits.time_value), counters | {"gains": 1})


def _window(
    mission: Mission,
    plan: Bodies,
    timing: Schedule,
    choice: Choice,
    worth: network.Worth,
    time_value: float,
) -> tuple[network.Window, float]:
    """The window of a choice, and the worth of the plan from its start on."""
    rules = mission.rules
    begin, end = choice.begin, choice.end
    rest = plan[end:]
    body, time, left = STATION, 0.0, rules.budget
    if begin > 0:
        body, time = int(plan[begin - 1]), float(timing.ends[begin - 1])
        left = float(timing.lefts[begin - 1])
    ends, values = network.fly(rules, worth, body, time, plan[begin:])
    moves = end - begin
    present = float(values[-1]) - worth.per_s * time
    # The rest may start later by as much as the plan ends early.
    latest = rules.duration - float(ends[-1] - ends[moves])
    inside = plan[begin:end]
    taken = np.zeros(rules.prize.size, dtype=np.bool_)
    taken[plan] = True
    new = np.flatnonzero(~taken & (rules.prize > 0.0))
    if new.size > TARGETS:
        cost = np.empty(new.size)
        stops = np.concatenate(([body], inside))
        network.nearest(rules, stops, ends[: moves + 1], new, time_value, cost)
        new = new[np.argsort(cost, kind="stable")[:TARGETS]]
    refuels = int(np.count_nonzero(inside == STATION)) + 1
    window = network.Window(
        body, time, left,
        np.sort(np.concatenate((inside[inside != STATION], new))),
        rest,
        rules.duration if rest.size == 0 else latest,
        refuels,
        ends[: moves + 1],
        values[: moves + 1],
    )  # fmt: skip
    return window, present
