"""Instances and best known ends, in the units of the files."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

from adr_opt.common.errors import InputError
from adr_opt.common.files import read_text

from ..reading import FloatArray, floats_of, read_object, sequence_of

BEST = "best.tsv"


@dataclass(frozen=True)
class Roads:
    """An instance.

    Attributes
    ----------
    name : str
    start, end : int
        The depots, among the places.
    latest : float
        End of the horizon.
    edges : (zones + 1,) float64
        Where zones of time begin and end.
    speeds : (clusters, zones) float64
        Distance per time.
    cluster, distance : (places, places)
        By origin and destination; a cluster of −1 where there is no way.
    opens, closes : (places,) float64
    """

    name: str
    start: int
    end: int
    latest: float
    edges: FloatArray
    speeds: FloatArray
    cluster: npt.NDArray[np.int64]
    distance: FloatArray
    opens: FloatArray
    closes: FloatArray

    @property
    def customers(self) -> list[int]:
        """All places but the depots."""
        return [place for place in range(self.opens.size) if place not in (self.start, self.end)]


def read_roads(path: Path) -> Roads:
    """An instance; ways that its graph does not have are closed."""
    content, where = read_object(path), str(path)
    zones = [_floats(zone, 2, where, "speed_zones") for zone in _rows(content, "speed_zones", path)]
    if not zones or any(zone[1] != after[0] for zone, after in pairwise(zones)):
        raise InputError(f"{where}: speed_zones are not one after the other")
    if any(zone[0] >= zone[1] for zone in zones):
        raise InputError(f"{where}: a speed zone ends before it begins")
    windows = [
        _floats(each, 2, where, "time_windows") for each in _rows(content, "time_windows", path)
    ]
    places = len(windows)
    speeds = np.array(
        [
            _floats(row, len(zones), where, "cluster_speeds")
            for row in _rows(content, "cluster_speeds", path)
        ]
    )
    if not (speeds > 0.0).all():
        raise InputError(f"{where}: a speed in cluster_speeds is not positive")
    tables = {
        key: np.array([_floats(row, places, where, key) for row in rows])
        for key, rows in (
            ("distances", _rows(content, "distances", path)),
            ("clusters", _rows(content, "clusters", path)),
            ("arcs", _rows(content.get("digraph") or {}, "arcs", path)),
        )
    }
    for key, table in tables.items():
        if table.shape != (places, places):
            raise InputError(f"{where}: {key} is not a table of the {places} places")
    start, end = (_place(content, key, places, where) for key in ("start_depot", "end_depot"))
    horizon = floats_of(content, "horizon", 2, where)
    there = (tables["arcs"] != 0.0) & ~np.eye(places, dtype=np.bool_)
    cluster = np.where(there, tables["clusters"], -1.0).astype(np.int64)
    if (there & ((cluster < 0) | (cluster >= len(speeds)))).any():
        raise InputError(f"{where}: a way is of no cluster")
    return Roads(
        path.stem,
        start,
        end,
        horizon[1],
        np.array([*(zone[0] for zone in zones), zones[-1][1]]),
        speeds,
        cluster,
        tables["distances"],
        *np.array(windows).T,
    )


def instance_files(folder: Path) -> list[Path]:
    """The instances of a folder, smallest first."""
    found = sorted(folder.glob("*_*_*_*_*.json"))
    if not found:
        raise InputError(f"{folder}: no instance like 15_70_A_25_B6.json in it; name their folder")
    return found


def read_best(path: Path) -> dict[str, float]:
    """Known least ends by name; NaN where none is known."""
    found = {}
    for number, row in enumerate(read_text(path).splitlines()[1:], 2):
        parts = row.split("\t")
        try:
            found[parts[0]] = math.nan if parts[2] == "-" else float(parts[2])
        except (IndexError, ValueError):
            raise InputError(f"{path}: line {number}: no figure; give the file as it is") from None
    return found


def _rows(content: dict, key: str, path: Path) -> list:  # type: ignore[type-arg]
    return sequence_of(content, key, str(path))


def _floats(row: object, count: int, where: str, key: str) -> tuple[float, ...]:
    return floats_of({key: row}, key, count, where)


def _place(content: dict, key: str, places: int, where: str) -> int:  # type: ignore[type-arg]
    value = content.get(key)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < places:
        raise InputError(f"{where}: {key} is no place")
    return value
