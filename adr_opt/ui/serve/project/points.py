"""Points of a trade-off: the prize and the plan of each."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from ....analysis.trade.axes import KINDS
from ....common.errors import InputError
from ....judge.admit import admit
from ....plan.plan import Plan
from ....problem.instance import Instance
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

MILLION = 1e6


def points_of(place: Path, answer: dict[str, Any]) -> dict[str, Any]:
    """Points of a trade-off as JSON data, for a plot and a table.

    Parameters
    ----------
    place : path
        Folder of the result.
    answer : dict
        What ``tradeoff`` has answered.
    """
    kinds = [kind for kind in answer["varied"] if kind in KINDS]
    of_designs = "unit" in answer
    titles = [KINDS[kind].title for kind in kinds]
    across = titles[0]
    if of_designs:
        titles, across = [*titles, "million euros"], "million euros"
    there = set(_files(place))
    rows = []
    for at, point in enumerate(answer["points"], start=1):
        if of_designs:
            values = [point["design"].get(kind) for kind in kinds]
            values.append(None if point["euros"] is None else point["euros"] / MILLION)
        else:
            values = [point[FIELDS[kind]] / KINDS[kind].scale for kind in kinds]
        rows.append(
            {
                "point": at,
                "values": values,
                "prize": point["worth" if of_designs else "prize"],
                "bound": point["bound" if of_designs else "upper_bound"],
                "has_plan": at in there,
            }
        )
    prize = answer["unit"] if of_designs else "prize"
    told = {"titles": titles, "across": titles.index(across), "prize": prize, "points": rows}
    return told | {"kind": None if of_designs else kinds[0]}


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
