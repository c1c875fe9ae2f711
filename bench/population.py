"""A synthetic population of objects in low orbits, as catalogue and satcat files.

Drawn, not copied: families of round numbers like those that public accounts give, with no object of
a catalogue. `catalogue.csv` is OMM as CSV, `satcat.tsv` has columns of the General Catalog; some
masses are unknown there and some uncertain. The same seed gives the same files.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2


class Family(NamedTuple):
    """Objects that are alike.

    Attributes
    ----------
    name : str
    kind : str
        Type of the General Catalog.
    share : float
        Part of the population.
    altitude_km, spread_km : float
        Mean and deviation of mean altitudes.
    eccentricity : float
        Mean of an exponential distribution.
    inclination_deg, tilt_deg : float
        Mean and deviation.
    mass_kg, length_m, diameter_m : float
        Medians; 0 for unknown.
    scatter : float
        Deviation of the logarithm of masses.
    """

    name: str
    kind: str
    share: float
    altitude_km: float
    spread_km: float
    eccentricity: float
    inclination_deg: float
    tilt_deg: float
    mass_kg: float
    length_m: float
    diameter_m: float
    scatter: float


FAMILIES = (
    Family("HEAVY R/B", "R2", 0.0009, 845, 8, 0.0008, 71.0, 0.02, 8900, 10.4, 3.9, 0.0),
    Family("TWIN R/B", "R2", 0.0060, 950, 40, 0.0030, 82.95, 0.02, 1435, 6.5, 2.4, 0.0),
    Family("EARLY R/B", "R2", 0.0085, 760, 40, 0.0030, 74.05, 0.02, 1435, 6.5, 2.4, 0.0),
    Family("THIRD R/B", "R3", 0.0060, 860, 90, 0.0050, 81.2, 0.05, 1100, 3.8, 2.6, 0.0),
    Family("SUN R/B", "R2", 0.0140, 730, 90, 0.0060, 98.4, 0.5, 2500, 8.0, 2.9, 0.5),
    Family("TRANSFER R/B", "R2", 0.0080, 1500, 500, 0.1500, 50.0, 20.0, 2000, 8.0, 3.0, 0.5),
    Family("LISTENER", "P", 0.0035, 850, 25, 0.0015, 71.0, 0.02, 3200, 6.0, 2.0, 0.1),
    Family("LISTENER B", "P", 0.0040, 640, 30, 0.0015, 82.5, 0.02, 2200, 5.0, 1.8, 0.1),
    Family("NAVIGATOR", "P", 0.0130, 980, 20, 0.0030, 82.95, 0.02, 820, 3.0, 2.0, 0.1),
    Family("OBSERVER", "P", 0.0300, 720, 90, 0.0015, 98.3, 0.5, 1000, 3.0, 1.8, 0.9),
    Family("GIANT", "P", 0.0001, 768, 5, 0.0005, 98.3, 0.1, 8000, 10.0, 4.0, 0.0),
    Family("MESSENGER", "P", 0.0200, 1450, 40, 0.0020, 82.6, 0.3, 225, 1.5, 1.0, 0.3),
    Family("RELAY", "P", 0.3300, 550, 8, 0.0002, 53.0, 0.2, 280, 3.0, 1.5, 0.1),
    Family("RELAY P", "P", 0.0600, 560, 5, 0.0002, 97.6, 0.1, 290, 3.0, 1.5, 0.1),
    Family("HIGH RELAY", "P", 0.0320, 1200, 5, 0.0003, 87.9, 0.02, 150, 1.5, 1.0, 0.0),
    Family("CUBE", "P", 0.0700, 520, 30, 0.0010, 97.5, 0.4, 5, 0.3, 0.1, 0.6),
    Family("EAST DEB", "D", 0.1200, 830, 90, 0.0120, 98.7, 0.6, 0, 0, 0, 0.0),
    Family("CRASH DEB", "D", 0.0250, 760, 60, 0.0080, 86.4, 0.2, 0, 0, 0, 0.0),
    Family("CRASH B DEB", "D", 0.0450, 780, 80, 0.0120, 74.0, 0.2, 0, 0, 0, 0.0),
    Family("STAGE DEB", "D", 0.0900, 860, 160, 0.0200, 81.5, 1.0, 0, 0, 0, 0.0),
    Family("SUN DEB", "D", 0.0900, 750, 120, 0.0150, 98.5, 0.8, 0, 0, 0, 0.0),
)
"""The rest, to the whole, is debris of all inclinations."""

OTHER = Family("OLD DEB", "D", 0.0, 900, 300, 0.0400, 70.0, 20.0, 0, 0, 0, 0.0)

UNKNOWN, UNCERTAIN = 0.05, 0.25
"""Shares of objects with a mass whose mass is left out, and marked as uncertain."""

EPOCH = "2026-01-01T00:00:00.000000"

OMM_HEADER = (
    "OBJECT_NAME,OBJECT_ID,EPOCH,MEAN_MOTION,ECCENTRICITY,INCLINATION,RA_OF_ASC_NODE,"
    "ARG_OF_PERICENTER,MEAN_ANOMALY,EPHEMERIS_TYPE,CLASSIFICATION_TYPE,NORAD_CAT_ID,ELEMENT_SET_NO,"
    "REV_AT_EPOCH,BSTAR,MEAN_MOTION_DOT,MEAN_MOTION_DDOT\n"
)
SATCAT_HEADER = (
    "#JCAT\tSatcat\tPiece\tType\tName\tMass\tMassFlag\tDryMass\tDryFlag\tLength\tLFlag\tDiameter\t"
    "DFlag\n# Updated 2026 Jan  1\n"
)


def write_population(folder: Path, count: int = 20_000, seed: int = 0) -> tuple[Path, Path]:
    """Write both files; returns their paths."""
    random = np.random.default_rng(seed)
    numbers = [round(count * family.share) for family in FAMILIES]
    families = zip((*FAMILIES, OTHER), (*numbers, count - sum(numbers)), strict=True)
    catalogue, satcat = folder / "catalogue.csv", folder / "satcat.tsv"
    with (
        catalogue.open("w", newline="", encoding="utf-8") as rows,
        satcat.open("w", encoding="utf-8") as lines,
    ):
        writer = csv.writer(rows, lineterminator="\n")
        rows.write(OMM_HEADER)
        lines.write(SATCAT_HEADER)
        kinds = (family for family, some in families for _ in range(some))
        for number, family in enumerate(kinds, 10_001):
            writer.writerow(_elements(family, number, random))
            lines.write("\t".join(_entry(family, number, random)) + "\n")
    return catalogue, satcat


def _designator(number: int) -> str:
    return f"20{number // 1000:02d}-{number % 1000:03d}A"


def _elements(family: Family, number: int, random: np.random.Generator) -> list[object]:
    altitude_m = 1e3 * max(random.normal(family.altitude_km, family.spread_km), 350.0)
    axis = EARTH_RADIUS_M + altitude_m
    most = (altitude_m - 300e3) / axis
    eccentricity = min(random.exponential(family.eccentricity), most)
    inclination = min(max(random.normal(family.inclination_deg, family.tilt_deg), 0.5), 150.0)
    motion = math.sqrt(MU_M3_S2 / axis**3) * DAY_S / (2.0 * math.pi)
    angles = [f"{angle:.4f}" for angle in random.uniform(0.0, 360.0, 3)]
    bstar = 0.05 * random.lognormal(0.0, 0.8) / 12.74 if family.kind == "D" else 1e-4
    shape = f"{motion:.8f}", f"{eccentricity:.7f}", f"{inclination:.4f}", *angles
    rest = 0, "U", number, 999, 1, f"{bstar:.5e}", 0, 0
    return [family.name, _designator(number), EPOCH, *shape, *rest]


def _entry(family: Family, number: int, random: np.random.Generator) -> list[str]:
    flag, mass, lengths = " ", "-", ("-", "-")
    if family.mass_kg:
        lengths = (f"{family.length_m:6.1f}", f"{family.diameter_m:5.1f}")
        mass = f"{family.mass_kg * random.lognormal(0.0, family.scatter):8.0f}"
        chance = random.uniform()
        if chance < UNKNOWN:
            mass = "-"
        elif chance < UNKNOWN + UNCERTAIN:
            flag = "?"
    named = f"S{number:05d}", f"{number:05d}", _designator(number), f"{family.kind:12s}"
    return [*named, family.name, mass, flag, mass, flag, lengths[0], " ", lengths[1], " "]
