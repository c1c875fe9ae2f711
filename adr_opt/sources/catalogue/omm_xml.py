"""OMM as XML, single (``<omm>``) or in a list (``<ndm>``)."""

from __future__ import annotations

from collections.abc import Iterator
from xml.parsers import expat

from ...common.errors import InputError
from ..xml_parser import new_parser
from . import omm
from .records import Dropped, ElementSet, RowError

DEEPEST = 50
LONGEST_TEXT = 1000
LONGEST_TOKEN = 1 << 20
"""Maximum length of a tag with its attributes, or of a comment [bytes].

The parser begins such a token again with every chunk of it."""

CHUNK = 1 << 16


def read_xml(data: bytes, source: str) -> Iterator[ElementSet | Dropped]:
    """The records of an XML file, in their order; each ``<segment>`` holds one.

    Raises
    ------
    InputError
        The file has a document type, or is another message than an OMM.
    """
    reader = _Reader(source)
    parser = new_parser(source, "an OMM")
    reader.attach(parser)
    for begin in range(0, len(data) + CHUNK, CHUNK):
        chunk = data[begin : begin + CHUNK]
        try:
            parser.Parse(chunk, not chunk)
        except expat.ExpatError as error:
            yield from reader.take()
            detail = f"not well-formed XML: {expat.ErrorString(error.code)}"
            yield Dropped(source, error.lineno, omm.label(reader.fields), "malformed", detail)
            return
        yield from reader.take()
        if begin + len(chunk) - max(parser.CurrentByteIndex, 0) > LONGEST_TOKEN + CHUNK:
            raise InputError(
                f"{source}: line {parser.CurrentLineNumber}: a tag or a comment longer than "
                f"{LONGEST_TOKEN >> 20} MiB; this is no OMM"
            )


class _Reader:
    """Collects the leaves of the open segment."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.fields: dict[str, str] = {}
        self.found: list[ElementSet | Dropped] = []
        self.depth = 0
        self.begin = 0
        self.fault: RowError | None = None
        self.fault_line = 0
        self.leaf = ""
        self.text = ""

    def attach(self, parser: expat.XMLParserType) -> None:
        parser.StartElementHandler = self.open
        parser.EndElementHandler = self.close
        parser.CharacterDataHandler = self.hear
        self.parser = parser

    def take(self) -> list[ElementSet | Dropped]:
        found, self.found = self.found, []
        return found

    def open(self, tag: str, attributes: dict[str, str]) -> None:
        self.depth += 1
        line = self.parser.CurrentLineNumber
        if self.depth > DEEPEST:
            raise InputError(
                f"{self.source}: line {line}: elements nested {DEEPEST} deep; this is no OMM"
            )
        tag = tag.rpartition(":")[2]
        if tag == "USER_DEFINED":
            tag = omm.keyword(f"USER_DEFINED_{attributes.get('parameter', '')}")
        if self.depth <= 2 and tag in ("opm", "oem", "ocm", "aem", "apm", "cdm", "tdm", "rdm"):
            raise InputError(
                f"{self.source}: line {line}: an {tag.upper()}, not an OMM; give mean elements"
            )
        self.leaf, self.text = "", ""
        if tag == "segment":
            self.fields, self.begin, self.fault = {}, line, None
        elif self.begin and tag in omm.FIELDS:
            self.leaf = tag
            if "units" in attributes:
                try:
                    omm.check_unit(tag, attributes["units"])
                except RowError as error:
                    self.blame(error)

    def hear(self, text: str) -> None:
        if self.leaf:
            self.text += text[:LONGEST_TEXT]
            if len(self.text) > LONGEST_TEXT:
                self.blame(RowError(f"field {self.leaf} is longer than {LONGEST_TEXT} characters"))
                self.leaf = ""

    def close(self, tag: str) -> None:
        self.depth -= 1
        if self.leaf:
            if self.leaf in self.fields:
                self.blame(RowError(f"field {self.leaf} is given twice in one segment"))
            self.fields[self.leaf] = self.text.strip()
            self.leaf = ""
        if self.begin and tag.rpartition(":")[2] == "segment":
            read = omm.read_message(
                self.fields, self.source, self.begin, fault=self.fault, fault_line=self.fault_line
            )
            self.found.append(read)
            self.begin = 0

    def blame(self, error: RowError) -> None:
        if self.fault is None:
            self.fault, self.fault_line = error, self.parser.CurrentLineNumber
