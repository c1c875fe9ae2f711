"""The frontier of ΔV against the last day, at equal prize.

At each duration of a trade-off whose plans collect the most, the least cost is asked for; and every
order of bodies that is known by then is timed anew over all connections of the longest mission. So
the frontier is exact for these orders, and no better than they are.
"""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...common.files import write_text
from ...common.stop import Stop
from ...mission.problem import Problem, problem_of
from ...problem.instance import Instance
from ...problem.rules import CAMPAIGNS, FIRST, MODELLED, TOURS, Follower
from ...problem.support import refuse
from ...run.front import solve
from .axes import Axis, PointLimits, tanks_of
from .points import Point, Routes, Tradeoff
from .shared import Shared, variant

CHEAPEST = "exact"
"""Planner that minimises cost."""

COLUMNS = ("tank_m_s", "prize", "last_day", "delta_v_m_s", "cost", "routes")

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Ending:
    """A plan on the frontier.

    Attributes
    ----------
    tank_m_s : float
        ΔV of a full tank, as of the points of the trade-off [m/s].
    prize : float
        The most that the points with such a tank collect.
    last_s : float
        When the last service or tow of all is over [s].
    delta_v_m_s : float
        Of all legs and tows: no known order takes less that is over by then [m/s].
    cost : float
        The same with the price of time [m/s].
    routes : tuple of tuple of str
        Bodies in order, for each chaser.
    """

    tank_m_s: float
    prize: float
    last_s: float
    delta_v_m_s: float
    cost: float
    routes: Routes

    def to_dict(self) -> dict[str, Any]:
        """The plan as JSON data."""
        return {**asdict(self), "routes": [list(route) for route in self.routes]}


FOLLOWS = Follower(
    "a frontier",
    (FIRST | CAMPAIGNS | MODELLED | TOURS | {"functions of time", "capture windows"})
    - {"cost", "expense", "prizes that fall", "limited propellant"},
    "leave it or the frontier out",
)
"""Rules followed by frontiers of ΔV against the last day: finishing sooner must neither reduce the
prize nor use more of a shared supply."""


def check_frontier(instance: Instance, axes: Sequence[Axis] = ()) -> None:
    """Refuse instances for which no frontier of ΔV against the last day is defined.

    Raises
    ------
    InputError
        Another cost than ΔV counts, or less ΔV may not be enough of a reason to fly otherwise, or
        chasers differ along an axis by more than their tanks.
    """
    for axis in axes:
        if axis.kind in ("thrust", "isp"):
            raise InputError(
                f"vary {axis.kind}: a frontier is one of chasers with the same drive; leave the "
                "frontier out"
            )
    refuse(instance, FOLLOWS)


def frontier(
    made: Tradeoff,
    *,
    time_limit: float,
    seed: int = 0,
    stop: Stop | None = None,
    told: Callable[[str], None] = lambda text: None,
) -> tuple[Ending, ...]:
    """ΔV needed to finish earlier, from the plans of a trade-off with the largest prize.

    Parameters
    ----------
    made : Tradeoff
    time_limit : float
        Wall time for the least cost at each duration [s].
    seed : int
    stop : Stop, optional
        Ends the search for cheaper plans; what is known is timed all the same.
    told : callable
        Called with a sentence on each search.

    Returns
    -------
    tuple of Ending
        For each tank in order of the last day, each with less ΔV than the one before by at least
        the resolution of the instance, except for the plan of least cost and the last one, that of
        least ΔV.

    Raises
    ------
    InputError
        See :func:`check_frontier`.
    """
    check_frontier(made.instance, made.axes)
    tanks = tanks_of(made.instance, made.axes)
    found: list[Ending] = []
    for row in made.along("duration").values():
        tank_m_s = row[0].delta_v_m_s
        prize = max(point.prize for point in row)
        best = [point for point in row if point.prize == prize and any(point.routes)]
        if not best:
            continue
        longest_s = max(point.duration_s for point in row)
        shared = Shared(made.instance, longest_s, tanks=tanks)
        orders = dict.fromkeys(point.routes for point in best)
        for point in best:
            if stop is not None and stop.remaining_s() <= 0.0:
                break
            routes = _cheapest(shared.problem(point.limits), point, time_limit, seed, stop)
            if routes is not None:
                orders[routes] = None
                told(f"{point.duration_s / DAY_S:g} d: asked for the least cost")
        problem = problem_of(variant(made.instance, PointLimits(tank_m_s, longest_s), tanks=tanks))
        ends = sorted(
            (ending for order in orders for ending in _endings(problem, tank_m_s, prize, order)),
            key=lambda ending: (ending.last_s, ending.delta_v_m_s),
        )
        found.extend(_kept(ends, made.instance.transfer.delta_v_resolution_m_s))
    return tuple(found)


def _cheapest(
    problem: Problem, point: Point, time_limit: float, seed: int, stop: Stop | None
) -> Routes | None:
    """The cheapest plan found with at least the prize of a point; None if there is none."""
    start = point.routes if len(problem.missions) > 1 else point.routes[0]
    result = solve(
        problem,
        CHEAPEST,
        time_limit=time_limit,
        seed=seed,
        stop=stop,
        start=start,
        repair=True,
        cost=True,
    )
    if result.plan is None or result.objective < point.prize:
        return None
    return tuple(tuple(problem.names[j] for j in route) for route in result.routes)


def _endings(problem: Problem, tank_m_s: float, prize: float, routes: Routes) -> Iterator[Ending]:
    """All useful last days of routes, each with the least ΔV of every chaser until then."""
    timed: list[tuple[FloatArray, FloatArray, float]] = []
    for mission, route in zip(problem.missions, routes, strict=True):
        if route:
            order = tuple(mission.numbers(route).tolist())
            timed.append((*mission.schedules.endings(order), float(mission.rules.ready)))
    if not timed or any(not ends.size for ends, _, _ in timed):
        return
    first_s = max(float(ends[0]) for ends, _, _ in timed)
    days = np.unique(np.concatenate([ends for ends, _, _ in timed]))
    price, taken = problem.instance.time_m_s_per_s, []
    for ends, _, _ in timed:
        taken.append(np.searchsorted(ends, days[days >= first_s], side="right") - 1)
    for place, last_s in enumerate(days[days >= first_s].tolist()):
        which = [int(each[place]) for each in taken]
        spent = math.fsum(float(least[at]) for (_, least, _), at in zip(timed, which, strict=True))
        flown_s = math.fsum(
            float(ends[at]) - since for (ends, _, since), at in zip(timed, which, strict=True)
        )
        yield Ending(tank_m_s, prize, last_s, spent, spent + price * flown_s, routes)


def _kept(ends: list[Ending], resolution_m_s: float) -> list[Ending]:
    """Undominated endings within the resolution, with the least ΔV and cost."""
    falling: list[Ending] = []
    for ending in ends:
        if not falling or ending.delta_v_m_s < falling[-1].delta_v_m_s:
            falling.append(ending)
    cheapest = min(falling, key=lambda ending: ending.cost, default=None)
    kept: list[Ending] = []
    for ending in falling:
        saves = not kept or ending.delta_v_m_s <= kept[-1].delta_v_m_s - resolution_m_s
        if saves or ending is cheapest or ending is falling[-1]:
            kept.append(ending)
    return kept


def write_frontier(path: str | os.PathLike[str], endings: Iterable[Ending]) -> None:
    """Write the CSV file completely or not at all; the last day counts from the mission's start."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for each in endings:
        writer.writerow(
            (
                repr(each.tank_m_s),
                repr(each.prize),
                repr(each.last_s / DAY_S),
                repr(each.delta_v_m_s),
                repr(each.cost),
                json.dumps(each.routes, ensure_ascii=False),
            )
        )
    write_text(path, text.getvalue())
