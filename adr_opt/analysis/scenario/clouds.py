"""Fragments of drawn collisions and explosions, which come down with time (docs/scenarios.md)."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...sources.worth.air import (
    DRAG_COEFFICIENT,
    FLOAT,
    HIGHEST_M,
    LOWEST_M,
    YEAR_S,
    circular_drag_times,
)
from ...sources.worth.breakup import ALTITUDE_STEP_M, KINDS, area_shares, fragment_sizes
from ...sources.worth.pairs import INDICES
from .settings import AltitudeShells

EXPLOSION_FRAGMENTS = 6.0 * 0.1**-1.6
"""Fragments of 10 cm and more of an explosion (Johnson et al., 2001, equation 2)."""


GROUP = 5
"""Bins of area over mass in a ring."""

LEAST_COUNT = 1e-3
"""Number of fragments from which a ring is kept."""


class FragmentCloud(NamedTuple):
    """Fragments of one event.

    Attributes
    ----------
    year : float
        When they were made.
    altitude_m : float
        Where; fragments start on circles there.
    counts : (float, float)
        Of rocket bodies and of spacecraft, as :data:`.breakup.KINDS`.
    tilt : float
        Inclination of the heavier object [rad].
    number : int
        Of the cloud: that of the object that broke up, the lighter of two.
    """

    year: float
    altitude_m: float
    counts: tuple[float, float]
    tilt: float
    number: int


class FragmentRings(NamedTuple):
    """Fragments in orbit as rings of alike ones, those of a cloud together.

    Attributes
    ----------
    radii, tilts : (ring,) float64
        [m], [rad].
    counts, masses : (ring,) float64
        Numbers, and the mass of each [kg].
    clouds : (ring,) int64
        :attr:`FragmentCloud.number`.
    """

    radii: FLOAT
    tilts: FLOAT
    counts: FLOAT
    masses: FLOAT
    clouds: INDICES


@cache
def _falls(activity: str) -> tuple[FLOAT, FLOAT]:
    """Altitudes [m], and the logarithms of drag times of circles there [ln s m²/kg]."""
    count = round((HIGHEST_M - LOWEST_M) / ALTITUDE_STEP_M) + 1
    altitudes = np.linspace(LOWEST_M, HIGHEST_M, count)
    return altitudes, np.log(circular_drag_times(altitudes, activity))


@cache
def _areas(kind: str) -> tuple[FLOAT, FLOAT]:
    return area_shares(kind)


def fragment_area_m2() -> float:
    """Mean cross-section of a fragment (Johnson et al., 2001, equation 8)."""
    return float((0.556945 * fragment_sizes() ** 2.0047077).mean())


def _at(
    cloud: FragmentCloud, kind: str, year: float, activity: str, *, drag: bool
) -> tuple[FLOAT, FLOAT]:
    """Equation 2: altitudes of a cloud's fragments by area over mass [m], and their shares.

    The share of those that are down is 0.
    """
    areas, shares = _areas(kind)
    if not drag:
        return np.full(len(areas), cloud.altitude_m), shares
    altitudes, logs = _falls(activity)
    # Higher fragments count as there.
    whole = np.exp(np.interp(cloud.altitude_m, altitudes, logs))
    gone = DRAG_COEFFICIENT * areas * YEAR_S * (year - cloud.year)
    left = whole - gone
    at_m = np.interp(np.log(np.where(left > 0.0, left, 1.0)), logs, altitudes)
    at_m = np.where(gone > 0.0, at_m, cloud.altitude_m)
    return at_m, np.where(left > 0.0, shares, 0.0)


def fragments_by_shell(
    clouds: list[FragmentCloud], year: float, shells: AltitudeShells, activity: str, *, drag: bool
) -> FLOAT:
    """Numbers of fragments in orbit at a time, shape (shells + 2,).

    Parameters
    ----------
    clouds : list of FragmentCloud
        Made before that time.
    year : float
    shells : AltitudeShells
    activity : str
    drag : bool
    """
    found = np.zeros(shells.count + 2)
    for cloud in clouds:
        for kind, count in zip(KINDS, cloud.counts, strict=True):
            at_m, shares = _at(cloud, kind, year, activity, drag=drag)
            np.add.at(found, shells.numbers(at_m), count * shares)
    return found


def rings_of(
    clouds: list[FragmentCloud], year: float, activity: str, *, drag: bool
) -> FragmentRings:
    """Fragments in orbit at a time, :data:`GROUP` bins of area over mass in a ring."""
    rows: list[tuple[float, float, float, float, int]] = []
    area_m2 = fragment_area_m2()
    for cloud in clouds:
        for kind, count in zip(KINDS, cloud.counts, strict=True):
            at_m, shares = _at(cloud, kind, year, activity, drag=drag)
            masses = area_m2 / _areas(kind)[0]
            for first in range(0, len(shares), GROUP):
                some = shares[first : first + GROUP]
                number = count * some.sum()
                if number > LEAST_COUNT:
                    part = some / some.sum()
                    radius = EARTH_RADIUS_M + float(at_m[first : first + GROUP] @ part)
                    mass = float(masses[first : first + GROUP] @ part)
                    rows.append((radius, cloud.tilt, float(number), mass, cloud.number))
    radii, tilts, counts, ring_masses = np.array([row[:4] for row in rows]).reshape(-1, 4).T.copy()
    numbers = np.array([row[4] for row in rows], dtype=np.int64)
    return FragmentRings(radii, tilts, counts, ring_masses, numbers)
