"""Prizes by criticality: the likely harm of a break-up, estimated from a catalogue.

A probability of collision cannot be derived from element sets, and this is none. It is a ranking in
the manner of the criticality indices of the literature (A. Rossi, G. B. Valsecchi, E. M. Alessi,
"The criticality of spacecraft index", Advances in Space Research 56, 2015, 449-460), of what is at
hand: the product of three numbers, each at most 1,

    mass        over that of the heaviest target,
    altitude    how long fragments stay: 1 / density of the air, over that at 1000 km,
    crowding    objects of the catalogue near the altitude and in the band of inclination, over
                that of the most crowded target.

The prize is a hundred times this over that of the most critical target, in whole numbers from 1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ...common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2
from .propagation import FLOAT
from .records import ElementSet

LARGEST = 100.0
"""Prize of the most critical target."""

SIZE_KG = {"LARGE": 1000.0, "MEDIUM": 1000.0 / 10.0**1.5, "SMALL": 1.0}
"""Mass if only the class of the cross-section is known [kg]. Classes differ by a factor of ten in
area, and mass grows with area to the power 3/2; only ratios matter."""

NEAR_M, BAND_DEG = 50e3, 2.5
"""Half widths in semi-major axis and inclination of the neighbourhood that crowds an object."""

HIGHEST_M = 1000e3
"""Altitude above which fragments outlast any planning horizon, and lifetimes count as equal."""

AIR = (
    (200e3, 2.789e-10, 37_105.0),
    (250e3, 7.248e-11, 45_546.0),
    (300e3, 2.418e-11, 53_628.0),
    (350e3, 9.518e-12, 53_298.0),
    (400e3, 3.725e-12, 58_515.0),
    (450e3, 1.585e-12, 60_828.0),
    (500e3, 6.967e-13, 63_822.0),
    (600e3, 1.454e-13, 71_835.0),
    (700e3, 3.614e-14, 88_667.0),
    (800e3, 1.170e-14, 124_640.0),
    (900e3, 5.245e-15, 181_050.0),
    (1000e3, 3.019e-15, 268_000.0),
)
"""The exponential atmosphere of D. A. Vallado, Fundamentals of Astrodynamics and Applications,
table 8-4: base altitude [m], density there [kg/m³], scale height from there on [m]."""


def criticality(
    targets: Sequence[ElementSet],
    catalogue: Sequence[ElementSet],
    masses_kg: Mapping[int, float] | None = None,
) -> FLOAT:
    """Prizes of targets by criticality.

    Parameters
    ----------
    targets : sequence of ElementSet
    catalogue : sequence of ElementSet
        All known objects, targets included, which determine crowding.
    masses_kg : mapping of int to float, optional
        Of targets by their number here, where better known than in the records [kg].

    Returns
    -------
    (target,) float64
        Whole numbers from 1 to :data:`LARGEST`.
    """
    axes, tilts = _bands(targets)
    scores = (
        _shares(masses(targets, masses_kg or {}))
        * np.array([lasting(axis - EARTH_RADIUS_M) for axis in axes])
        * _shares(_crowding(axes, tilts, *_bands(catalogue)))
    )
    prizes: FLOAT = np.maximum(np.round(LARGEST * _shares(scores)), 1.0)
    return prizes


def masses(targets: Sequence[ElementSet], known_kg: Mapping[int, float]) -> FLOAT:
    """Masses where known, or from size classes; else the median of the others [kg]."""
    found = np.full(len(targets), math.nan)
    for number, record in enumerate(targets):
        said = known_kg.get(number, record.mass_kg)
        found[number] = SIZE_KG.get(record.size, math.nan) if said is None else said
    unknown = np.isnan(found)
    found[unknown] = 1.0 if unknown.all() else np.median(found[~unknown])
    return found


def lasting(altitude_m: float) -> float:
    """Lifetime of fragments at an altitude relative to that at :data:`HIGHEST_M`; at most 1."""
    if altitude_m >= HIGHEST_M:
        return 1.0
    base_m, density, scale_m = next((row for row in reversed(AIR) if altitude_m >= row[0]), AIR[0])
    return AIR[-1][1] / (density * math.exp((base_m - altitude_m) / scale_m))


def _bands(records: Sequence[ElementSet]) -> tuple[FLOAT, FLOAT]:
    """Semi-major axes by Kepler's law [m] and inclinations [degrees], at their own epochs."""
    motion = np.array([record.mean_motion_rev_day for record in records]) * 2.0 * math.pi / DAY_S
    return np.cbrt(MU_M3_S2 / motion**2), np.array([record.inclination_deg for record in records])


def _crowding(axes: FLOAT, tilts: FLOAT, all_axes: FLOAT, all_tilts: FLOAT) -> FLOAT:
    return np.array(
        [
            np.count_nonzero(
                (np.abs(all_axes - axis) <= NEAR_M) & (np.abs(all_tilts - tilt) <= BAND_DEG)
            )
            for axis, tilt in zip(axes, tilts, strict=True)
        ],
        dtype=float,
    )


def _shares(values: FLOAT) -> FLOAT:
    shares: FLOAT = values / values.max()
    return shares
