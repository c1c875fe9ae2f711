"""Bodies as the kernels take them, made by hand: rows of ORBIT_COLUMNS, and rules of transfers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.kernels.legs import co_elliptic
from adr_opt.kernels.orbits import columns
from adr_opt.kernels.orbits.ephemeris import body_row
from adr_opt.problem.approach import approach_of
from adr_opt.problem.settings import TransferSettings

FloatArray = npt.NDArray[np.float64]

LOWEST_M, HIGHEST_M = EARTH_RADIUS_M + 300e3, EARTH_RADIUS_M + 2000e3
"""Altitude limits of rules made here, as radii."""


def row(
    radius: float,
    inclination: float,
    raan: float,
    latitude: float,
    *,
    oblateness: float = 0.0,
    eccentricity: float = 0.0,
    perigee: float = 0.0,
) -> FloatArray:
    """A body: metres and radians, with the rates that it has at an oblateness J2 R² [m²]."""
    return np.array(
        body_row(
            radius,
            inclination,
            raan,
            latitude,
            eccentricity=eccentricity,
            perigee=perigee,
            oblateness_m2=oblateness,
        )
    )


def drawn_body(
    rng: np.random.Generator,
    inclination: float,
    raan: float,
    altitudes_m: tuple[float, float] = (320e3, 1950e3),
    most_eccentricity: float = 0.02,
) -> FloatArray:
    """A body between two altitudes under J2, every other one eccentric."""
    return row(
        EARTH_RADIUS_M + rng.uniform(*altitudes_m),
        inclination,
        raan,
        rng.uniform(0.0, 7.0),
        oblateness=OBLATENESS_M2,
        eccentricity=float(rng.choice([0.0, rng.uniform(0.0, most_eccentricity)])),
        perigee=rng.uniform(-10.0, 10.0),
    )


def changed(
    orbit: FloatArray,
    *,
    radius: float = 0.0,
    inclination: float = 0.0,
    raan: float = 0.0,
    latitude: float = 0.0,
    oblateness: float = 0.0,
) -> FloatArray:
    """A body near another one; the inclination stays between 0 and π."""
    return row(
        orbit[columns.RADIUS] + radius,
        min(math.pi, max(0.0, orbit[columns.INCLINATION] + inclination)),
        orbit[columns.RAAN] + raan,
        orbit[columns.ARGUMENT_OF_LATITUDE] + latitude,
        oblateness=oblateness,
        eccentricity=orbit[columns.ECCENTRICITY],
        perigee=orbit[columns.PERIGEE],
    )


def rule(
    *,
    oblateness: float = 0.0,
    zones: Iterable[Sequence[float]] = (),
    time_value_m_s_per_h: float = 75.0,
    k_max: int = 12,
    fraction: float = 0.75,
    standoff: float = 1000.0,
    limits: tuple[float, float] = (LOWEST_M, HIGHEST_M),
    ellipse: bool = False,
) -> co_elliptic.TransferRule:
    """The usual rule of transfers but for what is stated."""
    settings = TransferSettings(standoff_m=standoff)
    approach = approach_of(settings.replace(approach="safety-ellipse") if ellipse else settings)
    return co_elliptic.TransferRule(
        fraction,
        standoff,
        approach.revolutions,
        k_max,
        *limits,
        time_value_m_s_per_h / 3600.0,
        np.array(list(zones), dtype=float).reshape(-1, 4),
        oblateness,
        approach.length_m,
        approach.burns,
    )


def oblate_rule(**stated: float) -> co_elliptic.TransferRule:
    """That of the Earth as it is."""
    return rule(oblateness=OBLATENESS_M2, **stated)  # type: ignore[arg-type]
