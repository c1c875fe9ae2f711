"""CCSDS Orbit Ephemeris Messages (502.0-B, section 5), in key-value notation or XML.

Reading finds the segments and their metadata; the states of a segment are parsed when they are
asked for. Ephemerides in other formats become segments of such messages.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.parsers import expat

from ...common.errors import InputError
from ..catalogue.records import shown
from ..file_formats import XmlReader, ephemeris_format, head_of, new_parser
from .oem_segment import MessageSegment, Rows, segment_of
from .other_formats import read_itc, read_stk

STATE = ("EPOCH", "X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")
"""Elements of a state, in the order of a row."""

UNITS = ("km", "km/s")
"""The only permitted units of a state, which a file may repeat."""


def read_xml(content: bytes, source: str) -> list[MessageSegment]:
    """The segments of a message.

    Raises
    ------
    InputError
        It is none, or a segment lacks metadata or states.
    """
    reader = _Reader(source)
    parser = new_parser(source, "an OEM")
    reader.attach(parser)
    try:
        parser.Parse(content.removeprefix(b"\xef\xbb\xbf").lstrip(), True)
    except expat.ExpatError as error:
        raise InputError(
            f"{source}: line {error.lineno}: not well-formed XML ({expat.ErrorString(error.code)})"
        ) from None
    return reader.found


class _Reader(XmlReader):
    """Collects metadata and states of the open segment."""

    def __init__(self, source: str) -> None:
        self.source, self.found = source, list[MessageSegment]()
        self.fields, self.rows, self.state = dict[str, str](), Rows(), dict[str, str]()
        self.inside, self.text, self.line, self.row_line = "", "", 0, 0

    def open(self, tag: str, attributes: dict[str, str]) -> None:
        """An element begins."""
        tag, self.text = tag.rpartition(":")[2], ""
        if tag == "segment":
            self.fields, self.rows, self.line = {}, [], self.parser.CurrentLineNumber
        elif tag in ("metadata", "stateVector"):
            self.inside, self.state, self.row_line = tag, {}, self.parser.CurrentLineNumber
        elif self.inside == "stateVector" and attributes.get("units", "km") not in UNITS:
            raise InputError(
                f"{self.source}: line {self.parser.CurrentLineNumber}: {tag} in "
                f"{shown(attributes['units'])}, not in km or km/s"
            )

    def hear(self, text: str) -> None:
        """Text of the open element."""
        self.text += text

    def close(self, tag: str) -> None:
        """An element ends."""
        tag = tag.rpartition(":")[2]
        if tag == "stateVector":
            missing = [name for name in STATE if name not in self.state]
            if missing:
                raise InputError(
                    f"{self.source}: line {self.parser.CurrentLineNumber}: a state without "
                    f"{missing[0]}"
                )
            row = " ".join(self.state[name] for name in STATE)
            self.rows.append((self.row_line, row))
        elif tag == "segment":
            self.found.append(segment_of(self.source, self.line, self.fields, self.rows))
        elif self.inside == "metadata" and tag not in ("COMMENT", "metadata"):
            if tag in self.fields:
                raise InputError(
                    f"{self.source}: line {self.parser.CurrentLineNumber}: {shown(tag)} is given "
                    "twice"
                )
            self.fields[tag] = self.text.strip()
        elif self.inside == "stateVector":
            self.state[tag] = self.text.strip()
        if tag == self.inside:
            self.inside = ""
        self.text = ""


def read_oem(content: bytes, source: str) -> list[MessageSegment]:
    """The segments of a message, or of an ephemeris in another supported format.

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
            f"{source}: not an OEM, as it does not begin with CCSDS_OEM_VERS, nor an STK or "
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
