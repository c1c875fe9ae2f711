"""The numbers behind the family `cloud`, from a catalogue of a fragmentation cloud.

    python bench/fit_cloud.py iridium-33-debris.csv

The file is a table of mean elements with the columns of an orbit mean-elements message (OMM) as
public catalogues give them. Printed are the percentiles of perigee altitude, apogee minus perigee
altitude and inclination over all objects, the densest plane, how far from it the nearest objects
lie, and rank correlations. `adr_opt/sources/generator/clouds.py` states them, rounded.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.sources.generator.clouds import CLOUD_TARGETS as TARGETS
from adr_opt.sources.generator.clouds import PERCENTILES

DENSE_DEG = 10.0
"""The densest plane has the most objects within this distance in RAAN."""

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Fit:
    """Printed numbers: lengths in km, angles in degrees.

    ``plane`` is the RAAN of the densest plane, ``half_width`` the distance from it within which
    the nearest :data:`TARGETS` objects lie; the rank correlations are those of inclination with
    apogee minus perigee (all objects) and of RAAN with inclination (the nearest objects).
    """

    objects: int
    perigee: Array
    difference: Array
    inclination: Array
    plane: float
    half_width: float
    perigee_with_difference: float
    inclination_with_difference: float
    raan_with_inclination: float


def columns(path: Path) -> tuple[Array, Array, Array, Array]:
    """Perigee altitude, apogee − perigee [km], inclination and RAAN [deg] of every object."""
    with path.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))

    def column(name: str) -> Array:
        return np.array([float(row[name]) for row in rows])

    rate = column("MEAN_MOTION") * 2.0 * math.pi / 86400.0
    semi_major_axis = np.cbrt(MU_M3_S2 / rate**2)
    e = column("ECCENTRICITY")
    perigee = (semi_major_axis * (1.0 - e) - EARTH_RADIUS_M) / 1e3
    difference = 2.0 * semi_major_axis * e / 1e3
    return perigee, difference, column("INCLINATION"), column("RA_OF_ASC_NODE")


def rank_correlation(x: Array, y: Array) -> float:
    """Spearman's; ties, rare here, keep the order of the file."""
    ranks = [np.argsort(np.argsort(values, kind="stable")) for values in (x, y)]
    return float(np.corrcoef(ranks[0], ranks[1])[0, 1])


def fit(path: Path) -> Fit:
    """The numbers of a catalogue file."""
    perigee, difference, inclination, raan = columns(path)
    planes = np.arange(360.0)
    away = np.abs((raan[None, :] - planes[:, None] + 180.0) % 360.0 - 180.0)
    dense = (away <= DENSE_DEG).sum(axis=1)
    # Neighbouring planes tie: the middle one.
    plane = float(np.median(planes[dense == dense.max()]))
    offset = (raan - plane + 180.0) % 360.0 - 180.0
    near = np.argsort(np.abs(offset), kind="stable")[:TARGETS]
    return Fit(
        objects=raan.size,
        perigee=np.percentile(perigee, PERCENTILES),
        difference=np.percentile(difference, PERCENTILES),
        inclination=np.percentile(inclination, PERCENTILES),
        plane=plane,
        half_width=float(np.abs(offset[near]).max()),
        perigee_with_difference=rank_correlation(perigee, difference),
        inclination_with_difference=rank_correlation(inclination, difference),
        raan_with_inclination=rank_correlation(offset[near], inclination[near]),
    )


def main(argv: Sequence[str] | None = None) -> None:
    """Print the numbers."""
    parser = argparse.ArgumentParser(description="Numbers behind the family 'cloud'.")
    parser.add_argument("path", type=Path, metavar="CSV")
    found = fit(parser.parse_args(argv).path)
    print(f"objects                 {found.objects}")
    print(f"percentiles             {', '.join(f'{q:g}' for q in PERCENTILES)}")
    for name, values, digits in (
        ("perigee altitude, km", found.perigee, 1),
        ("apogee - perigee, km", found.difference, 1),
        ("inclination, deg", found.inclination, 3),
    ):
        print(f"{name:<24}{', '.join(f'{value:.{digits}f}' for value in values)}")
    print(f"densest plane, deg      {found.plane:g}")
    print(f"nearest {TARGETS} within, deg  {found.half_width:.1f}")
    print(f"perigee, a - p          {found.perigee_with_difference:.2f}")
    print(f"inclination, a - p      {found.inclination_with_difference:.2f}")
    print(f"RAAN, inclination       {found.raan_with_inclination:.2f}")


if __name__ == "__main__":
    main()
