"""Results file of a trade-off: CSV with a row for each run, so that it can be resumed.

A row is written at once and whole, on a line of its own; of one that was cut off by the end of the
machine nothing is read, wherever it stands. The first columns say what it belongs to: a file of
another instance or of other settings is refused, not mixed in.
"""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ...common.errors import InputError
from ...common.files import write_text
from ...common.json_text import loaded
from .axes import Axis
from .points import Point, Routes, Tradeoff

COLUMNS = (
    "instance_sha256",
    "settings",
    "delta_v_m_s",
    "duration_s",
    "method",
    "prize",
    "upper_bound",
    "status",
    "visits",
    "cost",
    "runtime_s",
    "cpu_s",
    "routes",
)

OF_DRIVES = {"thrust": "thrust_n", "isp": "isp_s"}
"""Further columns, of files in which these are varied, by the kind of axis."""

LONGEST_SHOWN = 100
"""Length beyond which values from a file are cut in error messages."""


def columns_for(axes: Iterable[Axis]) -> tuple[str, ...]:
    """Columns of a file: those of all files, and where each point stands on these axes."""
    kinds = {axis.kind for axis in axes}
    more = (column for kind, column in OF_DRIVES.items() if kind in kinds)
    at = COLUMNS.index("method")
    return (*COLUMNS[:at], *more, *COLUMNS[at:])


class ResultsFile:
    """Rows of runs, written to a file as they complete.

    ``found`` has what was there, each point with the place of its row for errors.

    Parameters
    ----------
    path : path
        It may be there from an earlier call.
    sha256 : str
        Of the instance.
    settings : str
        What the results depend on besides.
    columns : tuple of str
        Its columns, the first of them the digest and the last the routes.

    Raises
    ------
    InputError
        It is there and is not such a file, or one of another instance or of other settings.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        sha256: str,
        settings: str,
        columns: tuple[str, ...] = COLUMNS,
    ) -> None:
        self._path, self._sha256, self._settings = Path(path), sha256, settings
        self._columns = columns
        self.found = self._read()

    def append(self, point: Point, method: str) -> None:
        """Write the results of a run immediately."""
        self._write(_line(self._row(point, method)))

    def finish(self, tradeoff: Tradeoff) -> None:
        """Rewrite the file with a row for each point, in order."""
        rows = [self._columns] + [
            self._row(point, "+".join(point.methods)) for point in tradeoff.points
        ]
        write_text(self._path, "".join(_line(row) for row in rows))

    def _write(self, text: str) -> None:
        try:
            handle = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
            try:
                size = os.fstat(handle).st_size
                if size == 0:
                    text = _line(self._columns) + text
                else:
                    os.lseek(handle, size - 1, os.SEEK_SET)
                    if os.read(handle, 1) != b"\n":
                        text = "\n" + text  # a row that was cut off stays on a line of its own
                try:
                    _write_all(handle, text.encode())
                    os.fsync(handle)
                except OSError:
                    os.ftruncate(handle, size)
                    raise
            finally:
                os.close(handle)
        except OSError as error:
            raise InputError(
                f"{self._path}: cannot be written ({error.strerror or error}); choose another place"
            ) from error

    def _read(self) -> tuple[tuple[str, Point], ...]:
        if not self._path.exists():
            return ()
        try:
            content = self._path.read_bytes()
        except OSError as error:
            raise InputError(
                f"{self._path}: cannot be read ({error.strerror or error}); name another file"
            ) from None
        lines = content.split(b"\n")
        torn = lines.pop()  # what follows the last line feed, mostly nothing
        header = _line(self._columns).rstrip().encode()
        if not lines and header.startswith(torn):
            self._empty()
            return ()
        if not lines or lines[0].rstrip(b"\r") != header:
            raise InputError(f"{self._path}: not a file of results; name another one")
        found = []
        for number, line in enumerate(lines[1:], start=2):
            where = f"{self._path}: row {number}"
            row = self._whole(line.rstrip(b"\r"), where)
            if row is not None:
                found.append((where, self._point(row, where)))
        return tuple(found)

    def _empty(self) -> None:
        """Restart a file whose first line is incomplete."""
        try:
            os.truncate(self._path, 0)
        except OSError as error:
            raise InputError(
                f"{self._path}: cannot be written ({error.strerror or error}); choose another place"
            ) from None

    def _whole(self, line: bytes, where: str) -> dict[str, str] | None:
        """The row on a line; None if it is incomplete or blank.

        A row that follows upon such a one in the same line is taken from there: each begins with
        the digest of the instance.
        """
        begin = line.rfind(self._sha256.encode() + b",")
        cells = _cells(line[max(begin, 0) :])
        if cells is not None and len(cells) == len(self._columns) and not _is_cut_off(cells[-1]):
            return dict(zip(self._columns, cells, strict=True))
        first = line.partition(b",")[0]
        if begin < 0 and not self._sha256.encode().startswith(first):
            raise InputError(f"{where}: not a row of results; name another file")
        return None

    def _point(self, row: dict[str, str], where: str) -> Point:
        if row["instance_sha256"] != self._sha256:
            raise InputError(f"{where}: of another instance; name another file for the results")
        if row["settings"] != self._settings:
            raise InputError(
                f"{where}: made with {_shown(row['settings'])}, and this is {self._settings}; name "
                "another file, or use the same settings"
            )
        try:
            point = Point(
                float(row["delta_v_m_s"]),
                float(row["duration_s"]),
                float(row["prize"]),
                float(row["upper_bound"]),
                int(row["visits"]),
                float(row["cost"]),
                _routes(row["routes"]),
                tuple(filter(None, row["method"].split("+"))),
                float(row["runtime_s"]),
                float(row["cpu_s"]),
                **{name: float(row[name]) for name in OF_DRIVES.values() if name in row},
            )
        except (ValueError, TypeError, RecursionError):
            raise InputError(f"{where}: not a row of results; name another file") from None
        for name, value, holds in (
            ("delta_v_m_s", point.delta_v_m_s, 0.0 < point.delta_v_m_s < math.inf),
            ("duration_s", point.duration_s, 0.0 < point.duration_s < math.inf),
            ("thrust_n", point.thrust_n, _is_positive(point.thrust_n)),
            ("isp_s", point.isp_s, _is_positive(point.isp_s)),
            ("prize", point.prize, point.prize < math.inf),
            ("upper_bound", point.upper_bound, not math.isnan(point.upper_bound)),
            ("runtime_s", point.runtime_s, 0.0 <= point.runtime_s < math.inf),
            ("cpu_s", point.cpu_s, 0.0 <= point.cpu_s < math.inf),
        ):
            if not holds:
                raise InputError(f"{where}: {name} = {value!r} is not a result; name another file")
        return point

    def _row(self, point: Point, method: str) -> tuple[Any, ...]:
        drive = [getattr(point, name) for name in OF_DRIVES.values() if name in self._columns]
        cost = "nan" if math.isnan(point.cost) else repr(point.cost)
        return (
            self._sha256,
            self._settings,
            repr(point.delta_v_m_s),
            repr(point.duration_s),
            *map(repr, drive),
            method,
            repr(point.prize),
            repr(point.upper_bound),
            point.status,
            point.visits,
            cost,
            f"{point.runtime_s:.3f}",
            f"{point.cpu_s:.3f}",
            json.dumps(point.routes, ensure_ascii=False),
        )


def _is_positive(value: float | None) -> bool:
    """Whether an optional number is positive and finite where there is one."""
    return value is None or 0.0 < value < math.inf


def _write_all(handle: int, content: bytes) -> None:
    """Write all content: a full disk accepts a part, and reports it only on the next call."""
    while content:
        content = content[os.write(handle, content) :]


def _cells(line: bytes) -> list[str] | None:
    """Cells of a line; None if it is not valid CSV."""
    longest = csv.field_size_limit(max(csv.field_size_limit(), len(line)))
    try:
        rows = list(csv.reader([line.decode()], strict=True))
    except (csv.Error, UnicodeDecodeError):
        return None
    finally:
        csv.field_size_limit(longest)
    return rows[0] if len(rows) == 1 else None


def _is_cut_off(text: str) -> bool:
    """Whether a list ends before its brackets do, as in the last cell of a torn row."""
    try:
        loaded(text)
    except json.JSONDecodeError:
        return True
    except RecursionError:
        pass  # for others to refuse
    return False


def _routes(text: str) -> Routes:
    """Names of bodies for each chaser; raises :class:`ValueError` for other texts."""
    routes = loaded(text)
    for route in routes:
        if not isinstance(route, list) or not all(isinstance(name, str) for name in route):
            raise ValueError(text)
    return tuple(tuple(route) for route in routes)


def _shown(text: str) -> str:
    """Text from a file, as far as it is printable."""
    cut = text if len(text) <= LONGEST_SHOWN else text[: LONGEST_SHOWN - 1] + "…"
    return cut if cut.isprintable() else repr(cut)


def _line(row: tuple[Any, ...]) -> str:
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerow(row)
    return text.getvalue()
