"""The parser of XML messages: in the encoding that a file declares, without document types.

The parser of the standard library is used directly because it knows line numbers, and because a
document type, which a message never has and which entity bombs need, can be refused as soon as it
begins.
"""

from __future__ import annotations

from xml.parsers import expat

from ..common.errors import InputError
from .catalogue.records import shown

ANYWAY = ("utf-8", "utf-16", "us-ascii", "iso-8859-1")
"""Encodings that the parser knows itself; of others it asks for a table of 256 characters."""


def new_parser(source: str, message: str) -> expat.XMLParserType:
    """A parser that refuses what no message has.

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
