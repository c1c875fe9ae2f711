"""Epochs of GMAT: UTC in its Gregorian format, to the millisecond."""

from __future__ import annotations

from datetime import datetime

from ...problem.instance import Instance

MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


def whole_millisecond(instance: Instance, time_s: float) -> float:
    """Nearest time with whole milliseconds in the calendar, the resolution of GMAT."""
    beyond_s = instance.epoch.microsecond % 1000 / 1e6
    return round((time_s + beyond_s) * 1e3) / 1e3 - beyond_s


def gregorian(time: datetime) -> str:
    """A time in GMAT's format, in English whatever the locale."""
    month = MONTHS[time.month - 1]
    return (
        f"{time.day:02d} {month} {time.year:04d} {time.hour:02d}:{time.minute:02d}:"
        f"{time.second:02d}.{time.microsecond // 1000:03d}"
    )
