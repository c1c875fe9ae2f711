"""Instances and travel times, by the text that comes with them.

All times are in milliseconds from midnight, as in the files.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from adr_opt.common.errors import InputError
from adr_opt.common.files import read_text

from ..reading import FloatArray, filled_lines, numbers_of, published

SLOTS = 56
SLOT_MS, FIRST_MS = 900_000.0, 21_600_000.0
"""Travel times are given for departures at 6:00 and every quarter of an hour later."""

NAME = re.compile(r"(\d+)\.\d+\.\d+")


@dataclass(frozen=True)
class Places:
    """An instance; the tour begins at the first place and ends at the last.

    Attributes
    ----------
    name : str
    longest_ms : float
        Between the beginning and the end of the tour.
    score, service_ms, opens_ms, closes_ms : (places,) float64
    """

    name: str
    longest_ms: float
    score: FloatArray
    service_ms: FloatArray
    opens_ms: FloatArray
    closes_ms: FloatArray

    @property
    def count(self) -> int:
        """Places, with the first and the last."""
        return int(self.score.size)


class Optimum(NamedTuple):
    """Result of CPLEX 12.6 for a static instance: score, seconds, status as in the file."""

    score: float
    taken_s: float
    status: str

    @property
    def is_proven(self) -> bool:
        """Whether the score is an optimum and not the best within 72 hours."""
        return self.status == "optimal"


@published
def read_places(path: Path) -> Places:
    """An instance: the number of places, the longest tour, and a line for each place.

    A line holds ``id;score;pen;service;opens;closes``, of which the first and the third are to be
    ignored.
    """
    first, second, *lines = filled_lines(path)
    (count,), (longest,) = numbers_of(first, 1), numbers_of(second, 1)
    columns = np.array([numbers_of(line, 6, ";") for line in lines]).T
    if columns.shape[1] != count or (columns[4] > columns[5]).any():
        raise ValueError(f"not {count:g} places with windows")
    return Places(path.stem, longest, columns[1], columns[3], columns[4], columns[5])


@published
def read_static(path: Path, count: int) -> FloatArray:
    """Travel times that do not depend on the departure, as (origin, destination, 1) [ms]."""
    rows = np.array([numbers_of(line, count, ";") for line in filled_lines(path)])
    return rows.reshape(count, count, 1)


@published
def read_varying(path: Path, count: int) -> FloatArray:
    """Travel times by the departure, as (origin, destination, slot) [ms]."""
    values = numbers_of(read_text(path), count * count * SLOTS, ";")
    return np.array(values).reshape(count, count, SLOTS)


def instance_files(folder: Path) -> list[Path]:
    """The instances of a folder, in the order of their numbers."""
    found = [path for path in folder.glob("*.TXT") if NAME.fullmatch(path.stem)]
    if not found:
        raise InputError(f"{folder}: no instance like 20.1.1.TXT in it; name their folder")
    return sorted(found, key=lambda path: [int(part) for part in path.stem.split(".")])


def travel_of(path: Path, places: Places, *, varying: bool) -> FloatArray:
    """The travel times that belong to an instance, from the file beside it."""
    size = path.stem.partition(".")[0]
    if varying:
        return read_varying(path.with_name(f"tt{size}.TXT"), places.count)
    return read_static(path.with_name(f"titt{size}.TXT"), places.count)


@published
def read_optima(path: Path) -> dict[str, Optimum]:
    """Published results of the static instances, by name."""
    return {
        row["name"]: Optimum(
            float(row["score"]), float(row["cplex_12_6_seconds"]), row["status"] or ""
        )
        for row in csv.DictReader(read_text(path).splitlines())
    }
