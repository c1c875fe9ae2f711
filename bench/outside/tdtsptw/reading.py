"""Instances and best known ends, in the units of the files."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from adr_opt.common.errors import InputError
from adr_opt.common.files import read_text

from ..reading import FloatArray, published

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


@published
def read_roads(path: Path) -> Roads:
    """An instance; ways that its graph does not have are closed."""
    content = json.loads(read_text(path))
    zones, windows, speeds, distance, clusters, arcs = (
        np.array(each, dtype=float)
        for each in (
            *(content[key] for key in ("speed_zones", "time_windows", "cluster_speeds")),
            *(content["distances"], content["clusters"], content["digraph"]["arcs"]),
        )
    )
    start, end = int(content["start_depot"]), int(content["end_depot"])
    places, latest = len(windows), float(content["horizon"][1])
    there = (arcs != 0.0) & ~np.eye(places, dtype=np.bool_)
    cluster = np.where(there, clusters, -1.0).astype(np.int64)
    sound = (
        (zones[1:, 0] == zones[:-1, 1]).all()
        and (zones[:, 0] < zones[:, 1]).all()
        and (speeds > 0.0).all()
        and speeds.shape[1] == len(zones)
        and distance.shape == cluster.shape == (places, places)
        and {start, end} <= set(range(places))
        and ((cluster[there] >= 0) & (cluster[there] < len(speeds))).all()
    )
    if not sound:
        raise ValueError("zones, speeds, ways or depots do not go together")
    edges = np.append(zones[:, 0], zones[-1, 1])
    return Roads(path.stem, start, end, latest, edges, speeds, cluster, distance, *windows.T)


def instance_files(folder: Path) -> list[Path]:
    """The instances of a folder, smallest first."""
    found = sorted(folder.glob("*_*_*_*_*.json"))
    if not found:
        raise InputError(f"{folder}: no instance like 15_70_A_25_B6.json in it; name their folder")
    return found


@published
def read_best(path: Path) -> dict[str, float]:
    """Known least ends by name; NaN where none is known."""
    rows = [line.split("\t") for line in read_text(path).splitlines()[1:]]
    return {row[0]: math.nan if row[2] == "-" else float(row[2]) for row in rows}
