"""Units in files of given connections, as factors to seconds and metres per second."""

from __future__ import annotations

import re
from typing import Any

from ..common.errors import InputError

TIMES_S = {
    "ns": 1e-9,
    "nanosecond": 1e-9,
    "us": 1e-6,
    "µs": 1e-6,
    "microsecond": 1e-6,
    "ms": 1e-3,
    "msec": 1e-3,
    "millisecond": 1e-3,
    "s": 1.0,
    "sec": 1.0,
    "second": 1.0,
    "min": 60.0,
    "minute": 60.0,
    "h": 3600.0,
    "hr": 3600.0,
    "hour": 3600.0,
    "d": 86400.0,
    "day": 86400.0,
}
"""Units of time, longer ones also in the plural [s]."""

LENGTHS_M = {
    "mm": 1e-3,
    "millimetre": 1e-3,
    "millimeter": 1e-3,
    "cm": 1e-2,
    "centimetre": 1e-2,
    "centimeter": 1e-2,
    "m": 1.0,
    "metre": 1.0,
    "meter": 1.0,
    "km": 1e3,
    "kilometre": 1e3,
    "kilometer": 1e3,
}
"""Units of length [m]."""

SPEED = (
    re.compile(r"([^\W\d]+) ?(?:/|\bper\b) ?([^\W\d]+)"),
    re.compile(r"([^\W\d]+) ?[ .*·] ?([^\W\d]+?) ?(?:\^|\*\*)? ?(?:-1|⁻¹|\(-1\))"),
)
"""Spellings of a length per time: ``m/s``, ``m / s``, ``m s-1``, ``m s^-1``, ``m*s**-1``."""

LONGEST_SHOWN = 40
"""Length beyond which units are cut in error messages."""


def time_factor(unit: Any, name: str) -> float:
    """Seconds in a unit of time; without a unit, 1.

    Parameters
    ----------
    unit : str, bytes or None
        As a file states it.
    name : str
        What is stated in it, for errors.

    Raises
    ------
    InputError
        It is no unit of time that is known here.
    """
    text = _text(unit, name)
    if not text:
        return 1.0
    factor = _factor(text, TIMES_S)
    if factor is None:
        if re.search(r"\b(since|after|from)\b", text):
            raise InputError(
                f"{name}: its unit {_shown(text)} counts from a date; give times since the epoch "
                "of the instance, in s, min, h or days"
            )
        raise InputError(
            f"{name}: its unit {_shown(text)} is not a known unit of time; give s, min, h or days"
        )
    return factor


def cost_factor(unit: Any, name: str) -> float:
    """Metres per second in a unit of speed; without a unit, or with "1", 1.

    Parameters
    ----------
    unit, name
        As :func:`time_factor` takes them.

    Raises
    ------
    InputError
        It is no speed.
    """
    text = _text(unit, name)
    if text in ("", "1"):
        return 1.0
    for spelling in SPEED:
        found = spelling.fullmatch(text)
        if found is not None:
            length, time = _factor(found[1], LENGTHS_M), _factor(found[2], TIMES_S)
            if length is not None and time is not None:
                return length / time
    raise InputError(
        f"{name}: its unit {_shown(text)} is not a known unit of speed; give m s-1 or km s-1, or "
        "leave the unit out where the cost is no speed"
    )


def _factor(text: str, known: dict[str, float]) -> float | None:
    """Factor of a unit: words may be plural and capitalised, symbols may not ("S" is no second)."""
    if text in known:
        return known[text]
    word = text.lower().removesuffix("s")
    return known.get(word) if len(word) > 1 and len(text) > 2 else None


def _text(unit: Any, name: str) -> str:
    if unit is None:
        return ""
    if isinstance(unit, bytes):
        unit = unit.decode(errors="replace")
    if not isinstance(unit, str):
        raise InputError(f"{name}: its unit is not a text; give s, min, h or days, or m s-1")
    return " ".join(unit.split())


def _shown(text: str) -> str:
    return repr(text if len(text) <= LONGEST_SHOWN else text[: LONGEST_SHOWN - 1] + "…")
