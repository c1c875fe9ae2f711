"""OR-Tools' routing library on static costs.

It plans with one matrix, as PyVRP does. ΔV is a dimension that legs draw from and that copies of
the stations fill up again, so tanks are as they are, at the static costs; refuelling is earned, as
no station follows another one or the start. Prizes are penalties for targets that are left out;
windows, the largest number of targets and the end of a chaser are its own. Guided local search
improves what parallel insertion begins with, until the time is over; the library takes no seed.
"""

from __future__ import annotations

import math
import time
from typing import Any, NamedTuple

import numpy as np

from adr_opt.campaign import Problem
from adr_opt.chasers import AtStation

from .promise import Promise, need
from .static import one_matrix

PRIZE_UNITS = 100_000
"""Costs are whole numbers: a prize of 1 outweighs any saving of ΔV [m/s]."""

REFUELLINGS = 4
"""Copies of each station for each chaser: so often each may refuel there, in the mean."""

NOWHERE = -1
"""The body of a node where a chaser may end that may end anywhere."""


class Nodes(NamedTuple):
    """The nodes of the model: what is visited once at most, and where chasers start and end.

    Attributes
    ----------
    body : (nodes,) int64
        Targets, copies of stations, starts, ends.
    refuels : (nodes,) bool
        Copies of stations.
    starts, ends : list of int
        Nodes of each chaser.
    """

    body: np.ndarray
    refuels: np.ndarray
    starts: list[int]
    ends: list[int]


def _nodes(problem: Problem) -> Nodes:
    """The nodes of a problem."""
    missions, stations = problem.missions, len(problem.instance.stations)
    targets = list(range(problem.instance.first_target, len(problem.names)))
    copies = [s for s in range(stations) for _ in range(REFUELLINGS * len(missions))]
    begins = [int(mission.rules.start) for mission in missions]
    ends = [
        problem.names.index(end.station) if isinstance(end, AtStation) else NOWHERE
        for end in (mission.chaser.end for mission in missions)
    ]
    body = np.array([*targets, *copies, *begins, *ends], dtype=np.int64)
    refuels = np.zeros(body.size, dtype=np.bool_)
    refuels[len(targets) : len(targets) + len(copies)] = True
    start = len(targets) + len(copies)
    return Nodes(
        body,
        refuels,
        list(range(start, start + len(begins))),
        list(range(start + len(begins), body.size)),
    )


def _between(nodes: Nodes, costs: np.ndarray, never: int) -> np.ndarray:
    """A matrix of bodies as one of nodes, in whole numbers; to nowhere for nothing."""
    whole = np.where(np.isfinite(costs), np.ceil(np.minimum(costs, never)), never)
    among = whole.astype(np.int64)[nodes.body[:, None], nodes.body[None, :]]
    among[:, nodes.body == NOWHERE] = 0
    return among


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
    first = problem.instance.first_target
    if len(problem.names) <= first:
        return Promise(((),) * len(problem.missions), 0.0, math.inf, 0.0, 0.0)
    nodes = _nodes(problem)
    manager = pywrapcp.RoutingIndexManager(
        nodes.body.size, len(problem.missions), nodes.starts, nodes.ends
    )
    routing = pywrapcp.RoutingModel(manager)
    delta_v, duration = one_matrix(problem, statistic)
    _add_tanks(routing, manager, problem, nodes, delta_v)
    _add_times(routing, manager, problem, nodes, duration)
    for node in range(nodes.starts[0]):
        worth = float(problem.worths[nodes.body[node]])  # 0 for stations
        routing.AddDisjunction([manager.NodeToIndex(node)], round(PRIZE_UNITS * worth))
    _earn_refuelling(routing, manager, nodes)

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
        route, index = [], routing.Start(vehicle)
        while found is not None and not routing.IsEnd(index):
            index = found.Value(routing.NextVar(index))
            body = int(nodes.body[manager.IndexToNode(index)])
            if body != NOWHERE:
                route.append(body)
        routes.append(tuple(route))
    visits = sum(float(problem.worths[j]) for route in routes for j in route)
    return Promise(tuple(routes), visits, math.inf, built - began, solved - built)


def _add_tanks(
    routing: Any, manager: Any, problem: Problem, nodes: Nodes, delta_v: np.ndarray
) -> None:
    """What is drawn from the present tank, as a dimension; legs cost their ΔV."""
    budgets = [math.floor(mission.rules.budget) for mission in problem.missions]
    full = max(budgets)
    legs = _between(nodes, delta_v, full + 1)
    arcs = routing.RegisterTransitMatrix(legs.tolist())
    routing.SetArcCostEvaluatorOfAllVehicles(arcs)
    # A station takes off what was drawn: a full tank, less what was left of it, the slack.
    drawn = routing.RegisterTransitMatrix((legs - full * nodes.refuels[:, None]).tolist())
    routing.AddDimensionWithVehicleCapacity(drawn, full, budgets, True, "tank")
    tank, solver = routing.GetDimensionOrDie("tank"), routing.solver()
    for node in range(nodes.ends[0]):
        index = manager.NodeToIndex(node)
        if nodes.refuels[node]:
            solver.Add(tank.CumulVar(index) + tank.SlackVar(index) == full)
        else:
            tank.SlackVar(index).SetValue(0)


def _add_times(
    routing: Any, manager: Any, problem: Problem, nodes: Nodes, duration: np.ndarray
) -> None:
    """When service ends, as a dimension, and how many targets a chaser services."""
    rules = [mission.rules for mission in problem.missions]
    last = math.floor(max(each.duration for each in rules))
    legs = _between(nodes, duration, last + 1)
    times = routing.RegisterTransitMatrix(legs.tolist())
    ends = [math.floor(each.duration) for each in rules]
    waits = math.ceil(max(float(each.opens.max()) - each.ready for each in rules))
    routing.AddDimensionWithVehicleCapacity(times, waits, ends, False, "time")
    time_of = routing.GetDimensionOrDie("time")
    for vehicle, each in enumerate(rules):
        ready = math.ceil(each.ready)
        time_of.CumulVar(routing.Start(vehicle)).SetRange(ready, ready)
    # Opening and closing of all chasers together: each one's own is its ready time and its end.
    opens = np.min([each.opens for each in rules], axis=0) + rules[0].service
    closes = np.max([each.closes for each in rules], axis=0)
    first = problem.instance.first_target
    for node in range(nodes.starts[0]):
        body = nodes.body[node]
        if body >= first and (latest := math.floor(closes[body])) >= 0:
            earliest = min(math.ceil(opens[body]), latest)
            time_of.CumulVar(manager.NodeToIndex(node)).SetRange(earliest, latest)
    most = [int(each.most_targets) for each in rules]
    if min(most) < len(problem.names) - first:
        counted = ((nodes.body >= first) & ~nodes.refuels).astype(np.int64)
        counts = routing.RegisterUnaryTransitVector(counted.tolist())
        routing.AddDimensionWithVehicleCapacity(counts, 0, most, True, "targets")


def _earn_refuelling(routing: Any, manager: Any, nodes: Nodes) -> None:
    """Keep stations from following one another, or a start."""
    stations = [manager.NodeToIndex(int(node)) for node in np.flatnonzero(nodes.refuels)]
    for index in [*stations, *(routing.Start(each) for each in range(len(nodes.starts)))]:
        for station in stations:
            if station != index:
                routing.NextVar(index).RemoveValue(station)
