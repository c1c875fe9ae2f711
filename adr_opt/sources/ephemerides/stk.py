"""Ephemerides of STK (``.e``): keywords, then times since an epoch with states.

The file does not say whose states they are: its name does, without the suffix, as the name of a
body or its international designator.
"""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

from ...common.errors import InputError
from ..catalogue.records import shown
from .oem_segment import MessageSegment, Rows, segment_of

FRAMES = {"J2000": "EME2000", "ICRF": "ICRF", "TEMEOFDATE": "TEME", "TEMEOFEPOCH": "TEME"}
"""Coordinate systems that are understood, as OEM calls them."""

UNITS_KM = {"METERS": 1e-3, "KILOMETERS": 1.0}
STATES = {"EPHEMERISTIMEPOSVEL": 7, "EPHEMERISTIMEPOSVELACC": 10}
KEYWORDS = (
    "SCENARIOEPOCH",
    "CENTRALBODY",
    "COORDINATESYSTEM",
    "COORDINATESYSTEMEPOCH",
    "DISTANCEUNIT",
    "INTERPOLATIONMETHOD",
    "INTERPOLATIONSAMPLESM1",
    "INTERPOLATIONORDER",
    "NUMBEROFEPHEMERISPOINTS",
    "BLOCKINGFACTOR",
    "MESSAGELEVEL",
    "COVARIANCEFORMAT",
)
INSTEAD = "convert it to an OEM"


def read_stk(text: str, source: str) -> MessageSegment:
    """The segment of such a file.

    Raises
    ------
    InputError
        A keyword, a unit, an axis or a kind of states is not understood.
    """
    said: dict[str, str] = {}
    rows, columns = list[tuple[int, list[float]]](), 0
    for number, line in enumerate(text.splitlines()[1:], 2):
        keyword, *values = line.partition("#")[0].split() or [""]
        keyword = keyword.upper()
        if not keyword or (keyword, *map(str.upper, values)) == ("BEGIN", "EPHEMERIS"):
            continue
        if keyword == "END" or (columns and keyword.startswith("COVARIANCE")):
            break
        where = f"{source}: line {number}: an STK ephemeris"
        if columns:
            try:
                rows.append((number, [float(part) for part in (keyword, *values)]))
            except ValueError:
                raise InputError(f"{where} with {shown(line)!r} among its states") from None
            if len(rows[-1][1]) != columns:
                raise InputError(f"{where} with {shown(line)!r}, not a time with its state")
        elif keyword in STATES:
            columns = STATES[keyword]
        elif keyword in KEYWORDS and keyword not in said and values:
            said[keyword] = " ".join(values).strip('"')
        else:
            raise InputError(f"{where} with {shown(line.strip())!r}, which is not read; {INSTEAD}")
    return segment_of(source, 1, _fields(said, source, rows), _labelled(said, source, rows))


def _fields(
    said: dict[str, str], source: str, rows: list[tuple[int, list[float]]]
) -> dict[str, str]:
    """Metadata of an OEM for the keywords of a file."""
    frame = said.get("COORDINATESYSTEM", "Fixed")
    if frame.upper() not in FRAMES:
        raise InputError(
            f"{source}: an STK ephemeris with CoordinateSystem {shown(frame)}, not J2000, ICRF, "
            f"TEMEOfDate or TEMEOfEpoch; {INSTEAD}"
        )
    if not rows:
        raise InputError(f"{source}: an STK ephemeris without states of position and velocity")
    epoch = _epoch(said.get("SCENARIOEPOCH", ""), source)
    name = Path(source).stem
    fields = {
        "OBJECT_NAME": name,
        "OBJECT_ID": name,
        "CENTER_NAME": said.get("CENTRALBODY", "Earth"),
        "REF_FRAME": FRAMES[frame.upper()],
        "TIME_SYSTEM": "UTC",
        "START_TIME": _label(epoch, rows[0][1][0]),
        "STOP_TIME": _label(epoch, rows[-1][1][0]),
    }
    if frame.upper() == "TEMEOFEPOCH":
        of_epoch = _epoch(said.get("COORDINATESYSTEMEPOCH", said["SCENARIOEPOCH"]), source)
        fields["REF_FRAME_EPOCH"] = _label(of_epoch, 0.0)
    method = fields["INTERPOLATION"] = said.get("INTERPOLATIONMETHOD", "Lagrange").upper()
    points = said.get("INTERPOLATIONSAMPLESM1")
    degree = said.get("INTERPOLATIONORDER") if points is None else points
    if degree is not None:
        is_hermite = points is not None and method == "HERMITE" and points.isdecimal()
        fields["INTERPOLATION_DEGREE"] = str(2 * int(degree) + 1) if is_hermite else degree
    return fields


def _labelled(said: dict[str, str], source: str, rows: list[tuple[int, list[float]]]) -> Rows:
    """Rows of an OEM."""
    unit = said.get("DISTANCEUNIT", "Meters")
    if unit.upper() not in UNITS_KM:
        raise InputError(
            f"{source}: an STK ephemeris with DistanceUnit {shown(unit)}, not Meters or "
            f"Kilometers; {INSTEAD}"
        )
    epoch, factor = _epoch(said["SCENARIOEPOCH"], source), UNITS_KM[unit.upper()]
    return [
        (number, " ".join((_label(epoch, time_s), *(repr(factor * value) for value in state[:6]))))
        for number, (time_s, *state) in rows
    ]


def _epoch(said: str, source: str) -> datetime:
    for form in ("%d %b %Y %H:%M:%S.%f", "%d %b %Y %H:%M:%S"):
        try:
            whole, dot, decimals = said.partition(".")
            return datetime.strptime(whole + dot + decimals[:6], form)
        except ValueError:
            continue
    raise InputError(
        f"{source}: an STK ephemeris with the epoch {shown(said)!r}, not one like 1 Jan 2026 "
        f"12:00:00.000; {INSTEAD}"
    )


def _label(epoch: datetime, time_s: float) -> str:
    try:
        return (epoch + timedelta(seconds=time_s)).isoformat(timespec="microseconds")
    except (OverflowError, ValueError):
        return f"{time_s} s after {epoch}"
