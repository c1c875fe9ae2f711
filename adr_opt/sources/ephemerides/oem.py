"""CCSDS Orbit Ephemeris Messages (502.0-B, section 5), in key-value notation here.

Reading finds the segments and their metadata; the states of a segment are parsed when they are
asked for. Ephemerides in other formats become segments of such messages.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...common.errors import InputError
from ..beginnings import ephemeris_format, head_of
from ..catalogue.records import shown
from .modified_itc import read_itc
from .oem_segment import MessageSegment, Rows, segment_of
from .oem_xml import read_xml
from .stk import read_stk


def read_oem(content: bytes, source: str) -> list[MessageSegment]:
    """The segments of a message, or of an ephemeris in another format that is known.

    Raises
    ------
    InputError
        It is none, or a segment lacks metadata or states.
    """
    begin = head_of(content)
    if begin.startswith("<"):
        found = read_xml(content, source)
    elif begin.startswith("CCSDS_OEM_VERS"):
        found = list(_segments(content.decode("utf-8-sig", "replace"), source))
    elif ephemeris_format(begin):
        read = read_stk if "STK" in ephemeris_format(begin) else read_itc
        found = [read(content.decode("utf-8-sig", "replace"), source)]
    else:
        raise InputError(
            f"{source}: no OEM, it does not begin with CCSDS_OEM_VERS, and neither an STK nor a "
            "Modified ITC ephemeris"
        )
    if not found:
        raise InputError(f"{source}: an OEM without a segment; give one with states")
    return found


def _segments(text: str, source: str) -> Iterator[MessageSegment]:
    fields: dict[str, str] = {}
    rows = Rows()
    covariances: list[str] = []
    begin, in_metadata, in_covariance = 0, False, False
    for number, row in enumerate(text.splitlines(), 1):
        line = row.strip()
        if not line or line.startswith("COMMENT"):
            continue
        if line == "META_START":
            if begin:
                yield segment_of(source, begin, fields, rows, covariances)
            fields, rows, covariances, begin = {}, [], [], number
            in_metadata, in_covariance = True, False
        elif line == "META_STOP":
            in_metadata = False
        elif line in ("COVARIANCE_START", "COVARIANCE_STOP"):
            in_covariance = line == "COVARIANCE_START"
        elif in_metadata:
            keyword, is_given, value = line.partition("=")
            keyword = keyword.strip()
            if not is_given or keyword in fields:
                fault = "is given twice" if is_given else "has no value"
                raise InputError(f"{source}: line {number}: {shown(keyword)} {fault}")
            fields[keyword] = value.strip()
        elif in_covariance:
            covariances.append(line)
        elif begin:
            rows.append((number, line))
    if begin:
        yield segment_of(source, begin, fields, rows, covariances)
