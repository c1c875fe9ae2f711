"""Fields of an OMM (CCSDS 502.0-B), in any spelling, as a record.

Values are text or JSON numbers; unknown keys are ignored, because CelesTrak and Space-Track add
their own. TLE-like OMMs without metadata are what their publishers say: SGP4, TEME, UTC.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from typing import Any

from ...common.constants import DAY_S
from .records import Dropped, ElementSet, RowError, clean_name, shown
from .tle import catalogue_number

UNITS = {
    "MEAN_MOTION": "rev/day",
    "SEMI_MAJOR_AXIS": "km",
    "INCLINATION": "deg",
    "RA_OF_ASC_NODE": "deg",
    "ARG_OF_PERICENTER": "deg",
    "MEAN_ANOMALY": "deg",
    "BSTAR": "1/er",
    "MEAN_MOTION_DOT": "rev/day**2",
    "MEAN_MOTION_DDOT": "rev/day**3",
    "MASS": "kg",
}
"""The only permitted units, which a file may repeat."""

USER_DEFINED = ("DECAY_DATE", "EPOCH_MICROSECONDS", "RCS_SIZE")
"""Fields of Space-Track's own: user-defined in XML and KVN, plain keys in JSON and CSV."""

FIELDS = frozenset(UNITS) | {
    "OBJECT_NAME",
    "OBJECT_ID",
    "CENTER_NAME",
    "REF_FRAME",
    "TIME_SYSTEM",
    "MEAN_ELEMENT_THEORY",
    "EPOCH",
    "ECCENTRICITY",
    "NORAD_CAT_ID",
    "ELEMENT_SET_NO",
    "REV_AT_EPOCH",
    "EPHEMERIS_TYPE",
    "CLASSIFICATION_TYPE",
    *USER_DEFINED,
}

SIZES = ("SMALL", "MEDIUM", "LARGE")
"""Classes of the radar cross-section: below 0.1 m², up to 1 m², above."""

THEORIES = {"SGP4", "SGP/SGP4", "SGP4/SDP4", "SDP4", "SGP"}
FRAMES = {"TEME", "TEMEOFEPOCH", "TEME OF EPOCH"}
MU_KM3_S2 = 398600.8
"""Gravitational parameter of WGS-72, as used by SGP4."""

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_INTEGER = re.compile(r"[+-]?\d{1,18}(?:\.0*)?", re.ASCII)
_ALPHA_5 = re.compile(r"[A-HJ-NP-Z]\d{4}", re.ASCII)
_TIME = re.compile(
    r"(\d{4})-(?:(\d\d)-(\d\d)|(\d{3}))"
    r"(?:[T ](\d\d):(\d\d):(\d\d)(?:\.(\d{0,30}))?Z?)?",
    re.ASCII,
)


def read_message(
    fields: Mapping[str, Any],
    source: str,
    line: int,
    ordinal: int | None = None,
    *,
    fault: RowError | None = None,
    fault_line: int | None = None,
) -> ElementSet | Dropped:
    """The record made from the fields of one message, or the error.

    Parameters
    ----------
    fields : mapping
        Keyword in capitals → text, number or None.
    source, line, ordinal
        Where they are from.
    fault : RowError, optional
        What is wrong with the message, whatever its fields say.
    fault_line : int, optional
        Where that is, if not where the message begins.
    """
    try:
        if fault is not None:
            raise fault
        return _record(fields, source, line, ordinal)
    except RowError as error:
        at = line if error is not fault or fault_line is None else fault_line
        return Dropped(source, at, label(fields), error.reason, error.detail, ordinal)


def _record(fields: Mapping[str, Any], source: str, line: int, ordinal: int | None) -> ElementSet:
    theory = _text(fields, "MEAN_ELEMENT_THEORY", "SGP4").upper()
    not_sgp4 = _why_not_sgp4(fields, theory)
    if fields.get("MEAN_MOTION") in (None, "") and fields.get("SEMI_MAJOR_AXIS") not in (None, ""):
        axis_km = _number(fields, "SEMI_MAJOR_AXIS", 1.0, 1e9)
        mean_motion = math.sqrt(MU_KM3_S2 / axis_km) / axis_km * DAY_S / (2.0 * math.pi)
        not_sgp4 = not_sgp4 or "SEMI_MAJOR_AXIS stands for the MEAN_MOTION that SGP4 needs"
    else:
        mean_motion = _number(fields, "MEAN_MOTION", 1e-9, 100.0)
    eccentricity = _number(fields, "ECCENTRICITY", 0.0)
    if eccentricity >= 1.0:
        raise RowError(f"field ECCENTRICITY = {eccentricity:g}: no closed orbit", "hyperbolic")
    return ElementSet(
        name=clean_name(_text(fields, "OBJECT_NAME")),
        object_id=clean_name(_text(fields, "OBJECT_ID")),
        number=_catalogue_number(fields),
        epoch=_epoch(fields),
        mean_motion_rev_day=mean_motion,
        eccentricity=eccentricity,
        inclination_deg=_number(fields, "INCLINATION", 0.0, 180.0),
        raan_deg=_number(fields, "RA_OF_ASC_NODE", -360.0, 360.0),
        argument_of_perigee_deg=_number(fields, "ARG_OF_PERICENTER", -360.0, 360.0),
        mean_anomaly_deg=_number(fields, "MEAN_ANOMALY", -360.0, 360.0),
        bstar=_number(fields, "BSTAR", default=0.0 if not_sgp4 else None),
        mean_motion_dot_rev_day2=_number(fields, "MEAN_MOTION_DOT", default=0.0),
        mean_motion_ddot_rev_day3=_number(fields, "MEAN_MOTION_DDOT", default=0.0),
        classification=clean_name(_text(fields, "CLASSIFICATION_TYPE", "U")),
        ephemeris_type=_integer(fields, "EPHEMERIS_TYPE"),
        element_set=_integer(fields, "ELEMENT_SET_NO"),
        revolution=_integer(fields, "REV_AT_EPOCH"),
        not_sgp4=not_sgp4,
        mass_kg=_number(fields, "MASS", 0.0, 1e9, default=0.0) or None,
        size=_size(fields),
        decays=_decays(fields),
        source=source,
        line=line,
        ordinal=ordinal,
    )


def keyword(said: str) -> str:
    """The keyword of a field as a file spells it."""
    key = said.strip().upper()
    own = key.removeprefix("USER_DEFINED_")
    return own if own in USER_DEFINED else key


def label(fields: Mapping[str, Any]) -> str:
    """Name of the object of an invalid message, if known."""
    parts = (fields.get("OBJECT_NAME"), fields.get("NORAD_CAT_ID") or fields.get("OBJECT_ID"))
    return " ".join(shown(part) for part in parts if part not in (None, ""))


def check_unit(key: str, unit: str) -> None:
    """Raise :class:`RowError` if a field has another unit than OMM's."""
    if key in UNITS and unit.strip().lower() != UNITS[key]:
        raise RowError(f"field {key}: its unit is {shown(unit)!r}, not {UNITS[key]!r}")


def _why_not_sgp4(fields: Mapping[str, Any], theory: str) -> str:
    for key, default, allowed in (
        ("CENTER_NAME", "EARTH", {"EARTH"}),
        ("REF_FRAME", "TEME", FRAMES),
        ("TIME_SYSTEM", "UTC", {"UTC"}),
    ):
        value = _text(fields, key, default).upper()
        if value not in allowed:
            return f"{key} is {shown(value)}, SGP4 needs {default}"
    if theory not in THEORIES:
        return f"MEAN_ELEMENT_THEORY is {shown(theory)}, not SGP4"
    if _integer(fields, "EPHEMERIS_TYPE") == 4:
        return "EPHEMERIS_TYPE 4 is SGP4-XP, not SGP4"
    return ""


def _size(fields: Mapping[str, Any]) -> str:
    said = _text(fields, "RCS_SIZE").upper()
    return said if said in SIZES else ""


def _text(fields: Mapping[str, Any], key: str, default: str = "") -> str:
    value = fields.get(key)
    if value is None:
        return default
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise RowError(f"field {key}: must be text")
    return str(value).strip() or default


def _number(
    fields: Mapping[str, Any],
    key: str,
    low: float = -1e300,
    high: float = 1e300,
    *,
    default: float | None = None,
) -> float:
    given = fields.get(key)
    value = math.nan
    if type(given) is float or type(given) is int:
        # an integer of JSON may be longer than any float
        value = float(given) if abs(given) <= 1e300 else math.nan
    elif isinstance(given, str) and given.strip():
        text = given.strip()
        if len(text) <= 100 and _NUMBER.fullmatch(text):
            value = float(text)
    elif given is None or given == "":
        if default is None:
            raise RowError(f"field {key}: missing")
        return default
    if not low <= value <= high:
        if math.isfinite(value):
            limits = f"between {low:g} and {high:g}" if high < 1e300 else f"at least {low:g}"
            raise RowError(f"field {key} = {shown(given)}: must be {limits}")
        raise RowError(f"field {key} = {shown(given)}: must be a number")
    return value


def _integer(fields: Mapping[str, Any], key: str) -> int:
    given = fields.get(key)
    if given is None or given == "":
        return 0
    if type(given) is int and abs(given) < 10**18:
        return given
    if type(given) is float and given.is_integer() and abs(given) < 1e15:
        return int(given)
    if isinstance(given, str):
        text = given.strip()
        if not text:
            return 0
        if _INTEGER.fullmatch(text):
            return int(text.partition(".")[0])
    raise RowError(f"field {key} = {shown(given)}: must be a whole number")


def _catalogue_number(fields: Mapping[str, Any]) -> int | None:
    given = fields.get("NORAD_CAT_ID")
    if given is None or given == "":
        return None
    if isinstance(given, str) and _ALPHA_5.fullmatch(given.strip()):
        return catalogue_number(given.strip())
    number = _integer(fields, "NORAD_CAT_ID")
    if not 0 <= number <= 999_999_999:
        raise RowError(f"field NORAD_CAT_ID = {number}: must be between 0 and 999999999")
    return number


def _epoch(fields: Mapping[str, Any]) -> datetime:
    """The epoch, completed by its microseconds where they are a field of their own."""
    given = fields.get("EPOCH")
    if given is None or given == "":
        raise RowError("field EPOCH: missing")
    epoch, decimals = _time("EPOCH", given, "a time like 2025-04-02T14:17:36.41")
    if fields.get("EPOCH_MICROSECONDS") in (None, ""):
        return epoch
    apart = _integer(fields, "EPOCH_MICROSECONDS")
    if not 0 <= apart < 10**6:
        raise RowError(f"field EPOCH_MICROSECONDS = {apart}: must be between 0 and 999999")
    completed = epoch.replace(microsecond=apart)
    # An epoch with decimals says the same, to as many as it has.
    if decimals and abs((completed - epoch).total_seconds()) > 10.0**-decimals:
        raise RowError(
            f"field EPOCH_MICROSECONDS = {apart}: EPOCH = {shown(given)} has them, too; keep one"
        )
    return completed


def _decays(fields: Mapping[str, Any]) -> datetime | None:
    said = _text(fields, "DECAY_DATE")
    return _time("DECAY_DATE", said, "a date like 2025-04-02")[0] if said else None


def _time(key: str, given: Any, wanted: str) -> tuple[datetime, int]:
    """A time, and the number of decimals of its seconds; a date alone means its first moment."""
    parts = _TIME.fullmatch(given.strip()) if isinstance(given, str) else None
    if parts is None or (key == "EPOCH" and parts[5] is None):
        raise RowError(f"field {key} = {shown(given)}: must be {wanted}")
    year, month, day, of_year, *clock, fraction = parts.groups()
    hour, minute, second = (int(part or 0) for part in clock)
    try:
        if of_year is None:
            date = datetime(int(year), int(month), int(day), tzinfo=UTC)
        else:
            date = datetime(int(year), 1, 1, tzinfo=UTC) + timedelta(days=int(of_year) - 1)
            if date.year != int(year):
                raise ValueError
        if hour > 23 or minute > 59 or second > 60:
            raise ValueError
        microseconds = round(float(f"0.{fraction or 0}") * 1e6)
        return (
            date + timedelta(hours=hour, minutes=minute, seconds=second, microseconds=microseconds),
            len(fraction) if fraction and microseconds else 0,
        )
    except (ValueError, OverflowError):
        raise RowError(f"field {key} = {shown(given)}: there is no such time") from None
