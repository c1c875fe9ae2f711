"""CCSDS Orbit Ephemeris Messages in XML, as the segments of those in key-value notation."""

from __future__ import annotations

from xml.parsers import expat

from ...common.errors import InputError
from ..catalogue.records import shown
from ..xml_parser import new_parser
from .oem_segment import MessageSegment, Rows, segment_of

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


class _Reader:
    """Collects metadata and states of the open segment."""

    def __init__(self, source: str) -> None:
        self.source, self.found = source, list[MessageSegment]()
        self.fields, self.rows, self.state = dict[str, str](), Rows(), dict[str, str]()
        self.inside, self.text, self.line, self.row_line = "", "", 0, 0

    def attach(self, parser: expat.XMLParserType) -> None:
        """Take part in the parsing."""
        parser.StartElementHandler = self.open
        parser.EndElementHandler = self.close
        parser.CharacterDataHandler = self.hear
        self.parser = parser

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
