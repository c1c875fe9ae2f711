"""Drag during a mission: objects that re-enter, and along-track displacement."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any

import numpy as np

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...common.wording import counted
from .propagation import FLOAT, satellite_of
from .records import ElementSet

LEFT_OUT = "drag, which plans leave out, "
"""Beginning of the warning about drag."""

MOST_KM = 100.0
"""Along-track displacement that causes a warning [km]."""

DECAYS = math.inf
"""Value that stands for the displacement of an object that decays within the mission."""

SHARES = np.linspace(0.0, 1.0, 9)
"""Shares of the mission at which the mean motion is sampled."""

DEEP_SPACE = "d"
"""SGP4's code of the method for periods of 225 minutes and more."""

LEAST_RADIUS = 1.0
"""Semi-major axis below which an orbit has decayed [Earth radii]."""


def along_track_km(record: ElementSet, epoch: datetime, duration_s: float) -> float:
    """Along-track displacement of an object by drag since the epoch [km].

    The mean motion of the instance is that of the epoch and stays. What drag adds to it afterwards
    is worked out twice: by SGP4, from B*, and from the derivatives of the mean motion that the file
    states; the larger one counts. They are two fits to the same past, and no forecast.

    Returns
    -------
    float
        Ahead is positive; :data:`DECAYS` if SGP4 has it come down.
    """
    by_bstar = _by_bstar(record, epoch, duration_s)
    if by_bstar is None:
        return DECAYS
    return max(by_bstar, _by_derivatives(record, epoch, duration_s), key=abs)


def drag_warning(records: Sequence[ElementSet], epoch: datetime, duration_s: float) -> str | None:
    """A sentence on the objects most displaced by drag; None if none is."""
    moved = [along_track_km(record, epoch, duration_s) for record in records]
    far = [abs(one) > MOST_KM for one in moved]
    if not any(far):
        return None
    worst = max(range(len(moved)), key=lambda row: abs(moved[row]))
    said = f"{records[worst].label} by {abs(moved[worst]):,.0f} km"
    if moved[worst] == DECAYS:
        down = sum(one == DECAYS for one in moved)
        more = f", and so {'does' if down == 2 else 'do'} {down - 1} more" if down > 1 else ""
        said = f"{records[worst].label} comes down before its end{more}"
    return (
        f"{LEFT_OUT}moves {sum(far)} of {counted(len(records), 'object')} more "
        f"than {MOST_KM:g} km along the track within the {duration_s / DAY_S:.4g} days of the "
        "mission, by their B* or the derivative of their mean motion; " + said
    )


def _by_bstar(record: ElementSet, epoch: datetime, duration_s: float) -> float | None:
    """Displacement by B* in SGP4 [km]; None if the object decays meanwhile."""
    from scipy.integrate import simpson

    times = (epoch - record.epoch).total_seconds() + duration_s * SHARES
    axes = _axes(record, times)
    if axes is None:
        return None
    # Of the axes and not of the anomaly, which is known only up to whole turns.
    gained = axes**-1.5 - axes[0] ** -1.5
    satellite = satellite_of(record)
    if satellite.method == DEEP_SPACE:
        # High up the Moon and the Sun move the axis, too.
        without = _axes(replace(record, bstar=0.0), times)
        gained -= 0.0 if without is None else without**-1.5 - without[0] ** -1.5
    turned = duration_s / (len(times) - 1) * float(simpson(satellite.xke / 60.0 * gained))
    return turned * float(axes[0] * satellite.radiusearthkm)


def _axes(record: ElementSet, times_s: FLOAT) -> FLOAT | None:
    """Semi-major axes at times after the epoch of the elements [Earth radii]."""
    satellite, axes = satellite_of(record), []
    for time_s in times_s:
        code, *_ = satellite.sgp4_tsince(float(time_s) / 60.0)
        if code or not satellite.am > LEAST_RADIUS:
            return None
        axes.append(satellite.am)
    return np.array(axes)


def _by_derivatives(record: ElementSet, epoch: datetime, duration_s: float) -> float:
    """Displacement by the derivatives of the mean motion [km]."""
    start, days = (epoch - record.epoch).total_seconds() / DAY_S, duration_s / DAY_S
    turns = record.mean_motion_dot_rev_day2 * days**2
    turns += record.mean_motion_ddot_rev_day3 * days**2 * (3.0 * start + days)
    satellite = satellite_of(record)
    return float(2.0 * math.pi * turns * satellite.a * satellite.radiusearthkm)


def end_windows(
    fields: Mapping[int, Mapping[str, Any]],
    targets: Sequence[ElementSet],
    host: ElementSet | None,
    epoch: datetime,
    duration_s: float,
) -> tuple[dict[int, dict[str, Any]], str | None]:
    """Windows of targets that come down within a mission end when they do.

    Parameters
    ----------
    fields : mapping of int to mapping
        Fields of targets by their numbers.
    targets : sequence of ElementSet
        In orbit at the epoch.
    host : ElementSet or None
        The station, if it is an object.
    epoch : datetime
        Of the instance.
    duration_s : float
        Of the mission.

    Returns
    -------
    fields : dict
        With such windows.
    said : str or None
        A sentence about them, if there are any.

    Raises
    ------
    InputError
        The station comes down within the mission, or a target before its window opens.
    """
    if host is not None and _down_s(host, epoch) < duration_s:
        raise InputError(
            f"--station {host.label}: comes down on {host.decays:%Y-%m-%d}, within the mission; "
            "give another one, or a shorter mission"
        )
    ended = {number: dict(its) for number, its in fields.items()}
    falling = [n for n, record in enumerate(targets) if _down_s(record, epoch) < duration_s]
    for number in falling:
        record, its = targets[number], ended.setdefault(number, {})
        opens, closes = its.get("window_s", (0.0, None))
        closes = min(_down_s(record, epoch), math.inf if closes is None else closes)
        if opens >= closes:
            raise InputError(
                f"{record.label}: comes down on {record.decays:%Y-%m-%d}, before its window opens; "
                "leave it out with --exclude"
            )
        its["window_s"] = (opens, closes)
    if not falling:
        return ended, None
    first = min((targets[number] for number in falling), key=lambda record: _down_s(record, epoch))
    return ended, (
        f"{counted(len(falling), 'target comes', 'targets come')} down within the mission, says "
        f"the file, and can be serviced until then; the first is {first.label}, on "
        f"{first.decays:%Y-%m-%d}"
    )


def _down_s(record: ElementSet, epoch: datetime) -> float:
    """Time of an object's re-entry after the epoch [s]; +inf if the file states none."""
    return math.inf if record.decays is None else (record.decays - epoch).total_seconds()
