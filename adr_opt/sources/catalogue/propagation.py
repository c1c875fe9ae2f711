"""Mean elements propagated to an epoch by SGP4, and its states.

What a two-body planner should start from are the singly averaged elements that SGP4 carries to the
epoch by its secular rates (zonal harmonics and drag), not the osculating ones: those wiggle by some
ten kilometres in the semi-major axis within each revolution, which two-body motion would turn into
a drift of the phase by degrees a day.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2, OBLATENESS_M2
from ...common.errors import MissingExtra
from ...common.records import LARGEST_LENGTH_M
from .records import Dropped, ElementSet

ELEMENTS = (
    "semi_major_axis_m",
    "eccentricity",
    "inclination",
    "raan",
    "argument_of_perigee",
    "mean_anomaly",
)
"""Columns of mean elements; angles in radians."""

LARGEST_DAYS = 3653.0
"""Largest distance of elements from the epoch; beyond it they are not propagated."""

LARGEST_RISE = 1.1
"""Largest growth of a semi-major axis; beyond it, SGP4's drag polynomial has diverged."""

J1950 = 2433281.5
"""Julian date from which SGP4 counts days."""

FLOAT = npt.NDArray[np.float64]


def mean_elements(records: Sequence[ElementSet], epoch: datetime) -> tuple[FLOAT, list[Dropped]]:
    """Mean elements of every record at an epoch, by SGP4.

    Parameters
    ----------
    records : sequence of ElementSet
    epoch : datetime
        With its time zone.

    Returns
    -------
    elements : (record, element) float64
        Columns :data:`ELEMENTS`, TEME, Brouwer mean elements [m, rad]; a row of NaN where SGP4
        fails.
    failed : list of Dropped
        One for each such row, in the order of the records.

    Raises
    ------
    MissingExtra
        sgp4 is not installed.
    """
    api = _sgp4()
    elements = np.full((len(records), len(ELEMENTS)), np.nan)
    failed = []
    for row, record in enumerate(records):
        why = _unfit(record, epoch)
        if why is None:
            satellite = satellite_of(record)
            minutes = (epoch - record.epoch).total_seconds() / 60.0
            # No SatrecArray here: it works on copies, which keep the mean elements to themselves.
            for part in _on_the_way(minutes):
                code, position, velocity = satellite.sgp4_tsince(part)
                elements[row] = _mean(satellite)
                why = _failure(code, (*position, *velocity, *elements[row]), api.SGP4_ERRORS)
                if why is not None:
                    break
            if why is None and elements[row, 0] > LARGEST_LENGTH_M:
                why = "sgp4-error", f"its semi-major axis is above {LARGEST_LENGTH_M:g} m"
            if why is None and elements[row, 0] > LARGEST_RISE * satellite.a * EARTH_RADIUS_M:
                why = "sgp4-error", "SGP4 makes the orbit far larger, as it does after a decay"
        if why is None and elements[row, 0] * (1.0 - elements[row, 1]) <= EARTH_RADIUS_M:
            why = "decayed", "the perigee at the epoch is under the ground"
        if why is not None:
            elements[row] = np.nan
            failed.append(Dropped.of(record, *why))
    return elements, failed


def _on_the_way(minutes: float) -> list[float]:
    """Intermediate times for SGP4 up to an epoch, inclusive.

    Drag is a polynomial of degree four in SGP4. It takes a decaying orbit through the ground, with
    errors, and long after that out again, without. Between the two there is a factor of 2.8 in
    time, so that the orbit is met under the ground by halving.
    """
    parts = [minutes]
    while abs(parts[-1]) > 60.0:
        parts.append(0.5 * parts[-1])
    return parts[::-1]


def satellite_of(record: ElementSet) -> Any:
    """The `sgp4.api.Satrec` of a record, with the published WGS-72 constants.

    Raises
    ------
    MissingExtra
        sgp4 is not installed.
    """
    api = _sgp4()
    radians, revolution = math.pi / 180.0, 2.0 * math.pi
    epoch = record.epoch.astimezone(UTC)
    seconds = epoch.second + 1e-6 * epoch.microsecond
    day, fraction = api.jday(*epoch.timetuple()[:5], seconds)
    satellite = api.Satrec()
    satellite.sgp4init(
        api.WGS72,
        "i",
        0,  # SGP4 has no use for the number, and its type no room for nine digits
        # In this order, as where the published states come from: the sum keeps 40 µs, and the
        # last digits of some lunar terms depend on which.
        day + fraction - J1950,
        record.bstar,
        record.mean_motion_dot_rev_day2 * revolution / 1440.0**2,
        record.mean_motion_ddot_rev_day3 * revolution / 1440.0**3,
        record.eccentricity,
        record.argument_of_perigee_deg * radians,
        record.inclination_deg * radians,
        record.mean_anomaly_deg * radians,
        record.mean_motion_rev_day / (1440.0 / revolution),
        record.raan_deg * radians,
    )
    return satellite


def state(record: ElementSet, minutes: float) -> tuple[FLOAT, FLOAT]:
    """Osculating position and velocity in TEME, minutes after the epoch of the elements.

    Returns
    -------
    position, velocity : (3,) float64
        [km], [km/s], the units of SGP4.

    Raises
    ------
    ArithmeticError
        SGP4 gives an error; its message is in it.
    MissingExtra
        sgp4 is not installed.
    """
    api = _sgp4()
    code, position, velocity = satellite_of(record).sgp4_tsince(minutes)
    why = _failure(code, (*position, *velocity), api.SGP4_ERRORS)
    if why is not None:
        raise ArithmeticError(f"{record.label}: {why[1]}")
    return np.array(position), np.array(velocity)


def true_anomaly(mean_anomaly: FLOAT, eccentricity: FLOAT) -> FLOAT:
    """True anomaly by Kepler's equation, element by element [rad]."""
    mean = np.remainder(mean_anomaly + np.pi, 2.0 * np.pi) - np.pi
    # From π (with the sign of M) Newton's method converges for every eccentricity below 1.
    anomaly = np.where(eccentricity < 0.8, mean, np.copysign(np.pi, mean))
    for _ in range(50):
        step = (anomaly - eccentricity * np.sin(anomaly) - mean) / (
            1.0 - eccentricity * np.cos(anomaly)
        )
        anomaly = anomaly - step
        if np.all(np.abs(step) < 1e-14):
            break
    half = np.sqrt((1.0 + eccentricity) / (1.0 - eccentricity)) * np.tan(0.5 * anomaly)
    true: FLOAT = 2.0 * np.arctan(half)
    return true


def _unfit(record: ElementSet, epoch: datetime) -> tuple[str, str] | None:
    if record.not_sgp4:
        return "not-sgp4", record.not_sgp4
    if record.is_down(epoch):
        return "decayed", f"decayed on {record.decays:%Y-%m-%d}, according to the file"
    days = (epoch - record.epoch).total_seconds() / DAY_S
    if abs(days) > LARGEST_DAYS:
        return "far-epoch", f"its elements are {abs(days):.0f} days from the epoch"
    return None


def _failure(
    code: int, numbers: tuple[float, ...], errors: dict[int, str]
) -> tuple[str, str] | None:
    """Reason for rejecting a result of SGP4, from its error code."""
    if code == 6:
        return "decayed", f"SGP4 error 6: {errors[6]}"
    if code:
        return "sgp4-error", f"SGP4 error {code}: {errors.get(code, 'unknown')}"
    if not all(map(math.isfinite, numbers)):
        return "sgp4-error", "SGP4 returns no finite state"
    return None


def _mean(satellite: Any) -> tuple[float, ...]:
    inclination, raan, perigee = satellite.im, satellite.Om, satellite.om
    if inclination < 0.0:  # the secular rates of deep space may carry it through zero
        inclination, raan, perigee = -inclination, raan + math.pi, perigee - math.pi
    return (
        satellite.am * satellite.radiusearthkm * 1e3,
        satellite.em,
        inclination,
        math.fmod(raan, 2.0 * math.pi),
        math.fmod(perigee, 2.0 * math.pi),
        satellite.mm,
    )


def _sgp4() -> Any:
    try:
        from sgp4 import api
    except ImportError:
        raise MissingExtra("propagating a catalogue", "sgp4", "astro") from None
    return api


@dataclass(frozen=True)
class Overview:
    """Orbits of objects as columns, in the order of the records.

    Attributes
    ----------
    epoch : datetime
        The latest of the elements.
    altitude_km : (object,) float64
        Of the semi-major axis, the mean of perigee and apogee, above 6378.137 km.
    eccentricity, inclination_deg : (object,) float64
    raan_deg : (object,) float64
        At the epoch, 0 to 360.
    """

    epoch: datetime
    altitude_km: FLOAT
    eccentricity: FLOAT
    inclination_deg: FLOAT
    raan_deg: FLOAT


def overview(records: Sequence[ElementSet]) -> Overview:
    """Orbits of all objects, whose nodes turn to one epoch at the secular rate of J2.

    What :func:`.assemble.to_instance` takes from SGP4 for a few objects is within a kilometre and,
    for elements of the same week, a tenth of a degree of this for most, which takes no time.

    Parameters
    ----------
    records : sequence of ElementSet
        At least one.
    """
    epoch = max(record.epoch for record in records)
    columns = np.array(
        [
            (
                record.mean_motion_rev_day,
                record.eccentricity,
                record.inclination_deg,
                record.raan_deg,
                (epoch - record.epoch).total_seconds(),
            )
            for record in records
        ]
    )
    motion, eccentricity, inclination_deg, raan_deg, elapsed_s = columns.T
    rate = motion * 2.0 * np.pi / DAY_S
    axis = np.cbrt(MU_M3_S2 / rate**2)
    parameter = axis * (1.0 - eccentricity**2)
    turning = -1.5 * OBLATENESS_M2 / parameter**2 * rate * np.cos(np.radians(inclination_deg))
    return Overview(
        epoch=epoch,
        altitude_km=(axis - EARTH_RADIUS_M) / 1e3,
        eccentricity=eccentricity,
        inclination_deg=inclination_deg,
        raan_deg=np.remainder(raan_deg + np.degrees(turning * elapsed_s), 360.0),
    )
