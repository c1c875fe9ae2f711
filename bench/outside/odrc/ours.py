"""`odrc` as a campaign on given costs: planned, and its least ΔV proven on a grid of departures."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tables import head, row, timed

import adr_opt
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import of_matrices
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, TransferSettings

from ..reading import FloatArray
from .estimate import matrices
from .published import PLAN, TOTAL_M_S
from .reading import FILE, read_debris, with_centroid
from .scoring import LOAD, LONGEST_S, MOST_M_S, Route, score

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
    given = instance.with_given(of_matrices(departures, duration, delta_v, instance.names))
    result, spent, _ = timed(
        lambda: adr_opt.solve(given, "exact", time_limit=time_limit_s, cost=True)
    )
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


def report(folder: Path, time_limit_s: float, steps: int = 365, finer: int = 10) -> None:
    """Print the published plan scored again, and ours on two grids of departures in the year."""
    bodies = with_centroid(read_debris(folder / FILE))
    published = score(bodies, PLAN)
    wrong = [*published.violations]
    head("instance", "published [m/s]", "re-scored", "ours", "bound", "time")
    for grid in (steps, steps * finer):
        ours = plan(bodies, grid, 3, time_limit_s)
        scored = score(bodies, ours.routes)
        wrong += scored.violations
        row(
            f"{NAME}, {grid} departures",
            *(f"{each:.1f}" for each in (TOTAL_M_S, published.total_m_s, scored.total_m_s)),
            "–" if ours.least_m_s is None else f"{ours.least_m_s:.1f}",
            f"{ours.time_s:.1f} s",
        )
    print(*wrong, sep="\n")
