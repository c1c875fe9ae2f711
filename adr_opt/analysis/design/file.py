"""Results file of a study of designs: a line of JSON for each finished design, to go on from.

The first line says what the others belong to. A line is written at once and whole; of one that was
cut off by the end of the machine nothing is read. Plans are checked when they are read, and what
they avoid and cost is worked out anew; of a line only its plan and its bound count.
"""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

from ...common.errors import InputError
from ...common.files import parse_model
from ...judge.check.verdict import check
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
        self._path, self._work = Path(path), work
        self._head = _header(work)
        self._found = self._read()

    def points(self, designs: list[Design]) -> dict[Design, DesignPoint]:
        """Points of the file that are among some designs.

        Raises
        ------
        InputError
            A plan has violations, or says more than can be.
        """
        wanted, found = set(designs), {}
        for number, content in self._found:
            design = _design_of(content)
            if design in wanted:
                found[design] = self._point(design, content, f"{self._path}: line {number}")
        return found

    def append(self, point: DesignPoint) -> None:
        """Write a finished design immediately."""
        line = _line(
            {
                "design": dict(point.design.values),
                "plan": None if point.plan is None else point.plan.to_dict(),
                "bound": point.bound if math.isfinite(point.bound) else None,
                "runtime_s": round(point.runtime_s, 3),
                "cpu_s": round(point.cpu_s, 3),
            }
        )
        try:
            with self._path.open("ab+") as file:
                size = file.seek(0, os.SEEK_END)
                before = b"" if size else _line(self._head)
                if size:
                    file.seek(size - 1)
                    before = b"" if file.read(1) == b"\n" else b"\n"
                try:
                    file.write(before + line)
                    file.flush()
                    os.fsync(file.fileno())
                except OSError:
                    file.truncate(size)
                    raise
        except OSError as error:
            raise InputError(
                f"{self._path}: cannot be written ({error.strerror or error}); choose another place"
            ) from error

    def _read(self) -> list[tuple[int, dict[str, Any]]]:
        if not self._path.exists():
            return []
        try:
            lines = self._path.read_bytes().split(b"\n")
        except OSError as error:
            raise InputError(
                f"{self._path}: cannot be read ({error.strerror or error}); name another file"
            ) from None
        if lines[0] and _line(self._head).startswith(lines[0]) and lines[1:] in ([], [b""]):
            self._path.write_bytes(b"" if len(lines) == 1 else lines[0] + b"\n")
            return []
        head = _parsed(lines[0])
        if lines == [b""]:
            return []
        if head is None or head.get("format") != FORMAT:
            raise InputError(f"{self._path}: not a file of designs; name another one")
        for key, value in self._head.items():
            if head.get(key) != value:
                raise InputError(
                    f"{self._path}: made with other {key.replace('_', ' ')}; name another file, "
                    "or use the same"
                )
        parsed = ((number, _parsed(line)) for number, line in enumerate(lines[1:], start=2))
        return [(number, content) for number, content in parsed if content is not None]

    def _point(self, design: Design, content: dict[str, Any], where: str) -> DesignPoint:
        instance = self._work.instance_of(design)
        plan = None
        if content.get("plan") is not None:
            plan = parse_model(json.dumps(content["plan"]), Plan, where)
            try:
                violations = check(instance, plan)
            except InputError as error:
                raise InputError(f"{where}: {error}") from None
            if violations:
                raise InputError(
                    f"{where}: the plan has a violation ({violations[0]}); name another file"
                )
        bound = math.inf if content.get("bound") is None else content["bound"]
        times = _number(content.get("runtime_s"), where), _number(content.get("cpu_s"), where)
        try:
            point = self._work.point(design, instance, plan, _number(bound, where), *times)
        except BrokenBound:
            raise InputError(
                f"{where}: its plan avoids more than its bound; name another file"
            ) from None
        if point.euros > (design.value("budget") or math.inf):
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


def _design_of(content: dict[str, Any]) -> Design | None:
    values = content.get("design")
    if not isinstance(values, dict):
        return None
    if not all(isinstance(value, (int, float)) for value in values.values()):
        return None
    return Design(tuple((kind, float(value)) for kind, value in values.items()))


def _line(content: dict[str, Any]) -> bytes:
    return json.dumps(content, ensure_ascii=False, allow_nan=False).encode() + b"\n"


def _parsed(line: bytes) -> dict[str, Any] | None:
    """The object on a line; None if it is incomplete."""
    try:
        content = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) else None
