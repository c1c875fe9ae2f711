"""PyVRP on a static relaxation.

It plans with one matrix: the mean ΔV and duration of each pair over all departures, which it keeps
best, and the best of them, which is the static relaxation proper. Prizes are optional clients,
time is the shift's, refuelling is a reload at the station and takes its time. A tank that legs
empty cannot be expressed, only loads that clients carry: a target's load is the mean static ΔV of
the five cheapest legs to it. The route ends anywhere.
"""

from __future__ import annotations

import math
import time
from importlib.metadata import version
from typing import Any

import numpy as np

import adr_opt
from adr_opt.errors import InputError
from adr_opt.kernels.constants import STATION

from .promise import Promise, need

CHEAPEST = 5
"""Legs into a target whose mean static ΔV is its load in PyVRP."""
PRIZE_UNITS = 100_000
"""PyVRP's costs are whole numbers: a prize of 1 outweighs any saving of ΔV [m/s]."""


def static_costs(mission: adr_opt.Mission, statistic: str) -> tuple[np.ndarray, np.ndarray]:
    """One matrix for all times, from samples every half hour.

    Parameters
    ----------
    mission : Mission
    statistic : {"mean", "quartile", "best", "epoch"}
        Over the ready times from which a leg exists and ends within the mission: the mean, the
        lower quartile or the least of each quantity by itself, or the first time's.

    Returns
    -------
    delta_v, duration : (bodies, bodies) float64
        [m/s]; from ready to the end of service [s]; +inf where there is never a transfer.
    """
    rules = mission.rules
    times = np.arange(0.0, max(rules.duration, 1.0), 1800.0)
    sampled = mission.timetable.matrices(times)
    duration = sampled.duration + rules.service
    exists = (times[:, None, None] + duration <= rules.duration) & np.isfinite(sampled.delta_v)
    count = exists.sum(axis=0)
    found = []
    for values in (sampled.delta_v, duration):
        if statistic == "mean":
            total = np.where(exists, values, 0.0).sum(axis=0)
            single = np.where(count > 0, total / np.maximum(count, 1), np.inf)
        elif statistic in ("quartile", "best"):
            ordered = np.sort(np.where(exists, values, np.inf), axis=0)
            rank = count // 4 if statistic == "quartile" else np.zeros_like(count)
            single = np.take_along_axis(ordered, rank[None], axis=0)[0]
        else:
            first = np.take_along_axis(values, exists.argmax(axis=0)[None], axis=0)[0]
            single = np.where(count > 0, first, np.inf)
        np.fill_diagonal(single, 0.0)
        found.append(single)
    return found[0], found[1]


def pyvrp_promise(
    mission: adr_opt.Mission, *, time_limit_s: float, seed: int, statistic: str = "mean"
) -> Promise:
    """The best route of PyVRP on the static relaxation.

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
    rules = mission.rules
    bodies = rules.service.size
    if bodies < 2:
        return Promise((), 0.0, math.inf, 0.0, 0.0)
    delta_v, duration = static_costs(mission, statistic)
    model = pyvrp.Model()
    places = [model.add_location(0.0, 0.0) for _ in range(bodies + 1)]
    station = model.add_depot(places[STATION])
    anywhere = model.add_depot(places[bodies])
    for j in range(1, bodies):
        incoming = np.sort(np.delete(delta_v[:, j], j))[:CHEAPEST]
        load = incoming[np.isfinite(incoming)]
        model.add_client(
            places[j],
            delivery=[math.ceil(load.mean()) if load.size else math.ceil(rules.budget) + 1],
            prize=round(PRIZE_UNITS * float(rules.prize[j])),
            required=False,
        )
    model.add_vehicle_type(
        1,
        capacity=[math.floor(rules.budget)],
        start_depot=station,
        end_depot=anywhere,
        shift_duration=math.floor(rules.duration),
        reload_depots=[station],
        max_reloads=bodies,
    )
    for i in range(bodies):
        model.add_edge(places[i], places[bodies], 0, 0)
        for j in range(bodies):
            # Arrival and service in one: PyVRP's reloads take no time of their own.
            if i != j and delta_v[i, j] <= rules.budget:
                costs = round(delta_v[i, j]), round(duration[i, j])
                model.add_edge(places[i], places[j], *costs)
    built = time.perf_counter()
    found = model.solve(pyvrp.stop.MaxRuntime(time_limit_s), seed=seed, display=False)
    solved = time.perf_counter()
    order: list[int] = []
    if found.best.is_feasible():
        for route in found.best.routes():
            for activity in list(route)[1:-1]:
                order.append(1 + activity.idx if activity.is_client() else STATION)
    visits = float(sum(rules.prize[j] for j in order))
    return Promise(tuple(order), visits, math.inf, built - began, solved - built)
