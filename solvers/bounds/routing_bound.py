"""The classical static bound, valid for time-independent costs."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from ortools.sat.python import cp_model

from adr_opt.common.constants import TURN_RAD
from adr_opt.common.options import Options, option
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.common.tolerance import MOST_STEPS, are_multiples
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.windows import service_end
from adr_opt.kernels.legs import co_elliptic
from adr_opt.kernels.orbits.ephemeris import EPOCH_S
from adr_opt.kernels.rules.rules import Rules
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result

from ..models.cp_sat import run
from ..progress.gap import GapTracker
from ..progress.proof_size import bound_notes

STEPS_PER_M_S = 1e3
STEPS_PER_S = 1e1
"""Integer units per second, and per m/s; those of a leg are rounded down, limits up."""

PARTS = 2**40
"""Approximate sum of all prizes in steps, if they are not multiples of the unit."""


class Costs(NamedTuple):
    """Best costs of every leg, in integer units; −1 if there is none.

    Attributes
    ----------
    delta_v : (bodies, bodies) int64
        Least ΔV over all connections.
    duration : (bodies, bodies) int64
        Least time from departure to the end of the service over all connections, another one or
        the same.
    """

    delta_v: np.ndarray
    duration: np.ndarray


@kernel
def _least(j, departure, arrival, delta_v, rules):
    """Least ΔV [m/s] and least time from departure to end of service [s] of connections to j.

    Both are +inf if none fits the mission.
    """
    cost, flown = math.inf, math.inf
    for c in range(departure.size):
        end = service_end(rules.windows, j, arrival[c], rules.service[j])
        if delta_v[c] <= rules.budget and end < math.inf:
            cost = min(cost, delta_v[c])
            flown = min(flown, end - departure[c])
    return cost, flown


@kernel
def _floor(i, j, leaving, orbits, extra_delta_v, transfer_rule, rules):
    """Closed-form lower bounds on these minima, for any phase and without connections."""
    pair = co_elliptic.prepare(leaving[i], orbits[j], extra_delta_v[i, j], transfer_rule, EPOCH_S)
    approach = transfer_rule.approach_revolutions * TURN_RAD / pair.rate_j
    if pair.floor_delta_v > rules.budget:
        return math.inf, math.inf
    return pair.floor_delta_v, pair.shortest + approach + rules.service[j]


def static_costs(mission: Mission, enough: Callable[[], bool] = lambda: False) -> Costs:
    """Best costs of every leg over all connections of the mission.

    Parameters
    ----------
    mission : Mission
    enough : callable
        Asked at each pair. Once it says so, the rest of the pairs get what is known in closed form;
        not where nodes drift, since all connections are listed there before planning begins.
    """
    rules, connecting = mission.rules, mission.connecting
    bodies = rules.service.size
    delta_v, duration = np.full((2, bodies, bodies), math.inf)
    for i in range(bodies):
        for j in range(bodies):
            if i != j and (rules.is_station[j] or j >= rules.first_target):
                if not connecting.is_listed and enough():
                    least = _floor(i, j, *connecting.inputs, rules)
                else:
                    found = connecting.of_pair(i, j, connecting.planning_resolution_m_s)
                    least = _least(j, found.departure, found.arrival, found.delta_v, rules)
                delta_v[i, j], duration[i, j] = least
    return Costs(_steps(delta_v, STEPS_PER_M_S), _steps(duration, STEPS_PER_S))


def _steps(values: np.ndarray, per_unit: float) -> np.ndarray:
    known = np.isfinite(values)
    steps = np.floor(np.where(known, values, 0.0) * per_unit)
    return np.where(known, np.maximum(steps, 0.0), -1.0).astype(np.int64)


def in_steps(prize: np.ndarray, unit: float) -> tuple[np.ndarray, float]:
    """Prizes in whole steps, rounded up.

    Parameters
    ----------
    prize : (bodies,) float64
    unit : float
        The steps, if all prizes are multiples of it and there are not too many.

    Returns
    -------
    steps : (bodies,) int64
        Prizes in steps, rounded up.
    step : float
    """
    if are_multiples(prize.tolist(), unit) and prize.sum() / unit <= MOST_STEPS:
        return np.rint(prize / unit).astype(np.int64), unit
    step = float(prize.sum()) / PARTS
    # A quotient may be rounded down across an integer; one step more covers that.
    return np.where(prize > 0.0, np.floor(prize / step) + 1.0, 0.0).astype(np.int64), step


Way = TypeVar("Way", bound=Hashable)


class StaticModel:
    """Orienteering problem with refuelling on static costs.

    A route begins at the start and services targets, each at most once, in its window. From a
    target it goes to the next one straight, or by way of a station with a full tank from there. It
    ends anywhere, or by way of a station that it may end at.

    Parameters
    ----------
    costs : Costs
    worth : (bodies,) int64
        Prizes in steps.
    rules : adr_opt.kernels.rules.rules.Rules
    """

    def __init__(self, costs: Costs, worth: np.ndarray, rules: Rules) -> None:
        self._costs = costs
        self._rules = rules
        self._budget = math.ceil(rules.budget * STEPS_PER_M_S)
        self._duration = math.ceil(rules.duration * STEPS_PER_S)
        self._targets = range(rules.first_target, worth.size)
        self._stations = range(rules.stations)
        self.block = cp_model.CpModel()
        self._visit = {j: self.block.new_bool_var("") for j in self._targets}
        self._used = {j: self.block.new_int_var(0, self._budget, "") for j in self._targets}
        self._end = {j: self._time(j) for j in self._targets}
        pairs = [(i, j) for i in self._targets for j in self._targets if i != j]
        flown = costs.delta_v >= 0
        self._first = self._literals(j for j in self._targets if flown[rules.start, j])
        self._straight = self._literals(pair for pair in pairs if flown[pair])
        self._by_station = self._literals(
            (i, s, j) for i, j in pairs for s in self._stations if flown[i, s] and flown[s, j]
        )
        self._last = self._literals(
            (i, s)
            for i in self._targets
            for s in self._stations
            if flown[i, s] and rules.may_end[s]
        )
        self._one_route()
        self._delta_v_fits()
        self._time_fits()
        if rules.limits.targets < len(self._visit):
            self.block.add(sum(self._visit.values()) <= rules.limits.targets)
        self.block.maximize(sum(int(worth[j]) * visit for j, visit in self._visit.items()))

    def _literals(self, ways: Iterable[Way]) -> dict[Way, cp_model.IntVar]:
        """A Boolean decision variable for each way."""
        return {way: self.block.new_bool_var("") for way in ways}

    def _time(self, j: int) -> cp_model.IntVar:
        """End of a service in units; arbitrary if it is not made."""
        rules = self._rules
        opens, latest = rules.windows.opening[j], rules.windows.closing[j] + rules.service[j]
        earliest = float(max(rules.ready, opens) + rules.service[j])
        latest = math.ceil(max(latest, 0.0) * STEPS_PER_S)  # of a target without one: −inf
        return self.block.new_int_var(
            min(max(0, math.floor(earliest * STEPS_PER_S)), latest), latest, ""
        )

    def _one_route(self) -> None:
        """One route through the visited targets; node −1 precedes and follows it."""
        arcs: list[tuple[int, int, cp_model.LiteralT]] = [(0, 0, self.block.new_bool_var(""))]
        place = {j: number + 1 for number, j in enumerate(self._targets)}
        arcs += [(place[j], place[j], visit.negated()) for j, visit in self._visit.items()]
        arcs += [(0, place[j], move) for j, move in self._first.items()]
        for j in self._targets:
            ways = [move for (i, _), move in self._last.items() if i == j]
            end = self.block.new_bool_var("")
            if not self._rules.may_end[j]:
                self.block.add(sum(ways) == end)
            arcs.append((place[j], 0, end))
        for i, j in {(i, j) for i, j in self._straight} | {(i, j) for i, _, j in self._by_station}:
            ways = [
                self._by_station[i, s, j] for s in self._stations if (i, s, j) in self._by_station
            ]
            ways += [self._straight[i, j]] if (i, j) in self._straight else []
            move = self.block.new_bool_var("")
            self.block.add(sum(ways) == move)
            arcs.append((place[i], place[j], move))
        self.block.add_circuit(arcs)

    def _delta_v_fits(self) -> None:
        """ΔV accumulates since refuelling and never exceeds the budget."""
        cost, used, start = self._costs.delta_v, self._used, self._rules.start
        for j, move in self._first.items():
            self.block.add(used[j] >= cost[start, j]).only_enforce_if(move)
        for (i, j), move in self._straight.items():
            self.block.add(used[j] >= used[i] + cost[i, j]).only_enforce_if(move)
        for (i, s, j), move in self._by_station.items():
            self.block.add(used[j] >= cost[s, j]).only_enforce_if(move)
            self.block.add(used[i] + cost[i, s] <= self._budget).only_enforce_if(move)
        for (i, s), move in self._last.items():
            self.block.add(used[i] + cost[i, s] <= self._budget).only_enforce_if(move)
        # Implied: all the ΔV comes out of the first tank and one more per refuelling.
        ways = [(move, cost[start, j]) for j, move in self._first.items()]
        ways += [(move, cost[pair]) for pair, move in self._straight.items()]
        ways += [
            (move, cost[i, s] + cost[s, j] - self._budget)
            for (i, s, j), move in self._by_station.items()
        ]
        self.block.add(sum(move * int(need) for move, need in ways) <= self._budget)

    def _time_fits(self) -> None:
        """Services end one after another, and within the mission."""
        flown, end, rules = self._costs.duration, self._end, self._rules
        ready = math.floor(rules.ready * STEPS_PER_S)
        ways = [(i, j, move, flown[i, j]) for (i, j), move in self._straight.items()]
        ways += [
            (i, j, move, flown[i, s] + flown[s, j]) for (i, s, j), move in self._by_station.items()
        ]
        for j, move in self._first.items():
            self.block.add(end[j] >= ready + flown[rules.start, j]).only_enforce_if(move)
        for i, j, move, takes in ways:
            self.block.add(end[j] >= end[i] + takes).only_enforce_if(move)
        for (i, s), move in self._last.items():
            latest = math.ceil((rules.windows.closing[s] + rules.service[s]) * STEPS_PER_S)
            self.block.add(end[i] + flown[i, s] <= latest).only_enforce_if(move)
        # Implied: each visit takes its least time at least. Weak, but understood at once.
        left = self._duration - ready
        flights = np.where(flown >= 0, flown, self._duration).min(axis=0).tolist()
        self.block.add(sum(visit * flights[j] for j, visit in self._visit.items()) <= left)
        # Implied: the route is not longer than the mission.
        moves = [(move, flown[rules.start, j]) for j, move in self._first.items()]
        moves += [(move, takes) for _, _, move, takes in ways]
        self.block.add(sum(move * int(takes) for move, takes in moves) <= left)


@dataclass(frozen=True)
class RoutingBoundOptions(Options, method="routing-bound"):
    """Options of the bound ``routing-bound``."""

    effort: float = option(
        math.inf,
        "Limit of the search by CP-SAT in deterministic time, roughly seconds.",
        above=0.0,
        most=math.inf,
    )


def routing_bound(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None = None,
    options: RoutingBoundOptions = RoutingBoundOptions(),
) -> Result:
    """The classical static upper bound: weak, but without a timetable.

    Every leg is taken at its best over all connections, the least ΔV and the least time each by
    itself, without waiting for the node. On these costs the orienteering problem with refuelling
    is given to CP-SAT, and the bound is CP-SAT's upper bound on it. It is valid: every plan is a
    route whose legs take at least that much of both, so it fits, for the same prize. What it
    lacks against the other bounds is what knowing the time is worth. Deterministic but for the
    time limit, half of which is the most that working out the costs may take; one iteration, whose
    work ``effort`` limits. It looks for no plan.

    Parameters
    ----------
    mission, seed, stop, progress
    start : sequence of int, optional
        A plan: bodies in order. The bound may prove it optimal.
    """
    certificate = GapTracker(mission, progress)
    if start is not None:
        certificate.offer(start)
    counters: dict[str, float] = {"branches": 0}
    known = certificate.proven or stop(certificate.incumbent, certificate.bound)
    if mission.total_worth > 0.0 and not known:
        rules = mission.rules
        worth, unit = in_steps(rules.prize, mission.prize_step or mission.total_worth)
        half = 0.5 * stop.remaining_s()
        model = StaticModel(static_costs(mission, lambda: stop.remaining_s() < half), worth, rules)

        def hear(bound: float) -> bool:
            certificate.lower(bound)
            return certificate.proven or stop.remaining_s() <= 0.0

        solver, _, bound = run(
            model.block,
            unit,
            seed=seed,
            hear=hear,
            remaining_s=stop.remaining_s,
            effort=options.effort,
        )
        certificate.lower(bound)
        counters["branches"] = int(solver.num_branches)
    return certificate.result(
        "routing-bound", seed=seed, counters=counters, notes=bound_notes(mission)
    )
