"""PyVRP on a static relaxation.

It plans with one matrix: by default the mean ΔV and duration of each pair over all departures,
which it keeps best; the best of them is the static relaxation proper. Prizes are optional clients,
time is the shift's, refuelling is a reload at a station and takes its time. A tank that legs
empty cannot be expressed, only loads that clients carry: a target's load is the mean static ΔV of
the five cheapest legs to it. Chasers are vehicles, those that can do the same of one type, from
where they start to where they have to end, or anywhere. How many targets a chaser may service, and
windows of targets, it is not told.
"""

from __future__ import annotations

import math
import time
from importlib.metadata import version
from typing import Any

import numpy as np

from adr_opt.common.errors import InputError
from adr_opt.mission.problem import Problem
from adr_opt.problem.chasers import AtStation

from .promise import Promise, need, one_matrix

CHEAPEST = 5
"""Legs into a target whose mean static ΔV is its load in PyVRP."""
PRIZE_UNITS = 100_000
"""PyVRP's costs are whole numbers: a prize of 1 outweighs any saving of ΔV [m/s]."""


def pyvrp_promise(
    problem: Problem, *, time_limit_s: float, seed: int, statistic: str = "mean"
) -> Promise:
    """The best routes of PyVRP on the static relaxation.

    Raises
    ------
    MissingExtra
        PyVRP is not installed.
    InputError
        It is too old to know locations.
    """
    pyvrp: Any = need("pyvrp")
    if not hasattr(pyvrp.Model, "add_location"):
        raise InputError(f"PyVRP {version('pyvrp')} is too old: install PyVRP 0.14 or later")
    began = time.perf_counter()
    bodies, first = len(problem.names), problem.instance.first_target
    routes: list[tuple[int, ...]] = [()] * len(problem.missions)
    if bodies <= first:
        return Promise(tuple(routes), 0.0, math.inf, 0.0, 0.0)
    costs = one_matrix(problem, statistic)
    model = _model(pyvrp, problem, *costs)
    built = time.perf_counter()
    found = model.solve(pyvrp.stop.MaxRuntime(time_limit_s), seed=seed, display=False)
    solved = time.perf_counter()
    free = [list(kind.chasers) for kind in problem.kinds]
    for route in found.best.routes() if found.best.is_feasible() else ():
        # Depots are stations and starts, in the order of their bodies.
        routes[free[route.vehicle_type()].pop(0)] = tuple(
            first + activity.idx if activity.is_client() else activity.idx
            for activity in list(route)[1:-1]
        )
    visits = sum(float(problem.planning_prizes[j]) for route in routes for j in route)
    return Promise(tuple(routes), visits, math.inf, built - began, solved - built)


def _model(pyvrp: Any, problem: Problem, delta_v: np.ndarray, duration: np.ndarray) -> Any:
    """The static relaxation as a model of PyVRP."""
    bodies, first = len(problem.names), problem.instance.first_target
    kinds = problem.kinds
    budget = max(kind.mission.rules.budget for kind in kinds)
    model = pyvrp.Model()
    places = [model.add_location(0.0, 0.0) for _ in range(bodies + 1)]
    depots = [model.add_depot(places[body]) for body in range(first)]
    anywhere = model.add_depot(places[bodies])
    for j in range(first, bodies):
        incoming = np.sort(np.delete(delta_v[:, j], j))[:CHEAPEST]
        load = incoming[np.isfinite(incoming)]
        model.add_client(
            places[j],
            delivery=[math.ceil(load.mean()) if load.size else math.ceil(budget) + 1],
            prize=round(PRIZE_UNITS * float(problem.planning_prizes[j])),
            required=False,
        )
    for kind in kinds:
        rules, end = kind.mission.rules, kind.mission.chaser.end
        ends = depots[problem.names.index(end.station)] if isinstance(end, AtStation) else anywhere
        model.add_vehicle_type(
            len(kind.chasers),
            capacity=[math.floor(rules.budget)],
            start_depot=depots[rules.start],
            end_depot=ends,
            tw_early=math.ceil(rules.ready),
            tw_late=math.floor(rules.duration),
            reload_depots=depots[: rules.stations],
            max_reloads=bodies,
        )
    for i in range(bodies):
        model.add_edge(places[i], places[bodies], 0, 0)
        for j in range(bodies):
            # Arrival and service in one: PyVRP's reloads take no time of their own.
            if i != j and delta_v[i, j] <= budget:
                costs = round(delta_v[i, j]), round(duration[i, j])
                model.add_edge(places[i], places[j], *costs)
    return model
