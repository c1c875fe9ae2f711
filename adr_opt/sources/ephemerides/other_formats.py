"""Ephemerides of STK (``.e``) and in the Modified ITC format, as segments of OEM.

The files do not say whose states they are: their names do. That of an STK ephemeris, without the
suffix, is the name of a body or its international designator. Operators give Modified ITC
ephemerides to Space-Track, Starlink's among them: four lines of heading, then for each time a line
with the state [km, km/s] and three with its covariance, which is not read. The name,
``MEME_44713_STARLINK-1007_0581823_Operational_…``, says the axes, too, with MEME for EME2000.
"""

from __future__ import annotations

import re
from datetime import datetime, timedelta
from pathlib import Path

from ...common.errors import InputError
from ..catalogue.records import shown
from .oem_segment import MessageSegment, Rows, segment_of

FRAMES = {"J2000": "EME2000", "ICRF": "ICRF", "TEMEOFDATE": "TEME", "TEMEOFEPOCH": "TEME"}
"""Supported coordinate systems, with their names in OEM."""

UNITS_KM = {"METERS": 1e-3, "KILOMETERS": 1.0}
STATES = {"EPHEMERISTIMEPOSVEL": 7, "EPHEMERISTIMEPOSVELACC": 10}
_KEYWORDS = """
SCENARIOEPOCH CENTRALBODY COORDINATESYSTEM COORDINATESYSTEMEPOCH DISTANCEUNIT
INTERPOLATIONMETHOD INTERPOLATIONSAMPLESM1 INTERPOLATIONORDER NUMBEROFEPHEMERISPOINTS
BLOCKINGFACTOR MESSAGELEVEL COVARIANCEFORMAT
"""
KEYWORDS = tuple(_KEYWORDS.split())
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
            raise InputError(f"{where} with {shown(line.strip())!r}, not supported; {INSTEAD}")
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


NAME = re.compile(r"MEME_(\d{1,9})_(.+?)_\d{7}_[A-Za-z]+(_.*)?")
TIME = re.compile(r"(\d{4})(\d{3})(\d\d)(\d\d)(\d\d(?:\.\d*)?)", re.ASCII)
BOUNDS = re.compile(r"ephemeris_(start|stop):\s*(\d{4}-\d\d-\d\d) (\d\d:\d\d:\d\d(?:\.\d+)?)")
HEADING = 4


def read_itc(text: str, source: str) -> MessageSegment:
    """The segment of such a file.

    Raises
    ------
    InputError
        Its name does not tell the object, or a line is none of the format.
    """
    named = NAME.fullmatch(Path(source).stem)
    if named is None:
        raise InputError(
            f"{source}: a Modified ITC ephemeris, whose object only the file name states; call it "
            "MEME_NUMBER_NAME_DAYTIME_Operational… as its publisher does, or convert it to an OEM"
        )
    rows = Rows()
    lines = text.splitlines()
    for number, line in enumerate(lines[HEADING:], HEADING + 1):
        time, *values = line.split() or [""]
        at = TIME.fullmatch(time)
        if at is not None and len(values) == 6:
            label = f"{at[1]}-{at[2]}T{at[3]}:{at[4]}:{at[5].rstrip('.')}"
            rows.append((number, " ".join((label, *values))))
        elif line.strip() and (at is not None or len(values) != 6 or not rows):
            raise InputError(
                f"{source}: line {number}: {shown(line)!r} is neither a state of a Modified ITC "
                "ephemeris nor a part of its covariance"
            )
    if not rows:
        raise InputError(f"{source}: a Modified ITC ephemeris without a state")
    stated = {end: f"{day}T{time}" for end, day, time in BOUNDS.findall("\n".join(lines[:HEADING]))}
    return segment_of(
        source,
        1,
        {
            "OBJECT_NAME": f"{named[2]} {int(named[1])}",
            "OBJECT_ID": named[1],
            "CENTER_NAME": "EARTH",
            "REF_FRAME": "EME2000",
            "TIME_SYSTEM": "UTC",
            "START_TIME": stated.get("start", rows[0][1].split()[0]),
            "STOP_TIME": stated.get("stop", rows[-1][1].split()[0]),
        },
        rows,
    )
