"""OR-Tools' routing library on static costs.

It plans with one matrix, as PyVRP does, in whole numbers that are rounded up. A target is a node,
and one more for each station: going to that one means to refuel there on the way, so that one step
of a local search decides to. At most one of the nodes of a target is visited, and its prize is the
penalty for none. What is drawn from the tank is a dimension: legs add to it, and whoever has
refuelled has drawn the last leg alone. Nobody refuels before the first target. Windows, the largest
number of targets, the times and the end of each chaser are its own. Guided local search improves
what parallel insertion begins with, until the time is over; the library takes no seed.
"""

from __future__ import annotations

import math
import time
from typing import Any, NamedTuple

import numpy as np

from adr_opt.mission.problem import Problem
from adr_opt.problem.chasers import AtStation

from .promise import Promise, need, one_matrix

PRIZE_UNITS = 100_000
"""Costs are whole numbers: a prize of 1 outweighs any saving of ΔV [m/s]."""

NONE = -1
"""No station on the way; or the end body of a chaser that may end anywhere."""


class Nodes(NamedTuple):
    """The nodes of the model: targets, directly and by stations, then starts, then ends.

    Attributes
    ----------
    body : (nodes,) int64
    by : (nodes,) int64
        The station on the way.
    starts, ends : list of int
        Nodes of each chaser.
    """

    body: np.ndarray
    by: np.ndarray
    starts: list[int]
    ends: list[int]


def _nodes(problem: Problem, delta_v: np.ndarray) -> Nodes:
    """The nodes of a problem; none by a station from which a target is out of reach."""
    missions = problem.missions
    full = math.floor(max(mission.rules.budget for mission in missions))
    targets = range(problem.instance.first_target, len(problem.names))
    stations = range(len(problem.instance.stations))
    ways = [(j, NONE) for j in targets]
    ways += [(j, s) for j in targets for s in stations if delta_v[s, j] <= full]
    starts = [(int(mission.rules.start), NONE) for mission in missions]
    ends = [
        (problem.names.index(end.station) if isinstance(end, AtStation) else NONE, NONE)
        for end in (mission.chaser.end for mission in missions)
    ]
    body, by = np.array([*ways, *starts, *ends], dtype=np.int64).T
    first = len(ways)
    return Nodes(
        body,
        by,
        list(range(first, first + len(starts))),
        list(range(first + len(starts), body.size)),
    )


def _between(nodes: Nodes, costs: np.ndarray, never: int) -> np.ndarray:
    """Cost of going to a node from each node, via its station if it has one."""
    whole = np.ceil(np.minimum(costs, never)).astype(np.int64)
    origins, bodies, by = nodes.body[:, None], nodes.body[None, :], nodes.by[None, :]
    taken = np.where(by == NONE, whole[origins, bodies], whole[origins, by] + whole[by, bodies])
    taken[:, nodes.body == NONE] = 0
    return taken


def ortools_promise(
    problem: Problem, *, time_limit_s: float, seed: int = 0, statistic: str = "mean"
) -> Promise:
    """The best routes of OR-Tools on static costs.

    Raises
    ------
    MissingExtra
        OR-Tools is not installed.
    """
    need("ortools")
    from ortools.constraint_solver import pywrapcp, routing_enums_pb2

    began = time.perf_counter()
    if len(problem.names) <= problem.instance.first_target:
        return Promise(((),) * len(problem.missions), 0.0, math.inf, 0.0, 0.0)
    delta_v, duration = one_matrix(problem, statistic)
    nodes = _nodes(problem, delta_v)
    manager = pywrapcp.RoutingIndexManager(
        nodes.body.size, len(problem.missions), nodes.starts, nodes.ends
    )
    routing = pywrapcp.RoutingModel(manager)
    _add_tanks(routing, manager, problem, nodes, delta_v)
    _add_times(routing, manager, problem, nodes, duration)
    _add_targets(routing, manager, problem, nodes)
    settings = pywrapcp.DefaultRoutingSearchParameters()
    settings.first_solution_strategy = (
        routing_enums_pb2.FirstSolutionStrategy.PARALLEL_CHEAPEST_INSERTION
    )
    settings.local_search_metaheuristic = (
        routing_enums_pb2.LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
    )
    settings.time_limit.FromMilliseconds(max(1, round(1000.0 * time_limit_s)))
    built = time.perf_counter()
    found = routing.SolveWithParameters(settings)
    solved = time.perf_counter()
    routes: list[tuple[int, ...]] = []
    for vehicle in range(len(problem.missions)):
        route: list[int] = []
        index = routing.Start(vehicle)
        while found is not None and not routing.IsEnd(index):
            index = found.Value(routing.NextVar(index))
            node = nodes.ends[vehicle] if routing.IsEnd(index) else manager.IndexToNode(index)
            route += [int(j) for j in (nodes.by[node], nodes.body[node]) if j != NONE]
        routes.append(tuple(route))
    visits = sum(float(problem.planning_prizes[j]) for route in routes for j in route)
    return Promise(tuple(routes), visits, math.inf, built - began, solved - built)


def _add_tanks(
    routing: Any, manager: Any, problem: Problem, nodes: Nodes, delta_v: np.ndarray
) -> None:
    """Cost of legs, with the ΔV drawn from the current tank as a dimension."""
    budgets = [math.floor(mission.rules.budget) for mission in problem.missions]
    never = max(budgets) + 1
    legs = _between(nodes, delta_v, never)
    refuels = nodes.by != NONE
    evaluators = {}
    for full in set(budgets):
        # drawn + slack + leg to the station = full, so that it has to be reached; waste is legal.
        drawn = legs - full * refuels[None, :]
        evaluators[full] = routing.RegisterTransitMatrix(drawn.tolist())
    routing.SetArcCostEvaluatorOfAllVehicles(routing.RegisterTransitMatrix(legs.tolist()))
    routing.AddDimensionWithVehicleTransitAndCapacity(
        [evaluators[full] for full in budgets], max(budgets), budgets, True, "tank"
    )
    tank = routing.GetDimensionOrDie("tank")
    for node in np.flatnonzero(refuels).tolist():
        last = math.ceil(delta_v[nodes.by[node], nodes.body[node]])
        tank.CumulVar(manager.NodeToIndex(node)).SetValue(last)


def _add_times(
    routing: Any, manager: Any, problem: Problem, nodes: Nodes, duration: np.ndarray
) -> None:
    """End of service, as a dimension."""
    rules = [mission.rules for mission in problem.missions]
    ends = [math.floor(each.duration) for each in rules]
    times = routing.RegisterTransitMatrix(_between(nodes, duration, max(ends) + 1).tolist())
    waits = math.ceil(max(float(each.windows.opening.max()) - each.ready for each in rules))
    routing.AddDimensionWithVehicleCapacity(times, waits, ends, False, "time")
    time_of = routing.GetDimensionOrDie("time")
    for vehicle, each in enumerate(rules):
        time_of.CumulVar(routing.Start(vehicle)).SetValue(math.ceil(each.ready))
    # Of all chasers together: each one's own times are those of its start and end.
    opens = np.min([each.windows.opening for each in rules], axis=0) + rules[0].service
    closes = np.max([each.windows.closing + each.service for each in rules], axis=0)
    for node in range(nodes.starts[0]):
        body = nodes.body[node]
        latest = math.floor(closes[body])
        earliest = min(math.ceil(opens[body]), latest)
        time_of.CumulVar(manager.NodeToIndex(node)).SetRange(earliest, latest)


def _add_targets(routing: Any, manager: Any, problem: Problem, nodes: Nodes) -> None:
    """Each target at most once; a maximum number per chaser; the first without refuelling."""
    ways = nodes.starts[0]
    for j in np.unique(nodes.body[:ways]).tolist():
        its = [
            manager.NodeToIndex(node) for node in np.flatnonzero(nodes.body[:ways] == j).tolist()
        ]
        routing.AddDisjunction(its, round(PRIZE_UNITS * float(problem.planning_prizes[j])), 1)
    most = [int(mission.rules.limits.targets) for mission in problem.missions]
    counted = (np.arange(nodes.body.size) < ways).astype(np.int64)
    counts = routing.RegisterUnaryTransitVector(counted.tolist())
    routing.AddDimensionWithVehicleCapacity(counts, 0, most, True, "targets")
    for vehicle in range(len(most)):
        for node in np.flatnonzero(nodes.by != NONE).tolist():
            routing.NextVar(routing.Start(vehicle)).RemoveValue(manager.NodeToIndex(node))
