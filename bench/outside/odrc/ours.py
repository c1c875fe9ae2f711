"""`odrc` as a campaign on given costs: planned, and its least ΔV proven on a grid of departures."""

from __future__ import annotations

import time
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

import adr_opt
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import of_matrices
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, TransferSettings

from ..reading import FloatArray
from .estimate import matrices
from .scoring import LOAD, LONGEST_S, MOST_M_S, Route

NAME = "odrc"


class Ours(NamedTuple):
    """The planned campaign.

    Attributes
    ----------
    total_m_s : float
    least_m_s : float or None
        No plan on the grid costs less; None if nobody knows.
    proven : bool
        Whether the plan is the cheapest one.
    routes : list of Route
    time_s : float
    """

    total_m_s: float
    least_m_s: float | None
    proven: bool
    routes: list[Route]
    time_s: float


def instance_of(debris: int, chasers: int) -> Instance:
    """Chasers that begin at the centroid, and have to get to all debris within the year.

    The centroid stands as a station, where nobody has a reason to come back: connections lead away
    from it only.
    """
    return Instance(
        name=NAME,
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        stations=(Station(name="centroid"),),
        targets=tuple(
            Target(name=f"debris-{number:02d}", required=True) for number in range(debris)
        ),
        chasers=tuple(
            Chaser(
                name=f"chaser-{number + 1}",
                start=AtStation(station="centroid"),
                tank=Tank(delta_v_m_s=MOST_M_S),
                max_targets=LOAD,
            )
            for number in range(chasers)
        ),
        mission=MissionSettings(duration_s=LONGEST_S, service_s=0.0, refuel_revolutions=0.0),
        transfer=TransferSettings(given=GivenFile(file="odrc.parquet")),
    )


def plan(bodies: FloatArray, steps: int, chasers: int, time_limit_s: float) -> Ours:
    """Plan on departures at equal parts of the year, the first at its beginning."""
    departures = np.linspace(0.0, LONGEST_S, steps, endpoint=False)
    duration, delta_v = matrices(bodies, departures)
    duration[:, :, 0] = delta_v[:, :, 0] = np.inf
    instance = instance_of(len(bodies) - 1, chasers)
    began = time.perf_counter()
    given = instance.with_given(of_matrices(departures, duration, delta_v, instance.names))
    result = adr_opt.solve(given, "exact", time_limit=time_limit_s, cost=True)
    spent = time.perf_counter() - began
    assert result.plan is not None
    assert adr_opt.check(given, result.plan) == ()
    number = {target.name: at for at, target in enumerate(instance.targets)}
    routes = [
        Route(
            tuple(number[leg.destination] for leg in route.legs),
            tuple(leg.departure_s for leg in route.legs),
        )
        for route in result.plan.routes
        if route.legs
    ]
    proven = result.plan.cost_status == "optimal"
    return Ours(result.plan.cost, result.plan.cost_bound, proven, routes, spent)
