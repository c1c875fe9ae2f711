"""The incumbent: the only place where plans are compared (docs/model.md section 5)."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, Routes, problem_of
from adr_opt.plan.station_limits import Use


class Incumbent:
    """The best plan offered so far: by prize, then by cost.

    Parameters
    ----------
    problem : Problem or Mission
    by_choice : bool
        Cost is that of the connections that the choice of the timetable makes, for planners of one
        chaser that come by plans more quickly than by their best schedules.

    Attributes
    ----------
    routes : tuple of tuple of int or None
        Bodies in order for each chaser; None before the first plan.
    objective : float
        Prizes, −inf before the first plan.
    cost : float
        What the plan costs at its best schedules, or by choice; +inf before the first plan.
    """

    def __init__(self, problem: Problem | Mission, *, by_choice: bool = False) -> None:
        self._problem = problem_of(problem)
        self._by_choice = by_choice
        self.routes: Routes | None = None
        self.objective = -math.inf
        self.cost = math.inf

    @property
    def sequence(self) -> tuple[int, ...] | None:
        """Route of the only chaser; None before the first plan."""
        return None if self.routes is None else self.routes[0]

    def offer(self, *routes: Iterable[int]) -> bool:
        """Offer routes, one for each chaser; returns whether they are the best plan.

        They are closed first (:meth:`adr_opt.mission.mission.Mission.closed`). What cannot be flown
        to its end, or may not end there, visits a target on two routes or takes more of a station
        than it has is no plan.
        """
        moves = tuple(tuple(int(j) for j in route) for route in routes)
        objective = self._problem.collected(j for route in moves for j in route)
        if objective < self.objective or moves == self.routes:
            return False
        falls = self._problem.falls is not None
        tie = objective == self.objective
        if tie and len(moves) == 1 and not self._by_choice and not falls:
            alone = self._problem.alone
            if alone is not None and alone.schedules.least_cost(moves[0]) >= self.cost:
                return False
        moves = self._problem.closed(moves)
        cost, lost = self._cost_of(moves)
        objective = self._problem.in_steps(objective - lost)
        tie = objective == self.objective
        if cost == math.inf or objective < self.objective or (tie and cost >= self.cost):
            return False
        self.routes, self.objective, self.cost = moves, objective, cost
        return True

    def _cost_of(self, routes: Routes) -> tuple[float, float]:
        """Total cost of routes, +inf if they are not a plan, and the losses of falling prizes."""
        problem, costs, uses, lost = self._problem, list[float](), list[Use](), 0.0
        first = problem.instance.first_target
        targets = [j for route in routes for j in route if j >= first]
        if len(routes) > 1 and len(set(targets)) < len(targets):
            return math.inf, lost
        for mission, route in zip(problem.missions, routes, strict=True):
            if not mission.may_stop(route):
                return math.inf, lost
            if self._by_choice:
                cost, worth = _by_choice(mission, route)
            else:
                schedule = mission.time(route)
                if schedule.made < len(route):
                    return math.inf, lost
                cost, worth = schedule.cost, schedule.objective
                uses.append(problem.use(mission, route, schedule.delta_vs))
            if cost == math.inf:
                return math.inf, lost
            costs.append(cost)
            if problem.falls is not None:
                lost += problem.collected(route) - worth
        if not problem.limits.allow(uses):
            return math.inf, lost
        return problem.instance.objective.together(costs), lost


def _by_choice(mission: Mission, moves: tuple[int, ...]) -> tuple[float, float]:
    """Cost and worth of a route over the timetable's connections; +inf if it cannot be flown."""
    rules, sequence = mission.rules, np.array(moves, dtype=np.int64)
    ends, lefts = np.empty((2, len(moves)))
    made, delta_v, state = rule_kernels.replay(
        rules,
        sequence,
        rule_kernels.beginning(rules),
        np.zeros(rules.service.size, dtype=np.bool_),
        ends,
        lefts,
    )
    if made < len(moves):
        return math.inf, 0.0
    worth = 0.0 if rules.falls is None else float(rule_kernels.collected(rules, sequence, ends))
    if mission.instance.objective.cost == "duration":
        return float(state.resources.time), worth
    paid = mission.instance.time_m_s_per_s * (state.resources.time - rules.ready)
    return (float(delta_v + paid) if made else 0.0), worth
