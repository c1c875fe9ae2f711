"""Fragments of drawn collisions and explosions, which come down with time (docs/scenarios.md)."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from ...sources.worth.air import FLOAT
from ...sources.worth.breakup import ALTITUDE_STEP_M, KINDS, area_shares
from ...sources.worth.lifetimes import (
    DRAG_COEFFICIENT,
    HIGHEST_M,
    LOWEST_M,
    YEAR_S,
    circular_drag_times,
)
from .settings import AltitudeShells

EXPLOSION_FRAGMENTS = 6.0 * 0.1**-1.6
"""Fragments of 10 cm and more of an explosion (Johnson et al., 2001, equation 2)."""


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
    """

    year: float
    altitude_m: float
    counts: tuple[float, float]


@cache
def _falls(activity: str) -> tuple[FLOAT, FLOAT]:
    """Altitudes [m], and the logarithms of drag times of circles there [ln s m²/kg]."""
    count = round((HIGHEST_M - LOWEST_M) / ALTITUDE_STEP_M) + 1
    altitudes = np.linspace(LOWEST_M, HIGHEST_M, count)
    return altitudes, np.log(circular_drag_times(altitudes, activity))


@cache
def _areas(kind: str) -> tuple[FLOAT, FLOAT]:
    return area_shares(kind)


def fragments_by_shell(
    clouds: list[FragmentCloud], year: float, shells: AltitudeShells, activity: str, *, drag: bool
) -> FLOAT:
    """Numbers of fragments in orbit at a time, shape (shells + 2,).

    A fragment on a circle comes down by the time that drag takes from its altitude: after a while
    it is where the rest of that time is left.

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
    altitudes, logs = _falls(activity)
    for cloud in clouds:
        # Higher fragments count as there.
        whole = np.exp(np.interp(cloud.altitude_m, altitudes, logs))
        for kind, count in zip(KINDS, cloud.counts, strict=True):
            areas, shares = _areas(kind)
            gone = DRAG_COEFFICIENT * areas * YEAR_S * (year - cloud.year) if drag else 0.0 * areas
            left = whole - gone
            up = left > 0.0
            at_m = np.where(
                gone > 0.0,
                np.interp(np.log(np.where(up, left, 1.0)), logs, altitudes),
                cloud.altitude_m,
            )
            np.add.at(found, shells.numbers(at_m[up]), count * shares[up])
    return found
