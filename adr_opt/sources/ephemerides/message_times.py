"""Times of messages as seconds since the epoch of an instance, by the library of the IAU."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np

from ...common.constants import DAY_S
from ...common.errors import InputError, MissingExtra
from ..catalogue.records import shown
from .ephemeris import Array

SYSTEMS = ("UTC", "TAI", "TT", "GPS")
"""Supported time systems."""

AHEAD_OF_TAI_S = {"TAI": 0.0, "TT": 32.184, "GPS": -19.0}
"""Lead of clocks over TAI [s]."""

OF_YEAR = re.compile(r"(\d{4})-(\d{3})T(.*)", re.ASCII)
CALENDAR = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d{1,30})?", re.ASCII)

DAY_0 = np.datetime64("1858-11-17")
"""Day 0 of the modified Julian date."""

MODIFIED_0 = 2400000.5
"""Julian date at which the modified Julian date begins."""


def seconds_since(epoch: datetime, labels: Sequence[str], system: str, where: str) -> Array:
    """Times of a message since an epoch, in days of 86,400 s of UTC.

    Parameters
    ----------
    epoch : datetime
    labels : sequence of str
        Like 2026-01-01T00:00:00.000 or 2026-001T00:00:00.000.
    system : str
        One of :data:`SYSTEMS`.
    where : str
        Place in a file, for messages.

    Raises
    ------
    InputError
        Another time system, or no such time.
    MissingExtra
        The time system is not UTC, and astropy is not installed.
    """
    if system not in SYSTEMS:
        raise InputError(
            f"{where}: TIME_SYSTEM = {shown(system)}: must be one of {', '.join(SYSTEMS)}"
        )
    days, seconds = _parsed(labels, where)
    since = epoch.astimezone(UTC).replace(tzinfo=None)
    midnight = np.datetime64(since.date())
    in_day_s = (since - datetime.combine(since.date(), datetime.min.time())) / timedelta(seconds=1)
    ahead = (days - (midnight - DAY_0).astype(np.int64)) * DAY_S
    if system != "UTC":
        seconds = seconds - _ahead_of_utc(days, seconds, AHEAD_OF_TAI_S[system])
    found: Array = ahead + (seconds - in_day_s)
    return found


def _ahead_of_utc(days: Any, seconds: Array, ahead_of_tai_s: float) -> Array:
    """Lead of a clock over UTC at times of that clock [s]."""
    try:
        import erfa
    except ImportError:
        raise MissingExtra("reading times that are not in UTC", "astropy", "astro") from None
    with warnings.catch_warnings():
        # Of years for which no leap seconds are announced.
        warnings.simplefilter("ignore")
        atomic = (seconds - ahead_of_tai_s) / DAY_S
        date, fraction = erfa.taiutc(MODIFIED_0 + days, atomic)
    ahead: Array = np.rint(((MODIFIED_0 + days - date) + (atomic - fraction)) * DAY_S)
    return ahead + ahead_of_tai_s


def _parsed(labels: Sequence[str], where: str) -> tuple[Any, Array]:
    """Days of the modified Julian date, and seconds of the day."""
    plain = [_calendar(label, where) for label in labels]
    dates = np.array([label[:10] for label in plain], dtype="datetime64[D]")
    clock = [label[11:].split(":") for label in plain]
    seconds = np.array([3600.0 * int(h) + 60.0 * int(m) + float(s) for h, m, s in clock])
    return (dates - DAY_0).astype(np.int64), seconds


def _calendar(label: str, where: str) -> str:
    text = label.removesuffix("Z")
    day = OF_YEAR.fullmatch(text)
    try:
        if day is not None:
            date = datetime(int(day[1]), 1, 1) + timedelta(days=int(day[2]) - 1)
            text = f"{date:%Y-%m-%d}T{day[3]}"
        if CALENDAR.fullmatch(text) is None:
            raise ValueError
        datetime.fromisoformat(f"{text[:17]}{min(int(text[17:19]), 59):02d}")
    except (ValueError, OverflowError):
        raise InputError(f"{where}: {shown(label)!r} is not a time") from None
    return text
