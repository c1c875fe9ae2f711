"""Results file of a study of designs: a line of JSON for each finished design, to go on from.

Plans are checked when they are read, and what they avoid and cost is worked out anew; of a line
only its plan and its bound count.
"""

from __future__ import annotations

import json
import math
import os
from typing import Any

from ...common.errors import InputError
from ...common.files import parse_model
from ...common.json_text import parse_json
from ...common.lines_file import LinesFile
from ...judge.admit import admit
from ...plan.plan import Plan
from .designs import Design
from .point import DesignPoint
from .work import BrokenBound, DesignWork

FORMAT = "adr-opt-designs/1"


class DesignsFile:
    """Finished designs in a file.

    Parameters
    ----------
    path : path
        It may be there from an earlier call.
    work : DesignWork
        What results depend on besides the design.

    Raises
    ------
    InputError
        It is there and is not such a file, or one of other work.
    """

    def __init__(self, path: str | os.PathLike[str], work: DesignWork) -> None:
        self._work = work
        self._lines = LinesFile(path, _header(work), "a file of designs")
        self._found = [_parsed(where, line) for where, line in self._lines.read(_of_other)]

    def points(self, designs: list[Design]) -> dict[Design, DesignPoint]:
        """Points of the file that are among some designs.

        Raises
        ------
        InputError
            A plan has violations, or says more than can be.
        """
        wanted, found = set(designs), {}
        for where, design, content in self._found:
            if design in wanted:
                found[design] = self._point(design, content, where)
        return found

    def append(self, point: DesignPoint) -> None:
        """Write a finished design immediately."""
        self._lines.append(
            {
                "design": dict(point.design.values),
                "plan": None if point.plan is None else point.plan.to_dict(),
                "bound": point.bound if math.isfinite(point.bound) else None,
                "runtime_s": round(point.runtime_s, 3),
                "cpu_s": round(point.cpu_s, 3),
            }
        )

    def _point(self, design: Design, content: dict[str, Any], where: str) -> DesignPoint:
        instance = self._work.instance_of(design)
        plan = None
        if content.get("plan") is not None:
            plan = parse_model(json.dumps(content["plan"]), Plan, where)
            try:
                plan = admit(instance, plan).plan
            except InputError as error:
                raise InputError(f"{where}: {error}; name another file") from None
        bound = math.inf if content.get("bound") is None else content["bound"]
        times = _number(content.get("runtime_s"), where), _number(content.get("cpu_s"), where)
        try:
            point = self._work.point(design, instance, plan, _number(bound, where), *times)
        except BrokenBound:
            raise InputError(
                f"{where}: its plan avoids more than its bound; name another file"
            ) from None
        if point.euros > design.budget:
            raise InputError(f"{where}: its plan is beyond the budget; name another file")
        return point


def _header(work: DesignWork) -> dict[str, Any]:
    rating = work.rating
    return {
        "format": FORMAT,
        "instance": work.instance.sha256,
        "worths": None if rating.worths is None else rating.worths.digest,
        "prices": str(work.prices),
        "settings": f"method {work.method}, {work.time_limit_s:g} s, seed {work.seed}",
    }


def _number(value: object, where: str) -> float:
    if not isinstance(value, (int, float)) or not value >= 0.0:
        raise InputError(f"{where}: not a line of results; name another file")
    return float(value)


def _of_other(key: str) -> str:
    return f"made with other {key.replace('_', ' ')}; name another file, or use the same"


def _parsed(where: str, line: bytes) -> tuple[str, Design, dict[str, Any]]:
    """A line as its place, its design, and its content."""
    content = parse_json(line, where, "not a line of results; name another file")
    values = content.get("design") if isinstance(content, dict) else None
    if not isinstance(values, dict) or not all(
        isinstance(value, (int, float)) for value in values.values()
    ):
        raise InputError(f"{where}: not a line of results; name another file")
    return where, Design(tuple(values.items())), content
