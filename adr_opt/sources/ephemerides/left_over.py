"""Residuals of a fit between planned states and an ephemeris, and their likely cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S, MU_M3_S2, OBLATENESS_M2
from ...kernels.orbits import elements
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import osculating
from ...problem.orbit import Fit, Orbit
from .ephemeris import Array, Ephemeris
from .fit import FittedOrbit, sample_times

LEG_S = DAY_S
"""Duration of the leg for which a ΔV is estimated [s]."""


class LeftOver(NamedTuple):
    """Residuals of the fit of one body.

    Attributes
    ----------
    body : str
    epoch_m : float
        Distance at the epoch.
    along_m, across_m : float
        Largest distances along the track and across it during the mission.
    leg_m_s : float
        ΔV that they may add to a leg of a day to the body: the turn by the distance across, and
        the drift along the track within the leg.
    """

    body: str
    epoch_m: float
    along_m: float
    across_m: float
    leg_m_s: float


def planned_states(
    orbit: Orbit, decay_m_per_day: float, fit: Fit | None, times_s: npt.ArrayLike
) -> Array:
    """States of a body by its fitted elements, short periods of J2 included, shape (times, 6).

    Parameters
    ----------
    orbit : Orbit
    decay_m_per_day : float
    fit : Fit or None
    times_s : (times,) array_like
        Since the epoch [s].
    """
    row = np.array(orbit.row(OBLATENESS_M2, decay_m_per_day))
    offset = (0.0, 0.0) if fit is None else fit.eccentricity_offset
    found = []
    for time in np.atleast_1d(np.asarray(times_s, dtype=np.float64)):
        mean, plane = elements.equinoctial_at(row, float(time))
        mean[1:3] += offset
        found.append(osculating(mean, plane, FIELDS["j2"]))
    return np.array(found)


def left_over(ephemeris: Ephemeris, made: FittedOrbit, duration_s: float) -> LeftOver:
    """Residuals of the fit of a body over a mission."""
    times = sample_times(duration_s)
    true = ephemeris.state(times)
    planned = planned_states(made.orbit, made.decay_m_per_day, made.fit, times)
    position, velocity = true[:, :3], true[:, 3:]
    radius = np.linalg.norm(position, axis=1)
    outward = position / radius[:, None]
    normal = np.cross(position, velocity)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    ahead = np.cross(normal, outward)
    there = planned[:, :3]
    upward, forward = np.sum(there * outward, axis=1), np.sum(there * ahead, axis=1)
    along = float((radius * np.abs(np.arctan2(forward, upward))).max())
    across = float(np.abs(np.sum(there * normal, axis=1)).max())
    speed = math.sqrt(MU_M3_S2 / made.orbit.semi_major_axis_m)
    turn = speed * across / made.orbit.semi_major_axis_m
    return LeftOver(
        ephemeris.body,
        float(np.linalg.norm(there[0] - position[0])),
        along,
        across,
        turn + 2.0 / 3.0 * along / LEG_S,
    )


def summary(found: Sequence[LeftOver]) -> dict[str, Any]:
    """Medians over bodies and worst values, as JSON data; empty without bodies."""
    said: dict[str, Any] = {"bodies": len(found)}
    for field in LeftOver._fields[1:] if found else ():
        values = [getattr(one, field) for one in found]
        worst = int(np.argmax(values))
        said[field] = {
            "median": float(np.median(values)),
            "most": values[worst],
            "of": found[worst].body,
        }
    return said


def told(found: Sequence[LeftOver]) -> str:
    """A sentence on the residuals."""
    middle = [float(np.median([one[at] for one in found])) for at in range(1, 5)]
    worst = max(found, key=lambda one: one.along_m)
    return (
        f"mean elements fitted to the ephemerides leave {middle[0] / 1e3:.2f} km at the epoch, "
        f"{middle[1] / 1e3:.1f} km along the track, {middle[2] / 1e3:.2f} km across and "
        f"{middle[3]:.1f} m/s a leg (medians over {len(found)} bodies; the most along the track, "
        f"{worst.along_m / 1e3:,.1f} km, of {worst.body})"
    )
