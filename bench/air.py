"""Table of the air's density in `adr_opt/sources/worth/air.py`, from NRLMSIS 2.1.

    pip install pymsis
    python bench/air.py

Densities are means over latitudes, longitudes, hours and seasons. Low and high activity are a
constant F10.7 of 70 and 200; mean activity is the mean density of a cycle in which F10.7 swings
between both as a cosine.
"""

from __future__ import annotations

import numpy as np
from machine import heading

from adr_opt.sources.worth.air import ALTITUDES_KM, DENSITIES_KG_M3

LOW, HIGH = 70.0, 200.0

PHASES = np.pi * (np.arange(8) + 0.5) / 8
CYCLE = 0.5 * (LOW + HIGH) - 0.5 * (HIGH - LOW) * np.cos(PHASES)

LATITUDES = np.arange(-75.0, 76.0, 30.0)
LONGITUDES = np.arange(0.0, 360.0, 90.0)
TIMES = np.array(
    [
        np.datetime64(f"2001-{month:02d}-15T{hour:02d}:00")
        for month in (1, 4, 7, 10)
        for hour in (0, 6, 12, 18)
    ]
)


def densities(flux: float) -> np.ndarray:
    """Mean densities at the altitudes of the table, at a constant F10.7 [kg/m³]."""
    import pymsis

    constant = np.full(len(TIMES), flux)
    air = pymsis.calculate(
        TIMES,
        LONGITUDES,
        LATITUDES,
        np.array(ALTITUDES_KM, dtype=float),
        constant,
        constant,
        np.full((len(TIMES), 7), 10.0),
    )[..., 0]
    weights = np.cos(np.radians(LATITUDES))
    means: np.ndarray = np.average(air.mean(axis=(0, 1)), axis=0, weights=weights)
    return means


def main() -> None:
    """Print the densities, and how far those of the table are from them."""
    print(heading())
    found = {
        "low": densities(LOW),
        "mean": np.mean([densities(flux) for flux in CYCLE], axis=0),
        "high": densities(HIGH),
    }
    for activity, made in found.items():
        off = np.abs(np.array(DENSITIES_KG_M3[activity]) / made - 1.0).max()
        print(f"\n{activity}, table within {off:.2%}\n")
        print(", ".join(f"{density:.4g}" for density in made))


if __name__ == "__main__":
    main()
