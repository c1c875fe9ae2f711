"""Ground stations: some public ones by name, and others from a file."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...problem.geodetic import place, upward
from ...sources.csv_table import named_numbers

COLUMNS = ("name", "latitude_deg", "longitude_deg", "altitude_m")
"""Columns of a file of ground stations."""


@dataclass(frozen=True)
class GroundStation:
    """A ground station.

    Attributes
    ----------
    name : str
    latitude_deg, longitude_deg : float
        Geodetic, longitudes to the east [deg].
    altitude_m : float
        Above the ellipsoid of WGS 84 [m].

    Raises
    ------
    InputError
        A coordinate is no number, or out of range.
    """

    name: str
    latitude_deg: float
    longitude_deg: float
    altitude_m: float = 0.0

    def __post_init__(self) -> None:
        for column, most in zip(COLUMNS[1:], (90.0, 360.0, 10_000.0), strict=True):
            value = getattr(self, column)
            if not -most <= value <= most:
                raise InputError(
                    f"ground station {self.name!r}: {column} = {value:g}: must be from {-most:g} "
                    f"to {most:g}"
                )

    def place(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Position in axes that turn with the Earth [m], and the direction of the zenith."""
        up = upward(self.latitude_deg, self.longitude_deg)
        return place(self.latitude_deg, self.longitude_deg, self.altitude_m), up


STATIONS = {
    each.name: each
    for each in (
        GroundStation("awarua", -46.53, 168.38),
        GroundStation("fairbanks", 64.86, -147.85, 180.0),
        GroundStation("hartebeesthoek", -25.89, 27.69, 1410.0),
        GroundStation("inuvik", 68.32, -133.55, 50.0),
        GroundStation("kiruna", 67.86, 20.96, 400.0),
        GroundStation("kourou", 5.25, -52.80),
        GroundStation("maspalomas", 27.76, -15.63, 200.0),
        GroundStation("mcmurdo", -77.84, 166.67, 180.0),
        GroundStation("new-norcia", -31.05, 116.19, 250.0),
        GroundStation("punta-arenas", -52.94, -70.85),
        GroundStation("santiago", -33.15, -70.67, 720.0),
        GroundStation("svalbard", 78.23, 15.39, 460.0),
        GroundStation("troll", -72.01, 2.54, 1270.0),
        GroundStation("wallops", 37.95, -75.46),
        GroundStation("weilheim", 47.88, 11.08, 660.0),
    )
}
"""Public ground stations by name, to some kilometres."""


def read_stations(path: str | os.PathLike[str]) -> dict[str, GroundStation]:
    """Ground stations of a CSV file with the columns :data:`COLUMNS`, by name.

    Raises
    ------
    InputError
        It cannot be read or has other columns, a value is no number, or a name stands twice.
    """
    rows = named_numbers(str(path), COLUMNS)
    return {name: GroundStation(name, *numbers) for _, name, numbers in rows}
