"""``.vrp``: a prize-collecting vehicle-routing problem in VRPLIB, as PyVRP and vrplib read it.

What of a mission the format can say. The weights are of one departure, whatever the time. PyVRP
takes them both for distances and for durations, so a file is about one of the two:

- ΔV: a route is one fuel load, from the station and back (VEHICLES_MAX_DISTANCE is the budget);
  there are as many routes as targets, and no clock.
- duration: there is one route, the mission, with service times (SERVICE_TIME_SECTION, which the
  weights do not contain) and VEHICLES_MAX_DURATION; no fuel. Unlike a plan it has to return.

One unit of prize is worth more than all routes together, so PyVRP, which minimises distance plus
prizes forgone, collects prizes first and saves ΔV or time second. PyVRP takes a prize of zero for
a duty; it is written as 1, which no detour is worth. The demand of every target is 1 and CAPACITY
never binds: readers of plain CVRP files ask for both.
"""

from __future__ import annotations

import math
from pathlib import Path

from ...common.errors import InputError
from ...legs.matrices import Matrices
from ...mission.mission import Mission
from .weights import comment, edges, slug, whole_weights

LARGEST_PRIZES = 2**44
"""Largest sum of prizes, as of distances in PyVRP: beyond it sums may overflow."""


def write(
    path: Path, mission: Mission, matrices: Matrices, quantity: str, scale: float | None
) -> None:
    """Write one quantity at one departure.

    Raises
    ------
    InputError
        There is no target, or the prizes differ by too many orders of magnitude.
    """
    instance = mission.instance
    targets = len(instance.targets)
    if targets == 0:
        raise InputError(f"{instance.name!r} has no target: a .vrp file needs at least one")
    is_duration = quantity == "duration"
    limit = instance.mission.duration_s if is_duration else instance.chaser.tank.delta_v_m_s
    weights = whole_weights(matrices, quantity, scale, limit)
    budget = math.floor(weights.scale * limit)
    vehicles = 1 if is_duration else targets

    given = [target.prize for target in instance.targets]
    least = min([1.0, *(prize for prize in given if prize > 0.0)])
    prize_unit = (vehicles * budget + 1) / least
    if not prize_unit * sum(given) <= LARGEST_PRIZES:
        raise InputError(
            f"prizes from {least!r} to {max(given)!r} do not fit the integers of a .vrp file "
            f"with scale = {weights.scale:g}; give less"
        )
    prizes = [0, *(max(1, round(prize * prize_unit)) for prize in given)]

    def section(name: str, values: list[int]) -> list[str]:
        numbered = [f"{node} {value}" for node, value in enumerate(values, start=1)]
        return [f"{name}_SECTION", *numbered]

    lines = [
        f"NAME : {slug(instance)}",
        f"COMMENT : {comment(instance, weights)}; {prize_unit:.17g} = a prize of one",
        "TYPE : ACVRP",
        f"DIMENSION : {targets + 1}",
        f"VEHICLES : {vehicles}",
        f"CAPACITY : {targets}",
        f"VEHICLES_MAX_{'DURATION' if is_duration else 'DISTANCE'} : {budget}",
        *edges(weights),
        *section("DEMAND", [0] + [1] * targets),
        *section("PRIZE", prizes),
    ]
    if is_duration:
        service = [0, *(math.ceil(weights.scale * time) for time in mission.rules.service[1:])]
        lines += section("SERVICE_TIME", service)
    lines += ["DEPOT_SECTION", "1", "-1", "EOF"]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
