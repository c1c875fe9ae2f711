"""Drawn orienteering with time windows, as missions on given connections and as models of PyVRP.

A tour begins and ends at one place, all times and distances are whole numbers, and places have
prizes, services and windows in which service begins. Four kinds: places scattered or in clusters,
windows narrow or wide.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.clock import now_s
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import of_rows
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, TransferSettings

from .promise import need

IntArray = npt.NDArray[np.int64]

KINDS = ("scattered-narrow", "scattered-wide", "clustered-narrow", "clustered-wide")


class Places(NamedTuple):
    """A drawn instance; place 0 is where the tour begins and ends.

    Attributes
    ----------
    name : str
    prize, service, opens, closes : (places,) int64
        Service begins between ``opens`` and ``closes``; of place 0 the latter is the latest end.
    travel : (places, places) int64
        Duration of each way.
    """

    name: str
    prize: IntArray
    service: IntArray
    opens: IntArray
    closes: IntArray
    travel: IntArray


def draw(kind: str, seed: int, places: int = 100) -> Places:
    """An instance of a kind.

    Parameters
    ----------
    kind : str
        One of :data:`KINDS`.
    seed : int
    places : int
        Number of places with prizes.
    """
    rng = np.random.default_rng([KINDS.index(kind), seed, places])
    spread, width = kind.split("-")
    if spread == "scattered":
        points = rng.uniform(0.0, 100.0, (places, 2))
    else:
        centres = rng.uniform(10.0, 90.0, (10, 2))
        points = centres[rng.integers(0, 10, places)] + rng.normal(0.0, 4.0, (places, 2))
    points = np.vstack(([50.0, 50.0], points))
    apart = np.hypot(*(points[:, None] - points[None]).T)
    travel = np.maximum(1, np.ceil(apart)).astype(np.int64)
    # Shortest ways, so that no way is shorter by way of another place.
    for middle in range(places + 1):
        travel = np.minimum(travel, travel[:, middle, None] + travel[None, middle])
    horizon, narrowest, widest = (240, 10, 60) if width == "narrow" else (480, 100, 400)
    service = np.append(0, np.full(places, 10))
    wide = rng.integers(narrowest, widest + 1, places + 1)
    first = travel[0]
    last = horizon - service - travel[:, 0]
    middle = rng.integers(first, np.maximum(first, last) + 1)
    opens, closes = np.maximum(first, middle - wide // 2), np.minimum(last, middle + wide // 2)
    opens[0], closes[0] = 0, horizon
    prize = np.append(0, rng.integers(1, 51, places))
    return Places(f"{kind}-{seed}", prize, service, opens, closes, travel)


def instance_of(places: Places, chasers: int = 1) -> Instance:
    """The mission; a connection holds the service at its origin and leaves as that begins."""
    count = places.prize.size
    names = ["begin", "end", *(f"place-{place:03d}" for place in range(1, count))]
    rows: list[tuple[IntArray, ...]] = []
    for i in range(count):
        leaves = np.arange(places.opens[i], places.closes[i] + 1) if i else np.zeros(1, np.int64)
        for j in range(count):
            if i == j:
                continue
            begins = np.maximum(leaves + places.service[i] + places.travel[i, j], places.opens[j])
            kept = begins <= places.closes[j]
            # Of those that wait for the opening, the last one stands for all.
            kept[np.flatnonzero(begins <= places.opens[j])[:-1]] = False
            ends = np.full((2, int(kept.sum())), [[i + 1 if i else 0], [j + 1 if j else 1]])
            rows.append((*ends, leaves[kept], begins[kept]))
    origin, destination, departs, lands = (
        np.concatenate(column) for column in zip(*rows, strict=True)
    )
    instance = Instance(
        name=places.name,
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        stations=(Station(name="begin"), Station(name="end")),
        targets=tuple(
            Target(
                name=names[place + 1],
                prize=float(places.prize[place]),
                window_s=(float(places.opens[place]), float(places.closes[place])),
            )
            for place in range(1, count)
        ),
        chasers=tuple(
            Chaser(
                name=f"tourist-{number}",
                start=AtStation(station="begin"),
                end=AtStation(station="end"),
                tank=Tank(delta_v_m_s=1.0),
            )
            for number in range(chasers)
        ),
        mission=MissionSettings(
            duration_s=float(places.closes[0]), service_s=0.0, refuel_revolutions=0.0
        ),
        transfer=TransferSettings(given=GivenFile(file="windows.parquet")),
    )
    columns = {
        "origin": origin,
        "destination": destination,
        "departure_s": departs.astype(float),
        "arrival_s": lands.astype(float),
        "delta_v_m_s": np.zeros(departs.size),
    }
    return instance.with_given(of_rows(columns, names))


def collected(places: Places, tour: Sequence[int]) -> int:
    """Prizes of a tour, each place as early as possible.

    Raises
    ------
    ValueError
        A place is there twice, or is reached too late.
    """
    if len(set(tour)) < len(tour):
        raise ValueError("a place is there twice")
    now = here = 0
    for one in (*tour, 0):
        now += int(places.service[here] + places.travel[here, one])
        now, here = max(now, int(places.opens[one])), one
        if now > places.closes[one]:
            raise ValueError(f"place {one} is reached too late")
    return int(places.prize[list(tour)].sum()) if tour else 0


def by_pyvrp(places: Places, time_limit_s: float, seed: int = 0, chasers: int = 1) -> int:
    """Prizes that PyVRP collects: optional clients, a prize above any distance.

    Raises
    ------
    MissingExtra
        PyVRP is not installed.
    """
    pyvrp: Any = need("pyvrp")
    model = pyvrp.Model()
    spots = [model.add_location(0.0, 0.0) for _ in range(places.prize.size)]
    model.add_depot(spots[0])
    for place in range(1, places.prize.size):
        model.add_client(
            spots[place],
            service_duration=int(places.service[place]),
            tw_early=int(places.opens[place]),
            tw_late=int(places.closes[place]),
            prize=1000 * int(places.prize[place]),
            required=False,
        )
    model.add_vehicle_type(num_available=chasers, tw_early=0, tw_late=int(places.closes[0]))
    for i, here in enumerate(spots):
        for j, there in enumerate(spots):
            if i != j:
                way = int(places.travel[i, j])
                model.add_edge(here, there, distance=way, duration=way)
    began = now_s()
    found = model.solve(lambda _: now_s() - began >= time_limit_s, seed=seed, display=False).best
    if not found.is_feasible():
        return 0
    tours = [
        [1 + activity.idx for activity in list(route)[1:-1] if activity.is_client()]
        for route in found.routes()
    ]
    return sum(collected(places, tour) for tour in tours)
