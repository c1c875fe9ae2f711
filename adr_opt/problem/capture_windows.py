"""Intervals in which targets may be captured: in a file beside the instance, and as arrays.

A list of intervals is an array of shape (intervals, 2), of beginnings and ends [s], ascending and
without overlaps; the last end may be +inf.
"""

from __future__ import annotations

import csv
import hashlib
import io
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..common.errors import InputError, MissingExtra
from ..common.files import write_bytes
from ..common.records import Record, Window
from .ephemerides import Digest, FileName

Array = npt.NDArray[np.float64]

COLUMNS = ("target", "opens_s", "closes_s")
"""Columns of a file of windows."""


class WindowFile(Record):
    """Reference to a file of windows, beside that of the instance: CSV, or ``.parquet``.

    ``sha256`` is that of the file.
    """

    file: FileName
    sha256: Digest


@dataclass(frozen=True, eq=False)
class FileWindows:
    """A file of windows.

    Attributes
    ----------
    content : bytes
    intervals : mapping of str to (intervals, 2) float64
        By target [s].
    """

    content: bytes
    intervals: Mapping[str, Array]

    @property
    def sha256(self) -> str:
        """Digest of the content."""
        return hashlib.sha256(self.content).hexdigest()

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the file if it does not exist yet."""
        if not (Path(path).is_file() and Path(path).read_bytes() == self.content):
            write_bytes(path, self.content)


def read_windows(path: str | os.PathLike[str]) -> FileWindows:
    """Windows of a file with the columns :data:`COLUMNS`, overlaps joined.

    Raises
    ------
    InputError
        It cannot be read or has other columns, or an interval is not one of two ascending numbers.
    MissingExtra
        It is a Parquet file, and pyarrow is not installed.
    """
    try:
        content = Path(path).read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; put the windows there") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    rows = _parquet if Path(path).suffix.lower() == ".parquet" else _csv
    found: dict[str, list[tuple[float, float]]] = {}
    for place, name, opens_s, closes_s in rows(path, content):
        if not 0.0 <= opens_s <= closes_s < math.inf:
            raise InputError(f"{path}: {place}: give a target and two ascending times from 0 on")
        found.setdefault(name, []).append((opens_s, closes_s))
    return FileWindows(content, {name: joined([np.array(each)]) for name, each in found.items()})


def _csv(path: str | os.PathLike[str], content: bytes) -> Iterator[tuple[str, str, float, float]]:
    """Rows of a CSV file, each with its place for messages."""
    try:
        rows = csv.reader(content.decode().splitlines())
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8; give a CSV file") from None
    if tuple(next(rows, ())) != COLUMNS:
        raise InputError(f"{path}: the first line must be {','.join(COLUMNS)}")
    for row in rows:
        try:
            name, opens_s, closes_s = row
            yield f"line {rows.line_num}", name, float(opens_s), float(closes_s)
        except ValueError:
            yield f"line {rows.line_num}", "", math.nan, math.nan


def _parquet(
    path: str | os.PathLike[str], content: bytes
) -> Iterator[tuple[str, str, float, float]]:
    """Rows of a Parquet file, each with its place for messages."""
    try:
        pq = import_module("pyarrow.parquet")
    except ImportError:
        raise MissingExtra("reading windows", "pyarrow", "io") from None
    try:
        table = pq.read_table(io.BytesIO(content), columns=list(COLUMNS))
        columns = [table.column(name).to_pylist() for name in COLUMNS]
    except Exception as error:  # of a damaged file pyarrow raises whatever it runs into
        raise InputError(
            f"{path}: not a Parquet file with the columns {', '.join(COLUMNS)} "
            f"({str(error).splitlines()[0]})"
        ) from None
    for number, (name, opens_s, closes_s) in enumerate(zip(*columns, strict=True), start=1):
        try:
            yield f"row {number}", str(name), float(opens_s), float(closes_s)
        except (TypeError, ValueError):
            yield f"row {number}", "", math.nan, math.nan


def file_of(windows: Mapping[str, Array]) -> FileWindows:
    """Windows as a CSV file, rounded inwards to a millisecond."""
    text, kept = io.StringIO(), {}
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(COLUMNS)
    for name, intervals in windows.items():
        inner = np.column_stack(
            [np.ceil(intervals[:, 0] * 1e3) / 1e3, np.floor(intervals[:, 1] * 1e3) / 1e3]
        )
        kept[name] = inner[inner[:, 0] <= inner[:, 1]]
        rows.writerows([name, f"{a:.3f}", f"{b:.3f}"] for a, b in kept[name].tolist())
    return FileWindows(text.getvalue().encode(), kept)


def joined(lists: Iterable[Array]) -> Array:
    """Union of several lists of intervals; those that touch are merged."""
    every = np.concatenate([np.empty((0, 2)), *lists])
    every = every[np.argsort(every[:, 0], kind="stable")]
    reach = np.maximum.accumulate(every[:, 1])
    starts = np.flatnonzero(np.append(True, every[1:, 0] > reach[:-1]))[: len(every)]
    ends = np.append(starts[1:], len(every))[: len(starts)] - 1
    return np.column_stack([every[starts, 0], reach[ends]])


def intervals_of(windows: Iterable[Window]) -> Array:
    """Windows of records as an array, +inf where one never closes."""
    listed = [(a, math.inf if b is None else b) for a, b in windows]
    return np.array(listed, dtype=np.float64).reshape(-1, 2)


def windows_from(intervals: Array) -> tuple[Window, ...]:
    """Intervals as windows of records."""
    return tuple((a, None if math.isinf(b) else b) for a, b in intervals.tolist())
