"""The instances as missions, with functions of time that are exact.

Along a way the distance driven is a function of time that rises from zone to zone. Who arrives
when it has risen by the length of the way: breakpoints are where one leaves, or arrives, as a zone
begins, and in between both speeds are constant.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

import adr_opt
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import only
from adr_opt.problem.given_functions import of_breakpoints
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, Objective, TransferSettings

from ..reading import FloatArray
from .reading import Roads


class Ours(NamedTuple):
    """The planned tour.

    Attributes
    ----------
    tour : tuple of int
        Customers; none without a plan.
    end, bound : float
        Infinite without a plan; no tour ends before the bound.
    labels : int
    time_s, processor_s : float
        Of planning and proving.
    """

    tour: tuple[int, ...]
    end: float
    bound: float
    labels: int
    time_s: float
    processor_s: float


def breakpoints(edges: FloatArray, speeds: FloatArray, length: float) -> FloatArray:
    """Departures and arrivals of a way, shape (breakpoints, 2).

    Parameters
    ----------
    edges : (zones + 1,) float64
    speeds : (zones,) float64
    length : float
    """
    driven = np.concatenate([[0.0], np.cumsum(speeds * np.diff(edges))])
    last = driven[-1] - length
    if last < 0.0:
        return np.empty((0, 2))
    at = np.concatenate([driven, driven - length, [0.0, last]])
    at = np.unique(at[(at >= 0.0) & (at <= last)])
    leaves, lands = np.interp(at, driven, edges), np.interp(at + length, driven, edges)
    return np.column_stack([leaves, np.maximum.accumulate(lands)])


def _name(roads: Roads, place: int) -> str:
    return {roads.start: "begin", roads.end: "end"}.get(place, f"place-{place:02d}")


def _functions(roads: Roads) -> Iterator[tuple[str, str, FloatArray, float]]:
    known: dict[tuple[int, float], FloatArray] = {}
    for i, j in np.argwhere(roads.cluster >= 0).tolist():
        key = int(roads.cluster[i, j]), float(roads.distance[i, j])
        if key not in known:
            known[key] = breakpoints(roads.edges, roads.speeds[key[0]], key[1])
        if known[key].size:
            yield _name(roads, i), _name(roads, j), known[key], 0.0


def instance_of(roads: Roads) -> Instance:
    """One chaser from depot to depot that has to visit all customers and to end first."""
    latest = min(roads.latest, float(roads.closes[roads.end]))
    made = Instance(
        name=f"tdtsptw-{roads.name}",
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        stations=(Station(name="begin"), Station(name="end")),
        targets=tuple(
            Target(
                name=_name(roads, place),
                prize=1.0,
                required=True,
                window_s=(float(roads.opens[place]), float(roads.closes[place])),
            )
            for place in roads.customers
        ),
        chasers=(
            Chaser(
                name="van",
                start=AtStation(station="begin"),
                end=AtStation(station="end"),
                available_s=(float(roads.opens[roads.start]), None),
                tank=Tank(delta_v_m_s=1.0),
            ),
        ),
        mission=MissionSettings(duration_s=latest, service_s=0.0, refuel_revolutions=0.0),
        objective=Objective(cost="duration"),
        transfer=TransferSettings(given=GivenFile(functions="roads.json")),
    )
    return made.with_given(only(of_breakpoints(_functions(roads), made.names)))


def plan(roads: Roads, time_limit_s: float, *, jobs: int = 0) -> Ours:
    """Plan and prove the least end, and check the plan."""
    clock = time.perf_counter(), time.process_time()
    instance = instance_of(roads)
    result = adr_opt.solve(instance, "auto", time_limit=time_limit_s, jobs=jobs)
    spent = time.perf_counter() - clock[0], time.process_time() - clock[1]
    labels = int(result.counters["labels"])
    if result.plan is None:
        return Ours((), np.inf, 0.0, labels, *spent)
    broken = adr_opt.check(instance, result.plan)
    if broken:
        raise RuntimeError(f"{roads.name}: the plan is not legal: {broken[0]}")
    tour = tuple(
        int(leg.destination.removeprefix("place-"))
        for leg in result.plan.legs
        if leg.destination != "end"
    )
    return Ours(tour, result.plan.cost, result.plan.cost_bound or 0.0, labels, *spent)
