"""Orbits, masses and sizes of the objects of a catalogue, each with its source.

The best source that knows a quantity counts: a table of the user, the General Catalog, the element
set itself, the family of a rocket stage, and otherwise a default by kind of object and class of the
radar cross-section.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

from ...common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2
from ...kernels.orbits.encounters import LEAST_WIDTH_M
from ...problem.air import ALTITUDES_KM, FLOAT
from ..catalogue.filters import Filters
from ..catalogue.records import ElementSet
from .measures import Measures
from .satcat import Quantity, Satcat, SatcatRow


class StageFamily(NamedTuple):
    """Dry mass [kg], and length and diameter where the source has them [m]."""

    mass: float
    source: str
    length: float | None = None
    diameter: float | None = None


STAGES = {
    "SL-16 R/B": StageFamily(9000.0, "A", 11.5, 3.9),
    "SL-8 R/B": StageFamily(1435.0, "A", 6.0, 2.4),
    "SL-3 R/B": StageFamily(1472.0, "D", 5.1, 2.4),
    "SL-12 R/B(2)": StageFamily(2440.0, "B"),
    "SL-23 R/B": StageFamily(9300.0, "C"),
    "ATLAS 5 CENTAUR R/B": StageFamily(2030.0, "B"),
    "BREEZE-M R/B": StageFamily(2370.0, "B"),
    "CZ-2C R/B": StageFamily(4000.0, "B"),
    "CZ-2D R/B": StageFamily(4000.0, "B"),
    "CZ-4B R/B": StageFamily(2000.0, "B"),
    "CZ-4C R/B": StageFamily(2000.0, "B"),
    "DELTA 4 R/B": StageFamily(3420.0, "B"),
    "FALCON 9 R/B": StageFamily(4250.0, "B"),
    "FREGAT R/B": StageFamily(1000.0, "B"),
    "H-2A R/B": StageFamily(3100.0, "B"),
    "PEGASUS R/B": StageFamily(108.0, "B"),
    "PSLV R/B": StageFamily(670.0, "B"),
    "VEGA R/B": StageFamily(688.0, "B"),
}
"""By name in catalogues; the letter is that of the source above."""


def stage_of(name: str) -> StageFamily | None:
    """The stage that a name contains; None for other objects."""
    words = f" {name.upper()} "
    return next((stage for mark, stage in STAGES.items() if f" {mark} " in words), None)


BALLISTIC_M2_KG = 12.741621
"""Drag coefficient × area over mass for a B* of one per Earth radius: 2 / ρ₀ of SGP4, with its
ρ₀ = 0.1570 kg/m² per Earth radius."""

AREA_TO_MASS = (1e-4, 10.0)
"""Range of areas over mass accepted from B* [m²/kg]; outside it, B* was fitted to noise."""


class Default(NamedTuple):
    """Mass [kg] and diameter [m] assumed where nothing is known."""

    mass: float
    size: float


DEFAULTS = {
    ("payload", "LARGE"): Default(1000.0, 2.4),
    ("payload", ""): Default(500.0, 1.9),
    ("payload", "MEDIUM"): Default(50.0, 0.6),
    ("payload", "SMALL"): Default(4.0, 0.25),
    ("rocket body", ""): Default(1400.0, 4.2),
    ("debris", "LARGE"): Default(30.0, 1.6),
    ("debris", "MEDIUM"): Default(4.0, 0.6),
    ("debris", ""): Default(0.6, 0.2),
    ("debris", "SMALL"): Default(0.6, 0.2),
}
"""By kind of object and class of the cross-section. A payload without a class is of half a tonne, a
rocket body like the commonest one, debris near the least that is catalogued."""

TABLE, SATCAT, UNSURE, OMM, FAMILY, BSTAR, DEFAULT = (
    "table",
    "satcat",
    "satcat, uncertain",
    "element set",
    "stage family",
    "B*",
    "default",
)
"""Sources of masses, sizes and areas over mass, best first."""

BY_SIZE = "size and mass"
"""Source of areas over mass that are derived from both."""


@dataclass(frozen=True)
class Bodies:
    """Objects of a catalogue as arrays, in its order.

    Attributes
    ----------
    records : tuple of ElementSet
    shells : (object, 2) float64
        Radii of perigee and apogee [m], at least :data:`.LEAST_WIDTH_M` apart.
    tilts : (object,) float64
        Inclinations [rad].
    masses, sizes, areas : (object,) float64
        Masses [kg], diameters of spheres of the mean cross-section [m], areas over mass [m²/kg].
    kinds : tuple of str
        ``payload``, ``rocket body`` or ``debris``.
    mass_sources, size_sources, area_sources : tuple of str
    matched : int
        Number of objects found in the General Catalog.
    left_out : dict of str to int
        Reasons → numbers of objects of the catalogue that are not here.
    """

    records: tuple[ElementSet, ...]
    shells: FLOAT
    tilts: FLOAT
    masses: FLOAT
    sizes: FLOAT
    areas: FLOAT
    kinds: tuple[str, ...]
    mass_sources: tuple[str, ...]
    size_sources: tuple[str, ...]
    area_sources: tuple[str, ...]
    matched: int
    left_out: dict[str, int]

    def __len__(self) -> int:
        return len(self.records)

    @property
    def default_masses(self) -> dict[str, int]:
        """Numbers of objects with default masses, by kind and mass, the commonest first."""
        each = zip(self.kinds, self.masses.tolist(), self.mass_sources, strict=True)
        told = (f"{kind} {mass:g} kg" for kind, mass, source in each if source.startswith(DEFAULT))
        return dict(Counter(told).most_common())


class _Measured(NamedTuple):
    mass: float
    mass_source: str
    size: float
    size_source: str
    area: float
    area_source: str


def bodies_of(
    records: Sequence[ElementSet],
    satcat: Satcat | None = None,
    measures: Mapping[int, Measures] | None = None,
    excluded: Collection[str] = (),
) -> Bodies:
    """Orbits, masses and sizes of a catalogue's objects.

    Parameters
    ----------
    records : sequence of ElementSet
        Orbits count as they are at their own epochs.
    satcat : Satcat, optional
    measures : mapping of int to Measures, optional
        Of a table, by index of the record.
    excluded : collection of str
        Names to leave out, as of :class:`.Filters`: operating satellites that dodge, for example.
    """
    dodging = Filters(names=tuple(excluded))
    latest = max((record.epoch for record in records), default=datetime.max.replace(tzinfo=UTC))
    kept: list[ElementSet] = []
    shells: list[tuple[float, float]] = []
    kinds: list[str] = []
    measured: list[_Measured] = []
    matched, left_out = 0, Counter[str]()
    for at, record in enumerate(records):
        shell = _shell(record)
        reason = ""
        if record.is_down(latest) or shell[0] < _lowest():
            reason = "decayed"
        elif excluded and dodging.match_name(record):
            reason = "excluded"
        if reason:
            left_out[reason] += 1
            continue
        row = None if satcat is None else _row_of(record, satcat)
        matched += row is not None
        kinds.append(row.kind if row is not None else _kind(record.name))
        measured.append(_measured(record, kinds[-1], row, (measures or {}).get(at, Measures())))
        kept.append(record)
        shells.append(shell)
    return Bodies(
        records=tuple(kept),
        shells=np.array(shells, dtype=float).reshape(-1, 2),
        tilts=np.radians([record.inclination_deg for record in kept]),
        masses=np.array([one.mass for one in measured]),
        sizes=np.array([one.size for one in measured]),
        areas=np.array([one.area for one in measured]),
        kinds=tuple(kinds),
        mass_sources=tuple(one.mass_source for one in measured),
        size_sources=tuple(one.size_source for one in measured),
        area_sources=tuple(one.area_source for one in measured),
        matched=matched,
        left_out=dict(left_out),
    )


def _lowest() -> float:
    return EARTH_RADIUS_M + 1e3 * ALTITUDES_KM[0]


def ends_km(record: ElementSet) -> tuple[float, float]:
    """Altitudes of perigee and apogee of an element set, by Kepler's law [km]."""
    axis = np.cbrt(MU_M3_S2 / (record.mean_motion_rev_day * 2.0 * math.pi / DAY_S) ** 2)
    half = axis * record.eccentricity
    return (axis - half - EARTH_RADIUS_M) / 1e3, (axis + half - EARTH_RADIUS_M) / 1e3


def _shell(record: ElementSet) -> tuple[float, float]:
    """Radii of perigee and apogee [m], at least :data:`.LEAST_WIDTH_M` apart."""
    perigee, apogee = (EARTH_RADIUS_M + 1e3 * end for end in ends_km(record))
    more = max(0.5 * (LEAST_WIDTH_M - (apogee - perigee)), 0.0)
    return perigee - more, apogee + more


def _row_of(record: ElementSet, satcat: Satcat) -> SatcatRow | None:
    if record.number:
        return satcat.by_number.get(record.number)
    return satcat.by_piece.get(record.object_id.upper()) if record.designator else None


def _kind(name: str) -> str:
    """Kind of an object by the suffixes of names in public catalogues."""
    words = name.upper().replace("(", " ").replace(")", " ").split()
    if "R/B" in words:
        return "rocket body"
    return "debris" if "DEB" in words or "DEBRIS" in words else "payload"


def default_of(kind: str, size: str) -> Default:
    """Mass and diameter of an object by its kind and the class of its cross-section."""
    return DEFAULTS.get((kind, size)) or DEFAULTS[kind, ""]


def _measured(
    record: ElementSet, kind: str, row: SatcatRow | None, measures: Measures
) -> _Measured:
    default = default_of(kind, record.size)
    stage = stage_of(record.name) if kind == "rocket body" else None
    mass, mass_source = default.mass, f"{DEFAULT}: {kind}"
    if measures.mass is not None:
        mass, mass_source = measures.mass, TABLE
    elif row is not None and row.mass is not None:
        mass, mass_source = row.mass.value, _certainty(row.mass)
    elif record.mass_kg is not None:
        mass, mass_source = record.mass_kg, OMM
    elif stage is not None:
        mass, mass_source = stage.mass, FAMILY
    size, size_source = default.size, f"{DEFAULT}: {kind}"
    if measures.size is not None:
        size, size_source = measures.size, TABLE
    elif row is not None and row.diameter is not None:
        length = row.length or row.diameter
        size, size_source = (
            cylinder(length.value, row.diameter.value),
            _certainty(length, row.diameter),
        )
    elif stage is not None and stage.length is not None and stage.diameter is not None:
        size, size_source = cylinder(stage.length, stage.diameter), FAMILY
    elif not mass_source.startswith(DEFAULT):
        # A known mass and no size: of the same density over area as the default.
        size = default.size * math.sqrt(mass / default.mass)
    area, area_source = 0.25 * math.pi * size**2 / mass, BY_SIZE
    if mass_source.startswith(DEFAULT) or size_source.startswith(DEFAULT):
        by_bstar = BALLISTIC_M2_KG * record.bstar / 2.2
        if AREA_TO_MASS[0] <= by_bstar <= AREA_TO_MASS[1]:
            area, area_source = by_bstar, BSTAR
        else:
            area_source = f"{DEFAULT}: {kind}"
    return _Measured(mass, mass_source, size, size_source, area, area_source)


def cylinder(length_m: float, diameter_m: float) -> float:
    """Diameter of the sphere with the mean cross-section of a cylinder [m].

    That of a convex body, over all directions, is a quarter of its surface (Cauchy).
    """
    area = 0.25 * math.pi * (diameter_m * length_m + 0.5 * diameter_m**2)
    return math.sqrt(4.0 * area / math.pi)


def _certainty(*quantities: Quantity) -> str:
    return UNSURE if any(quantity.uncertain for quantity in quantities) else SATCAT
