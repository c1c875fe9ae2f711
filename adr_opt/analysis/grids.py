"""Alternative grids of drift legs: the cost of a plan's orders with finer and coarser steps.

The step of the grid, ``drift_step_s``, decides which departures and arrivals drift legs may have. A
finer one offers more of them, and takes more work; a coarser one less of both. Which one pays shows
when the orders of a plan are scheduled on the others: that takes the connections of their own pairs
alone.
"""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

from ..legs.connection_finder import ConnectionFinder
from ..mission.problem import Problem
from ..mission.schedule import Scheduler
from ..plan.plan import Plan
from ..problem.transfer_sizes import in_days

FINER, COARSER = 0.5, 2.0
"""Steps to try, as multiples of the instance's."""

WORTH_FINER, WORTH_COARSER = 0.05, 0.03
"""Least saving of ΔV for a finer grid, and largest loss for a coarser one, as shares."""

LONGEST_TRIED = 1000
"""Maximum number of steps per mission in the finest grid, at a second of work per pair."""


class GridTrial(NamedTuple):
    """Cost of a plan's orders on another grid.

    Attributes
    ----------
    step_s : float
        Of the grid [s].
    delta_v_m_s : float
        ΔV of their cheapest schedules; infinite if they cannot be flown [m/s].
    """

    step_s: float
    delta_v_m_s: float


def on_grid(problem: Problem, plan: Plan, step_s: float) -> GridTrial:
    """Schedule the orders of a plan at least cost on a grid with another step.

    Parameters
    ----------
    problem : Problem
        Whose rules are held to; no timetable of the other grid is built.
    plan : Plan
    step_s : float
        [s].
    """
    instance = problem.instance
    other = ConnectionFinder(
        instance.replace(transfer=instance.transfer.replace(drift_step_s=step_s))
    )
    missions = {mission.chaser.name: mission for mission in problem.missions}
    orders = plan.orders if len(missions) > 1 else {name: plan.destinations for name in missions}
    total = 0.0
    for name, order in orders.items():
        mission = missions[name]
        moves = tuple(mission.numbers(order).tolist())
        rules, price = partial(getattr, mission, "rules"), instance.time_m_s_per_s
        scheduler = Scheduler(other, rules, instance.objective.cost, mission.chaser, price)
        schedule = scheduler.of(moves)
        total += schedule.delta_v if schedule.made == len(moves) else math.inf
    return GridTrial(step_s, total)


def grid_advice(problem: Problem, plan: Plan) -> str | None:
    """A sentence recommending a finer or coarser grid; None if neither pays.

    A finer grid pays where the orders of the plan cost at least 5 % less on it, a coarser one where
    the plan is not proven to be optimal, and its orders cost at most 3 % more.

    Parameters
    ----------
    problem : Problem
        That was planned.
    plan : Plan
    """
    instance = problem.instance
    transfer, duration = instance.transfer, instance.mission.duration_s
    drifts = [leg for leg in plan.legs if leg.traits.on_time_grid]
    if not drifts or transfer.given is not None or instance.objective.cost != "delta-v":
        return None
    step, planned = transfer.drift_step_s, plan.delta_v_m_s
    if duration <= LONGEST_TRIED * FINER * step:
        finer = on_grid(problem, plan, FINER * step)
        if finer.delta_v_m_s <= (1.0 - WORTH_FINER) * planned:
            return (
                f"a finer grid pays: with drift_step_s = {finer.step_s:g} "
                f"({in_days(finer.step_s)}) the same orders take {finer.delta_v_m_s:.0f} m/s, "
                f"not {planned:.0f}"
            )
    if plan.status == "optimal":
        return None
    coarser = on_grid(problem, plan, COARSER * step)
    if coarser.delta_v_m_s <= (1.0 + WORTH_COARSER) * planned:
        return (
            f"a coarser grid is enough: with drift_step_s = {coarser.step_s:g} "
            f"({in_days(coarser.step_s)}) the same orders take {coarser.delta_v_m_s:.0f} m/s, not "
            f"{planned:.0f}, with far fewer connections to search"
        )
    return None
