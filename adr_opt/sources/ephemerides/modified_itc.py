"""Modified ITC ephemerides, as operators give them to Space-Track, Starlink's among them.

Four lines of heading, then for each time a line with the state [km, km/s] and three with its
covariance, which is not read. The file does not say whose states they are, or in which axes: its
name does, ``MEME_44713_STARLINK-1007_0581823_Operational_…``, with MEME for EME2000.
"""

from __future__ import annotations

import re
from pathlib import Path

from ...common.errors import InputError
from ..catalogue.records import shown
from .oem_segment import MessageSegment, Rows, segment_of

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
            f"{source}: a Modified ITC ephemeris, of which only the name says the object; call it "
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
