"""The results of a trade-off in a file: CSV, a row for each run, so that it can go on later.

A row is written at once and whole; of one that was cut off by the end of the machine nothing is
read. The first columns say what it belongs to: a file of another instance or of other settings is
refused, not mixed in.
"""

from __future__ import annotations

import csv
import io
import json
import math
import os
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...files import write_text
from .points import Point, Tradeoff

COLUMNS = (
    "instance_sha256", "settings", "delta_v_m_s", "duration_s", "method", "prize", "upper_bound",
    "status", "visits", "cost", "runtime_s", "cpu_s", "routes",
)  # fmt: skip


class ResultsFile:
    """Rows of runs that go into a file as they come.

    Parameters
    ----------
    path : path
        It may be there from an earlier call.
    sha256 : str
        Of the instance.
    settings : str
        What the results depend on besides.

    Raises
    ------
    InputError
        It is there and is not such a file, or one of another instance or of other settings.
    """

    def __init__(self, path: str | os.PathLike[str], sha256: str, settings: str) -> None:
        self._path, self._sha256, self._settings = Path(path), sha256, settings
        self.found = self._read()

    def append(self, point: Point, method: str) -> None:
        """Write what a run has found, at once."""
        self._write(_line(_row(point, method, self._sha256, self._settings)))

    def finish(self, tradeoff: Tradeoff) -> None:
        """Write the file anew with a row for each point, in order."""
        rows = [COLUMNS] + [
            _row(point, "+".join(point.methods), self._sha256, self._settings)
            for point in tradeoff.points
        ]
        write_text(self._path, "".join(_line(row) for row in rows))

    def _write(self, text: str) -> None:
        try:
            handle = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
            try:
                if os.fstat(handle).st_size == 0:
                    text = _line(COLUMNS) + text
                os.write(handle, text.encode())
                os.fsync(handle)
            finally:
                os.close(handle)
        except OSError as error:
            raise InputError(
                f"{self._path}: cannot be written ({error.strerror or error}); choose another place"
            ) from error

    def _read(self) -> tuple[Point, ...]:
        if not self._path.exists():
            return ()
        content = self._path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        try:
            rows = list(csv.reader(io.StringIO(whole.decode(), newline=""), strict=True))
        except (csv.Error, UnicodeDecodeError):
            raise InputError(f"{self._path}: not a file of results; name another one") from None
        if content and (not rows or tuple(rows[0]) != COLUMNS):
            raise InputError(f"{self._path}: not a file of results; name another one")
        found = [
            self._point(dict(zip(COLUMNS, row, strict=True)), number)
            for number, row in enumerate(rows[1:], start=2)
            if len(row) == len(COLUMNS)
        ]
        if len(whole) < len(content):
            with self._path.open("r+b") as file:
                file.truncate(len(whole))
        return tuple(found)

    def _point(self, row: dict[str, str], number: int) -> Point:
        where = f"{self._path}: row {number}"
        if row["instance_sha256"] != self._sha256:
            raise InputError(f"{where}: of another instance; name another file for the results")
        if row["settings"] != self._settings:
            raise InputError(
                f"{where}: made with {row['settings']}, and this is {self._settings}; name another "
                "file, or use the same settings"
            )
        try:
            return Point(
                float(row["delta_v_m_s"]), float(row["duration_s"]), float(row["prize"]),
                float(row["upper_bound"]), int(row["visits"]), float(row["cost"]),
                tuple(tuple(route) for route in json.loads(row["routes"])),
                tuple(filter(None, row["method"].split("+"))), float(row["runtime_s"]),
                float(row["cpu_s"]),
            )  # fmt: skip
        except (ValueError, TypeError):
            raise InputError(f"{where}: not a row of results; name another file") from None


def _row(point: Point, method: str, sha256: str, settings: str) -> tuple[Any, ...]:
    cost = "nan" if math.isnan(point.cost) else repr(point.cost)
    return (
        sha256, settings, repr(point.delta_v_m_s), repr(point.duration_s), method,
        repr(point.prize), repr(point.upper_bound), point.status, point.visits, cost,
        f"{point.runtime_s:.3f}", f"{point.cpu_s:.3f}",
        json.dumps(point.routes, ensure_ascii=False),
    )  # fmt: skip


def _line(row: tuple[Any, ...]) -> str:
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerow(row)
    return text.getvalue()
