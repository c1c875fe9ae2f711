"""Detection of file formats by their first bytes, and the parser of XML messages.

The parser of the standard library is used directly because it knows line numbers, and because a
document type, which a message never has and which entity bombs need, can be refused as soon as it
begins.
"""

from __future__ import annotations

from xml.parsers import expat

from ..common.errors import InputError
from .catalogue.records import shown

UTF_16 = b"\xff\xfe", b"\xfe\xff"
"""Byte order marks of texts in UTF-16."""

HEAD = 4096
"""Number of bytes by which a format is detected."""


def head_of(data: bytes) -> str:
    """The beginning of a text, decoded by its byte order mark, without leading blanks.

    Bytes that are no UTF-8 become replacement characters: they spoil the row in which they stand,
    or XML says in which encoding they are.
    """
    encoding = "utf-16" if data.startswith(UTF_16) else "utf-8-sig"
    return data.lstrip()[:HEAD].decode(encoding, "replace").lstrip()


def ephemeris_format(head: str) -> str:
    """Format of an ephemeris other than OEM, from its beginning, with its article; or empty."""
    if head[:6].lower() == "stk.v.":
        return "an STK ephemeris"
    return "a Modified ITC ephemeris" if "ephemeris_start:" in head[:300] else ""


ANYWAY = ("utf-8", "utf-16", "us-ascii", "iso-8859-1")
"""Encodings that the XML parser knows; for others it requests a table of 256 characters."""


class XmlReader:
    """Base of readers of XML messages, whose subclasses handle elements and text."""

    def attach(self, parser: expat.XMLParserType) -> None:
        """Register the reader's methods with a parser."""
        self.parser = parser
        parser.StartElementHandler = self.open
        parser.EndElementHandler = self.close
        parser.CharacterDataHandler = self.hear

    def open(self, tag: str, attributes: dict[str, str]) -> None:
        """An element begins."""

    def hear(self, text: str) -> None:
        """Text of the open element."""

    def close(self, tag: str) -> None:
        """An element ends."""


def new_parser(source: str, message: str) -> expat.XMLParserType:
    """A parser that refuses document types and unknown encodings.

    Parameters
    ----------
    source : str
        The file, for errors.
    message : str
        What it should hold, as ``"an OEM"``.
    """
    parser = expat.ParserCreate()

    def refuse_document_type(*_: object) -> None:
        raise InputError(
            f"{source}: line {parser.CurrentLineNumber}: a document type (DOCTYPE), which "
            f"{message} does not have; download it again"
        )

    def check_encoding(_: str, encoding: str | None, __: int) -> None:
        if encoding is None or encoding.lower() in ANYWAY:
            return
        try:
            is_known = len(bytes(range(256)).decode(encoding, "replace")) == 256
        except (LookupError, ValueError):
            is_known = False
        if not is_known:
            raise InputError(
                f"{source}: in the encoding {shown(encoding)!r}, which is unknown here; save it as "
                "UTF-8"
            )

    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = refuse_document_type
    parser.XmlDeclHandler = check_encoding
    return parser
