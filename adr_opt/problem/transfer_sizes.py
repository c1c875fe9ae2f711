"""Discretisation of a mission's transfers, from its duration and its bodies.

The number of connections of a mission grows with the square of its length where transfers drift:
any of its departures may lead to any later time. A grid with a fixed number of steps, whatever the
length, keeps that number, and a step stays in proportion: over two years a day makes no difference.

In missions of weeks legs take days, and then the phase of the target decides what a leg costs. It
comes back after the synodic period of the two orbits, so that steps of a fraction of it meet good
phases, and finer ones little better.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from ..common.constants import DAY_S, OBLATENESS_M2
from ..kernels.orbits import elements
from ..kernels.orbits.ephemeris import EPOCH_S
from .orbit import Orbit
from .settings import TransferSettings

SHORT_S = 14.0 * DAY_S
"""Longest mission without long transfers: planes hardly move against each other in it."""

STEPS = 150
"""Approximate number of steps in the grid of long transfers."""

STEP_ROUNDING_S = 0.5 * DAY_S
"""Unit to which steps are rounded, for readable files."""

PHASE_SHARE = 0.25
"""Steps as a share of the synodic period of two bodies, taken for the median pair."""

LEAST_STEP_S, MOST_PHASE_STEP_S = 0.5 * DAY_S, 2.0 * DAY_S
"""Limits of such steps. A short transfer after a wait saves as much as a drift of hours; and nearly
equal orbits are no reason to leave a chaser waiting for weeks."""

MOST_COMPARED = 500
"""Largest number of bodies whose pairs are all compared."""

UNKNOWN_STEP_S = DAY_S
"""Step where the bodies are unknown."""

MOST_ROUND = 0.0005
"""Largest eccentricity of orbits between which legs are priced by the burns of their sequence."""

SPACING = 0.4
"""Spacing of short departures in steps: several lie between two times of the grid."""

FINEST_M_S = TransferSettings().delta_v_resolution_m_s
COARSEST_M_S, COARSEST_FROM_S = 5.0, 365.0 * DAY_S
"""The resolution grows with the duration of the mission up to here."""


def transfers_for(
    duration_s: float,
    *,
    orbits: Sequence[Orbit] = (),
    departure_spacing_s: float | None = None,
    drift_step_s: float | None = None,
    max_drift_s: float | None = None,
    delta_v_resolution_m_s: float | None = None,
) -> TransferSettings:
    """Transfer settings for a mission under J2, by its duration and its bodies.

    ======================  =====================  ==============================================
    setting                 up to 14 days          longer
    ======================  =====================  ==============================================
    drift step              (of no use)            a 150th of the mission, at least a quarter of
                                                   the phase's period, which counts as half a
                                                   day to two; in half days
    longest drift           0: none                the mission
    departure spacing       0: every crossing      two fifths of the drift step
    resolution              0.1 m/s                5 m/s times the years of the mission, at most
                                                   5 m/s
    ======================  =====================  ==============================================

    Parameters
    ----------
    duration_s : float
        Of the mission [s].
    orbits : sequence of Orbit, optional
        Of all bodies; without them a step is at least a day.
    departure_spacing_s, drift_step_s, max_drift_s, delta_v_resolution_m_s : float, optional
        Instead of these; the spacing follows a step that is given [s], [s], [s], [m/s].

    Raises
    ------
    InputError
        One that is given is out of range.
    """
    chosen: dict[str, float] = {}
    if duration_s > SHORT_S:
        step = default_step_s(duration_s, orbits)
        share = min(1.0, duration_s / COARSEST_FROM_S)
        chosen = {
            "drift_step_s": step,
            "max_drift_s": float(duration_s),
            "departure_spacing_s": round(SPACING * (drift_step_s or step), 3),
            "delta_v_resolution_m_s": max(FINEST_M_S, round(COARSEST_M_S * share, 1)),
        }
    given = {
        "departure_spacing_s": departure_spacing_s,
        "drift_step_s": drift_step_s,
        "max_drift_s": max_drift_s,
        "delta_v_resolution_m_s": delta_v_resolution_m_s,
    }
    chosen |= {name: value for name, value in given.items() if value is not None}
    return TransferSettings().replace(**chosen)


def default_step_s(duration_s: float, orbits: Sequence[Orbit] = ()) -> float:
    """Default step of the grid of drift legs [s].

    Parameters
    ----------
    duration_s : float
        Of the mission [s].
    orbits : sequence of Orbit, optional
        Of all bodies.
    """
    period = phase_period_s(orbits)
    by_phase = UNKNOWN_STEP_S
    if period is not None:
        by_phase = min(max(PHASE_SHARE * period, LEAST_STEP_S), MOST_PHASE_STEP_S)
    return max(_in_half_days(by_phase), _in_half_days(duration_s / STEPS))


def _in_half_days(seconds: float) -> float:
    return STEP_ROUNDING_S * round(seconds / STEP_ROUNDING_S)


def burns_for(orbits: Sequence[Orbit]) -> Literal["sequence", "free"]:
    """Burns that short legs between some orbits are priced by: free ones if any is eccentric."""
    return "free" if any(orbit.eccentricity > MOST_ROUND for orbit in orbits) else "sequence"


def phase_period_s(orbits: Sequence[Orbit]) -> float | None:
    """Synodic period of two bodies, for the median pair: the return of their phase [s].

    Infinite where all orbits are alike, and None of fewer than two.

    Parameters
    ----------
    orbits : sequence of Orbit
    """
    if len(orbits) < 2:
        return None
    rows = np.array([orbit.row(OBLATENESS_M2) for orbit in orbits])
    cosine = np.cos(elements.inclinations(rows, EPOCH_S))
    # The rate of the mean longitude, counted along the plane of the body.
    rates = elements.latitude_rates(rows, EPOCH_S) + cosine * elements.node_rates(rows, EPOCH_S)
    # Of large fields as many, evenly over all rates, as tell the median.
    rates = np.sort(rates)[:: 1 + len(orbits) // MOST_COMPARED]
    first, second = np.triu_indices(rates.size, 1)
    apart = float(np.median(rates[second] - rates[first]))
    return 2.0 * math.pi / apart if apart > 0.0 else math.inf


def told(transfer: TransferSettings) -> str:
    """The discretisation of transfers in words."""
    spacing = transfer.departure_spacing_s
    departures = "every departure"
    if spacing > 0.0:
        departures = f"departures of a pair at least {in_days(spacing)} apart"
    drifts = "no long transfers"
    if transfer.max_drift_s > 0.0:
        drifts = (
            f"long transfers of up to {in_days(transfer.max_drift_s)} in steps of "
            f"{in_days(transfer.drift_step_s)}"
        )
    burns = ", legs by free burns" if transfer.burns == "free" else ""
    return f"{drifts}, {departures}, ΔV to {transfer.delta_v_resolution_m_s:g} m/s{burns}"


def in_days(seconds: float) -> str:
    """A duration in days, in words."""
    days = round(seconds / DAY_S, 3)
    return f"{days:g} day{'' if days == 1.0 else 's'}"
