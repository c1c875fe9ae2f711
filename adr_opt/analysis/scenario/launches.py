"""Objects launched in later years, from a table.

CSV, a line for each kind of launch: ``year`` from the beginning, ``count``, ``kind``, ``mass`` in
kg, ``size`` in m (the diameter of a sphere of the mean cross-section), ``perigee`` and ``apogee``
altitudes in km, ``inclination`` in degrees, and optionally ``every``, years after which the same
is launched again. Nodes, perigees and anomalies are drawn.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from ...common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2
from ...common.errors import InputError
from ...common.files import read_text
from ...kernels.orbits.keyed_draws import keyed_draws
from ...problem.air import ALTITUDES_KM
from ...sources.catalogue.records import ElementSet, shown
from ...sources.csv_table import csv_number, csv_rows
from ...sources.worth.bodies import BY_SIZE, TABLE, Bodies
from .population import ObjectPopulation, padded
from .settings import KINDS

COLUMNS = ("year", "count", "kind", "mass", "size", "perigee", "apogee", "inclination")

MOST_COUNT = 100_000

NODES, ARGUMENTS, ANOMALIES = 11, 12, 13
"""Kinds of draws."""


@dataclass(frozen=True)
class Launch:
    """Objects of one kind that are launched together.

    Attributes
    ----------
    year : int
    count : int
    kind : str
    mass, size : float
        [kg], [m].
    perigee, apogee : float
        Altitudes [km].
    inclination : float
        [degrees].
    every : int
        Years until the same again; 0 for once.
    """

    year: int
    count: int
    kind: str
    mass: float
    size: float
    perigee: float
    apogee: float
    inclination: float
    every: int = 0

    def is_in(self, year: int) -> bool:
        """Whether the launch takes place in a year."""
        since = year - self.year
        return since == 0 or (since > 0 and self.every > 0 and since % self.every == 0)


def read_launches(path: str | os.PathLike[str]) -> tuple[Launch, ...]:
    """Read a table of launches.

    Raises
    ------
    InputError
        It cannot be read, a column is unknown or missing, or a value is out of range.
    """
    columns = ", ".join(COLUMNS)
    rows = csv_rows(read_text(path), path, _header, columns)
    return tuple(_launch(cells, where) for where, cells in rows)


def _header(cells: list[str], where: str) -> list[str]:
    header = [cell.casefold() for cell in cells]
    if sorted(header) not in (sorted(COLUMNS), sorted((*COLUMNS, "every"))):
        raise InputError(f"{where}: give the columns {', '.join(COLUMNS)} and, if you like, every")
    return header


def _launch(cells: dict[str, str], where: str) -> Launch:
    if cells["kind"] not in KINDS:
        raise InputError(
            f"{where}: kind = {shown(cells['kind'])!r}: must be one of {', '.join(KINDS)}"
        )
    floor = float(ALTITUDES_KM[0])
    every = _number(cells["every"], f"{where}: every", 0, 200) if cells.get("every") else 0
    launch = Launch(
        year=int(_number(cells["year"], f"{where}: year", 0, 200, whole=True)),
        count=int(_number(cells["count"], f"{where}: count", 1, MOST_COUNT, whole=True)),
        kind=cells["kind"],
        mass=_number(cells["mass"], f"{where}: mass", 1e-3, 1e6),
        size=_number(cells["size"], f"{where}: size", 1e-2, 1e3),
        perigee=_number(cells["perigee"], f"{where}: perigee", floor, 1e5),
        apogee=_number(cells["apogee"], f"{where}: apogee", floor, 1e5),
        inclination=_number(cells["inclination"], f"{where}: inclination", 0, 180),
        every=int(every),
    )
    if launch.apogee < launch.perigee:
        raise InputError(f"{where}: apogee {launch.apogee:g} km is below the perigee; swap them")
    if every != int(every):
        raise InputError(f"{where}: every = {cells['every']}: must be a whole number of years")
    return launch


def _number(text: str, where: str, least: float, most: float, *, whole: bool = False) -> float:
    value = csv_number(text, where)
    if not least <= value <= most:
        raise InputError(f"{where} = {shown(text)}: must be between {least:g} and {most:g}")
    if whole and value != int(value):
        raise InputError(f"{where} = {shown(text)}: must be a whole number")
    return value


def launched(
    launches: Sequence[Launch], year: int, seed: int, first: int, epoch: datetime
) -> ObjectPopulation | None:
    """Objects launched in a year; None if there are none.

    Parameters
    ----------
    launches : sequence of Launch
    year, seed : int
    first : int
        Number of the first of them.
    epoch : datetime
        Of the year.
    """
    rows = [launch for launch in launches if launch.is_in(year) for _ in range(launch.count)]
    if not rows:
        return None
    numbers = np.arange(first, first + len(rows))
    ends = EARTH_RADIUS_M + 1e3 * np.array([[row.perigee, row.apogee] for row in rows])
    tilts = np.radians([row.inclination for row in rows])
    angles = [
        2.0 * math.pi * keyed_draws(seed, year, kind, numbers)
        for kind in (NODES, ARGUMENTS, ANOMALIES)
    ]
    orbits = np.column_stack((ends, tilts, *angles))
    masses, sizes = (np.array([getattr(row, name) for row in rows]) for name in ("mass", "size"))
    records = tuple(
        _record(row, orbit, f"launched {year}-{place + 1}", epoch)
        for place, (row, orbit) in enumerate(zip(rows, orbits, strict=True))
    )
    many = len(rows)
    return ObjectPopulation(
        numbers,
        orbits,
        Bodies(
            records=records,
            shells=padded(ends),
            tilts=tilts,
            masses=masses,
            sizes=sizes,
            areas=0.25 * math.pi * sizes**2 / masses,
            kinds=tuple(row.kind for row in rows),
            mass_sources=(TABLE,) * many,
            size_sources=(TABLE,) * many,
            area_sources=(BY_SIZE,) * many,
            matched=0,
            left_out={},
        ),
    )


def _record(
    row: Launch, orbit: np.ndarray[tuple[int], np.dtype[np.float64]], name: str, epoch: datetime
) -> ElementSet:
    axis = 0.5 * (orbit[0] + orbit[1])
    return ElementSet(
        name=name,
        object_id="",
        number=None,
        epoch=epoch,
        mean_motion_rev_day=math.sqrt(MU_M3_S2 / axis**3) * DAY_S / (2.0 * math.pi),
        eccentricity=float((orbit[1] - orbit[0]) / (orbit[1] + orbit[0])),
        inclination_deg=row.inclination,
        raan_deg=math.degrees(orbit[3]),
        argument_of_perigee_deg=math.degrees(orbit[4]),
        mean_anomaly_deg=math.degrees(orbit[5]),
        mass_kg=row.mass,
    )
