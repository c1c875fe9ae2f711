"""The classical static bound: what a planner would prove who does not know when he flies."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from ortools.sat.python import cp_model

from adr_opt.kernels import timetable as timetables
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION
from adr_opt.kernels.rules import Rules
from adr_opt.mission import Mission
from adr_opt.planner import Progress
from adr_opt.result import Result, certify
from adr_opt.stop import Stop

from .exact_models.answer import Hear
from .exact_models.cp_sat_run import run
from .exact_models.standing import Standing
from .exact_models.steps import in_steps
from .proof import bound_notes

STEPS_PER_M_S = 1e3
STEPS_PER_S = 1e1
"""ΔV and time are counted in whole steps; those of a leg are rounded down, limits up."""


class Costs(NamedTuple):
    """Every leg at its best, in whole steps; −1 where there is none.

    Attributes
    ----------
    delta_v : (bodies, bodies) int64
        Least ΔV over all departures.
    duration : (bodies, bodies) int64
        Least time from departure to the end of the service over all departures, another one or
        the same.
    """

    delta_v: np.ndarray
    duration: np.ndarray


@kernel
def _best_legs(rules, delta_v, duration):
    """Least ΔV [m/s] and least time from departure to end of service [s] of every pair."""
    table = rules.table
    for i in range(rules.service.size):
        for j in range(rules.service.size):
            for m in range(timetables.events(table, i, j)):
                cost, arrival = timetables.entry_at(table, i, j, m)
                end = arrival + rules.service[j]
                if cost <= rules.budget and end <= rules.duration:
                    flown = end - timetables.departure_at(table, i, j, m)
                    delta_v[i, j] = min(delta_v[i, j], cost)
                    duration[i, j] = min(duration[i, j], flown)


def static_costs(rules: Rules) -> Costs:
    """Every leg at its best over all departures that the mission has."""
    bodies = rules.service.size
    delta_v = np.full((bodies, bodies), math.inf)
    duration = np.full((bodies, bodies), math.inf)
    _best_legs(rules, delta_v, duration)
    return Costs(_steps(delta_v, STEPS_PER_M_S), _steps(duration, STEPS_PER_S))


def _steps(values: np.ndarray, per_unit: float) -> np.ndarray:
    known = np.isfinite(values)
    return np.where(known, np.floor(np.where(known, values, 0.0) * per_unit), -1).astype(np.int64)


class StaticModel:
    """Orienteering with refuelling on static costs.

    A route begins at the station, services targets, each at most once, and ends anywhere. From a
    target it goes to the next one straight, or by way of the station with a full tank from there.

    Parameters
    ----------
    costs : Costs
    worth : (bodies,) int64
        Prizes in steps.
    budget, duration : int
        In steps.
    """

    def __init__(self, costs: Costs, worth: np.ndarray, budget: int, duration: int) -> None:
        self._costs = costs
        self._budget = budget
        self._duration = duration
        self._targets = range(1, worth.size)
        self.block = cp_model.CpModel()
        self._visit = {j: self.block.new_bool_var("") for j in self._targets}
        self._used = {j: self.block.new_int_var(0, budget, "") for j in self._targets}
        self._end = {j: self.block.new_int_var(0, duration, "") for j in self._targets}
        pairs = [(i, j) for i in self._targets for j in self._targets if i != j]
        flown = costs.delta_v >= 0
        self._first = self._literals((STATION, j) for j in self._targets if flown[STATION, j])
        self._straight = self._literals(pair for pair in pairs if flown[pair])
        self._by_station = self._literals(
            (i, j) for i, j in pairs if flown[i, STATION] and flown[STATION, j]
        )
        self._one_route()
        self._delta_v_fits()
        self._time_fits()
        self.block.maximize(sum(int(worth[j]) * visit for j, visit in self._visit.items()))

    def _literals(self, pairs: Iterable[tuple[int, int]]) -> dict[tuple[int, int], cp_model.IntVar]:
        """A decision for each pair."""
        return {pair: self.block.new_bool_var("") for pair in pairs}

    def _one_route(self) -> None:
        """One route through the targets that are visited; node 0 is before it and after it."""
        arcs: list[tuple[int, int, cp_model.LiteralT]] = [(0, 0, self.block.new_bool_var(""))]
        arcs += [(j, j, visit.negated()) for j, visit in self._visit.items()]
        arcs += [(0, j, move) for (_, j), move in self._first.items()]
        arcs += [(j, 0, self.block.new_bool_var("")) for j in self._targets]
        for i, j in self._straight | self._by_station:
            ways = [way[i, j] for way in (self._straight, self._by_station) if (i, j) in way]
            move = self.block.new_bool_var("")
            self.block.add(sum(ways) == move)
            arcs.append((i, j, move))
        self.block.add_circuit(arcs)

    def _delta_v_fits(self) -> None:
        """What is used since refuelling adds up, and is never more than the budget."""
        cost, used = self._costs.delta_v, self._used
        for (_, j), move in self._first.items():
            self.block.add(used[j] >= cost[STATION, j]).only_enforce_if(move)
        for (i, j), move in self._straight.items():
            self.block.add(used[j] >= used[i] + cost[i, j]).only_enforce_if(move)
        for (i, j), move in self._by_station.items():
            self.block.add(used[j] >= cost[STATION, j]).only_enforce_if(move)
            self.block.add(used[i] + cost[i, STATION] <= self._budget).only_enforce_if(move)
        # Implied: all the ΔV comes out of the first tank and one more per refuelling.
        ways = [(move, cost[i, j]) for (i, j), move in (self._first | self._straight).items()]
        ways += [
            (move, cost[i, STATION] + cost[STATION, j] - self._budget)
            for (i, j), move in self._by_station.items()
        ]
        self.block.add(sum(move * int(need) for move, need in ways) <= self._budget)

    def _time_fits(self) -> None:
        """Services end one after the other, and before the mission does."""
        flown, end = self._costs.duration, self._end
        ways = [(i, j, move, flown[i, j]) for (i, j), move in self._straight.items()]
        ways += [
            (i, j, move, flown[i, STATION] + flown[STATION, j])
            for (i, j), move in self._by_station.items()
        ]
        for (_, j), move in self._first.items():
            self.block.add(end[j] >= flown[STATION, j]).only_enforce_if(move)
        for i, j, move, takes in ways:
            self.block.add(end[j] >= end[i] + takes).only_enforce_if(move)
        # Implied: each visit takes its least time at least. Weak, but understood at once.
        flights = np.where(flown >= 0, flown, self._duration).min(axis=0).tolist()
        self.block.add(
            sum(visit * flights[j] for j, visit in self._visit.items()) <= self._duration
        )
        # Implied: the route is not longer than the mission.
        firsts = [(move, flown[i, j]) for (i, j), move in self._first.items()]
        moves = firsts + [(move, takes) for _, _, move, takes in ways]
        self.block.add(sum(move * int(takes) for move, takes in moves) <= self._duration)


def routing_bound(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None = None,
) -> Result:
    """No plan is worth more than this: the classical static bound, weak and without a timetable.

    Every leg is taken at its best over all departures, the least ΔV and the least time each by
    itself, without waiting for the node. On these costs the orienteering problem with refuelling
    is given to CP-SAT, and the bound is CP-SAT's upper bound on it. It is valid: every plan is a
    route whose legs take at least that much of both, so it fits, for the same prize. What it
    lacks against the other bounds is what knowing the time is worth. Deterministic but for the
    time limit; one iteration. It looks for no plan.

    Parameters
    ----------
    mission, seed, stop, progress
    start : sequence of int, optional
        A plan: bodies in order. The bound may prove it optimal.
    """
    began = time.perf_counter()
    standing = Standing(mission, stop, progress)
    if start is not None:
        standing.offer(start)
    counters: dict[str, float] = {"branches": 0}
    if mission.total_prize > 0.0 and not standing.enough():
        rules = mission.rules
        worth, unit = in_steps(np.array(rules.prize), standing.step or mission.total_prize)
        model = StaticModel(
            static_costs(rules),
            worth,
            math.ceil(rules.budget * STEPS_PER_M_S),
            math.ceil(rules.duration * STEPS_PER_S),
        )

        def hear(bound: float) -> bool:
            standing.lower(bound)
            return standing.proven or standing.remaining_s() <= 0.0

        solver, _, bound = run(
            model.block, unit, seed=seed, hear=Hear(hear, standing.remaining_s), linear=2
        )
        standing.lower(bound)
        counters["branches"] = int(solver.num_branches)
    return certify(
        mission,
        "routing-bound",
        standing.sequence,
        seed=seed,
        runtime_s=time.perf_counter() - began,
        upper_bound=standing.bound,
        counters=counters,
        notes=bound_notes(mission),
    )
