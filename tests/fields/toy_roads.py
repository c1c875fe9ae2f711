"""A depot and three places whose connections are given: by rows, by matrices, by functions."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

import adr_opt
from adr_opt.plan.plan import Plan
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import COLUMNS, of_rows
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, Objective, TransferSettings

HOUR_S = 3600.0
NAMES = ("depot", "mill", "quay", "farm")


def roads(**changes: Any) -> Instance:
    """A depot and three places without orbits, whose connections are still to be given."""
    stated: dict[str, Any] = {
        "name": "roads",
        "epoch": "2026-05-04T06:00:00Z",
        "stations": [Station(name="depot")],
        "targets": [Target(name=name) for name in NAMES[1:]],
        "chasers": [
            Chaser(
                name="van",
                start=AtStation(station="depot"),
                end=AtStation(station="depot"),
                tank=Tank(delta_v_m_s=30.0),
            )
        ],
        "mission": MissionSettings(duration_s=6 * HOUR_S, service_s=600.0, refuel_revolutions=0.0),
        "transfer": TransferSettings(given=GivenFile(file="roads.parquet")),
    }
    return Instance(**(stated | changes))


DEPARTURES = np.arange(0.0, 6 * HOUR_S, HOUR_S / 2)


def matrices() -> tuple[np.ndarray, np.ndarray]:
    """Half an hour between neighbours, longer in between; dearer the later one leaves."""
    away = np.abs(np.arange(4)[:, None] - np.arange(4)[None, :]) * 1500.0
    away[3, 1] = np.inf  # no way back from the farm to the mill
    dear = 1.0 + np.arange(DEPARTURES.size)[:, None, None] / 10.0
    return np.broadcast_to(away, (DEPARTURES.size, 4, 4)), dear * np.minimum(away, 1e9) / 500.0


def as_rows() -> dict[str, list[Any]]:
    """The same, one by one."""
    duration, cost = matrices()
    rows = [
        (NAMES[i], NAMES[j], at, at + duration[d, i, j], cost[d, i, j])
        for d, at in enumerate(DEPARTURES)
        for i in range(4)
        for j in range(4)
        if i != j and np.isfinite(duration[d, i, j])
    ]
    return {name: [row[at] for row in rows] for at, name in enumerate(COLUMNS)}


def road(origin: int, destinations: np.ndarray, departure: float) -> tuple[np.ndarray, np.ndarray]:
    duration, cost = matrices()
    at = int(departure // (HOUR_S / 2))
    return duration[at, origin, destinations], cost[at, origin, destinations]


@numba.njit
def compiled_road(origin, destinations, departure):
    takes, cost = np.empty(destinations.size), np.empty(destinations.size)
    for place, j in enumerate(destinations):
        takes[place] = abs(origin - j) * 1500.0
        if origin == 3 and j == 1:
            takes[place] = np.inf
        cost[place] = (1.0 + departure / 1800.0 / 10.0) * (abs(origin - j) * 1500.0) / 500.0
    return takes, cost


def solved() -> tuple[Instance, Plan]:
    """The roads with their connections, and the best plan."""
    instance = adr_opt.Timetable.from_matrices(roads(), DEPARTURES, *matrices()).instance
    result = adr_opt.solve(instance, "exact", time_limit=30.0)
    assert result.status == "optimal"
    return instance, result.plan


def order_of_all(most: int | None = None) -> Instance:
    """Three places that are all required, to be done as early as possible, and most of a chaser."""
    names = ["depot", "a", "b", "c"]
    pairs = [(i, j) for i in names for j in names[1:] if i != j]
    rows = {
        "origin": [i for i, _ in pairs],
        "destination": [j for _, j in pairs],
        "departure_s": np.zeros(len(pairs)),
        "arrival_s": np.ones(len(pairs)),
        "delta_v_m_s": np.zeros(len(pairs)),
    }
    start = AtStation(station="depot")
    return roads(
        name="order",
        targets=[Target(name=name, required=True) for name in names[1:]],
        chasers=[Chaser(name="van", start=start, tank=Tank(delta_v_m_s=1.0), max_targets=most)],
        mission=MissionSettings(duration_s=100.0, service_s=0.0, refuel_revolutions=0.0),
        objective=Objective(cost="duration"),
    ).with_given(of_rows(rows, names))
