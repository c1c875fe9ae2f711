"""Fragments of a collision by the NASA standard breakup model (docs/worth.md, equations 4 to 7).

N. L. Johnson, P. H. Krisko, J.-C. Liou, P. D. Anz-Meador, "NASA's new breakup model of EVOLVE 4.0",
Advances in Space Research 28, 2001, 1377-1384.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr

from ...problem.air import DRAG_COEFFICIENT, FLOAT, HIGHEST_M, LOWEST_M, YEAR_S, circular_drag_times

LEAST_SIZE_M = 0.1
"""Characteristic length above which fragments count [m]."""

FRAGMENTS = 0.1 * LEAST_SIZE_M**-1.71
"""Number of fragments of an effective mass of 1 kg, which grows with its power 0.75."""

CATASTROPHIC_J_KG = 40e3
"""Energy of the projectile per mass of the target above which both break up completely [J/kg]."""

SIZE_EXPONENT, LARGEST_SIZE_M, SIZES = 1.71, 1.0, 12
"""Cumulative distribution of sizes, the size where it is cut off, and quantiles of it."""

LOG_AREAS = np.linspace(-4.0, 1.5, 111)
"""Bins of the decadic logarithm of area over mass [m²/kg]."""

ALTITUDE_STEP_M = 10e3

EXPOSURES = 41
"""Number of durations for which the fragment-years are tabulated."""


def _ramp(value: FLOAT, first: tuple[float, float], last: tuple[float, float]) -> FLOAT:
    """Linear between two points, constant outside."""
    ramp: FLOAT = np.interp(value, (first[0], last[0]), (first[1], last[1]))
    return ramp


def _rocket_body(size: FLOAT) -> tuple[FLOAT, ...]:
    """Share, means and deviations of the two normal distributions, by the logarithm of the size."""
    return (
        _ramp(size, (-1.4, 1.0), (0.0, 0.5)),
        _ramp(size, (-0.5, -0.45), (0.0, -0.9)),
        np.full_like(size, 0.55),
        np.full_like(size, -0.9),
        _ramp(size, (-1.0, 0.28), (0.1, 0.1)),
    )


def _spacecraft(size: FLOAT) -> tuple[FLOAT, ...]:
    """The same parameters as :func:`_rocket_body`, for fragments of spacecraft."""
    return (
        _ramp(size, (-1.95, 0.0), (0.55, 1.0)),
        _ramp(size, (-1.1, -0.6), (0.0, -0.95)),
        _ramp(size, (-1.3, 0.1), (-0.3, 0.3)),
        _ramp(size, (-0.7, -1.2), (-0.1, -2.0)),
        _ramp(size, (-0.5, 0.5), (-0.3, 0.3)),
    )


KINDS = {"rocket body": _rocket_body, "spacecraft": _spacecraft}
"""Origins of fragments, in the order of the tables."""


def fragment_sizes() -> FLOAT:
    """Characteristic lengths of fragments [m], of equal shares."""
    part = (np.arange(SIZES) + 0.5) / SIZES
    least = (LARGEST_SIZE_M / LEAST_SIZE_M) ** -SIZE_EXPONENT
    sizes: FLOAT = LEAST_SIZE_M * (1.0 - part * (1.0 - least)) ** (-1.0 / SIZE_EXPONENT)
    return sizes


def area_shares(kind: str) -> tuple[FLOAT, FLOAT]:
    """Areas over mass of fragments [m²/kg] and the share of each.

    Parameters
    ----------
    kind : str
        One of :data:`KINDS`.
    """
    sizes = np.log10(fragment_sizes())
    share, mean, spread, other_mean, other_spread = (row[:, None] for row in KINDS[kind](sizes))
    below = share * ndtr((LOG_AREAS - mean) / spread)
    below += (1.0 - share) * ndtr((LOG_AREAS - other_mean) / other_spread)
    shares: FLOAT = np.diff(below, axis=1).mean(axis=0)
    return 10.0 ** (0.5 * (LOG_AREAS[1:] + LOG_AREAS[:-1])), shares / shares.sum()


def fragment_years(years: float, activity: str, since_years: float = 0.0) -> tuple[FLOAT, float]:
    """Equation 7: fragment-years within the horizon, per fragment made once a year.

    Parameters
    ----------
    years : float
        Horizon.
    activity : str
        Solar activity, one of :data:`.air.ACTIVITIES`.
    since_years : float
        Collisions before this time do not count.

    Returns
    -------
    (kind, altitude, exposure) float64
        Kinds of :data:`KINDS`; altitudes from :data:`.lifetimes.LOWEST_M`, each
        :data:`ALTITUDE_STEP_M` above the last; :data:`EXPOSURES` durations from 0 to the horizon in
        which collisions happen [years²].
    """
    count = round((HIGHEST_M - LOWEST_M) / ALTITUDE_STEP_M) + 1
    times = circular_drag_times(np.linspace(LOWEST_M, HIGHEST_M, count), activity)
    exposures = np.linspace(0.0, years, EXPOSURES)
    table = np.empty((len(KINDS), count, EXPOSURES))
    for row, kind in enumerate(KINDS):
        areas, shares = area_shares(kind)
        lives = times[:, None] / (DRAG_COEFFICIENT * areas * YEAR_S)
        for column, exposure in enumerate(exposures):
            later = _within(lives, max(exposure, since_years), years)
            table[row, :, column] = (later - _within(lives, since_years, years)) @ shares
    return table, exposures[1]


def _within(lives: FLOAT, exposure: float, years: float) -> FLOAT:
    """Integral over times of collisions from 0 to the exposure of min(life, years − time)."""
    whole = np.clip(years - lives, 0.0, exposure)
    rest = exposure - whole
    cut: FLOAT = rest * (years - 0.5 * (whole + exposure))
    return lives * whole + cut
