"""Points of a trade-off: the prize and the plan of each."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

from ....analysis.trade.axes import KINDS
from ....common.errors import InputError
from ....judge.admit import admit
from ....plan.plan import Plan
from ....problem.instance import Instance
from ...plot.chart import Link
from ...plot.fronts import MILLION, Spot, bands_chart, front_chart, named
from ...report.charts import BOTTOM, LEFT, RIGHT, drawn, ends
from .private import refuse_link

PLANS = "plans"
"""Folder of the plans in that of the result."""

FIELDS = {
    "delta-v": "delta_v_m_s",
    "duration": "duration_s",
    "propellant": "propellant_kg",
    "thrust": "thrust_n",
    "isp": "isp_s",
}
"""Varied limits of points, in SI units."""

IN_DESK = 420, 240
"""Size of the chart beside the list of results [px]."""


def points_of(place: Path, answer: dict[str, Any]) -> dict[str, Any]:
    """Points of a trade-off as JSON data, and their chart, in which they lead to their plans.

    Parameters
    ----------
    place : path
        Folder of the result.
    answer : dict
        What ``tradeoff`` has answered.
    """
    kinds = [kind for kind in answer["varied"] if kind in KINDS]
    of_designs = "unit" in answer
    titles = [KINDS[kind].title for kind in kinds] + ["million euros"] * of_designs
    across = len(kinds) if of_designs else 0
    there = set(_files(place))
    told, rows, front = [], dict[str, list[Spot]](), []
    for at, point in enumerate(answer["points"], start=1):
        if of_designs:
            values = [point["design"].get(kind) for kind in kinds]
            values.append(None if point["euros"] is None else point["euros"] / MILLION)
            prize, bound, row = point["worth"], point["bound"], ""
        else:
            values = [point[FIELDS[kind]] / KINDS[kind].scale for kind in kinds]
            prize, bound = point["prize"], point["upper_bound"]
            row = named(kinds[1:], [point[FIELDS[kind]] for kind in kinds[1:]])
        told.append(
            {"point": at, "values": values, "prize": prize, "bound": bound, "has_plan": at in there}
        )
        if not (_known(values[across]) and _known(prize)):
            continue
        said = (f"{title} {value:.5g}" for title, value in zip(titles, values, strict=True))
        link = Link(f"#{at}", ", ".join((*said, f"prize {prize:.5g}"))) if at in there else None
        spot = Spot(values[across], prize, bound if _known(bound) else prize, link)
        rows.setdefault(row, []).append(spot)
        if point.get("on_front"):
            front.append(spot)
    unit = answer["unit"] if of_designs else "prize"
    chart = (
        front_chart(sorted(front, key=lambda spot: spot.x), rows.get("", ()), unit)
        if of_designs
        else bands_chart(rows, titles[0])
    )
    return {
        "titles": titles,
        "across": across,
        "prize": unit,
        "points": told,
        "kind": None if of_designs else kinds[0],
        "chart": drawn(chart, "Points", IN_DESK),
        "ends": [*ends(chart), LEFT, IN_DESK[0] - RIGHT, IN_DESK[1] - BOTTOM],
    }


def _known(value: float | None) -> bool:
    return value is not None and math.isfinite(value)


def plan_of_point(place: Path, point: int) -> tuple[Instance, Plan]:
    """Instance and plan of a point.

    Parameters
    ----------
    place : path
        Folder of the result.
    point : int
        From 1.

    Raises
    ------
    InputError
        It has none, or that is spoilt, of another instance or not legal.
    """
    path = _files(place).get(point)
    if path is None:
        raise InputError(f"point {point} has no plan")
    beside = path.with_name(path.name.replace(".plan.", ".instance."))
    instance, plan = Instance.load(refuse_link(beside)), Plan.load(refuse_link(path))
    try:
        return instance, admit(instance, plan).plan
    except InputError as error:
        raise InputError(f"point {point}: {error}; repeat the trade-off") from None


def _files(place: Path) -> dict[int, Path]:
    """Files of plans by the numbers of points."""
    folder = place / PLANS
    if folder.is_symlink() or not folder.is_dir():
        return {}
    named = {
        path: re.fullmatch(r"(?:point|design)-(\d{1,6})\.plan\.json", path.name)
        for path in folder.iterdir()
    }
    return {int(found[1]): path for path, found in named.items() if found is not None}
