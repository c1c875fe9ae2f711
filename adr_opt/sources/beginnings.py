"""Beginnings of files, in which their formats show."""

from __future__ import annotations

UTF_16 = b"\xff\xfe", b"\xfe\xff"
"""Byte order marks of texts in UTF-16."""

HEAD = 4096
"""Number of bytes in which a format shows."""


def head_of(data: bytes) -> str:
    """The beginning of a text by its byte order mark, blanks before it left out.

    Bytes that are no UTF-8 become replacement characters: they spoil the row in which they stand,
    or XML says in which encoding they are.
    """
    encoding = "utf-16" if data.startswith(UTF_16) else "utf-8-sig"
    return data.lstrip()[:HEAD].decode(encoding, "replace").lstrip()


def ephemeris_format(head: str) -> str:
    """What ephemerides other than OEM begin so, with its article; empty if none do."""
    if head[:6].lower() == "stk.v.":
        return "an STK ephemeris"
    return "a Modified ITC ephemeris" if "ephemeris_start:" in head[:300] else ""
