"""OMM in its four formats.

JSON is a list of objects, or a single one, as served by CelesTrak and Space-Track; CSV a header
line of keywords, then a line per object; KVN lines ``KEYWORD = value [unit]``, one message after
another; XML a single message (``<omm>``) or a list (``<ndm>``).
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterable, Iterator
from typing import Any
from xml.parsers import expat

from ...common.errors import InputError
from ..file_formats import XmlReader, new_parser
from . import omm
from .records import Dropped, ElementSet, RowError, shown

LONGEST_CSV_LINE = 20_000


def read_csv(lines: Iterable[str], source: str) -> Iterator[ElementSet | Dropped]:
    """The records of a CSV file, in their order.

    Each line is parsed for itself, so that an unbalanced quote spoils one row and not the rest.

    Raises
    ------
    InputError
        The first line lacks a column that every OMM needs.
    """
    header: list[str] = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            if len(line) > LONGEST_CSV_LINE:
                raise RowError(f"the line is longer than {LONGEST_CSV_LINE} characters")
            values = _split(line)
        except RowError as error:
            if not header:
                raise InputError(f"{source}: line {number}: {error.detail}") from None
            yield Dropped(source, number, "", error.reason, error.detail)
            continue
        if not header:
            header = [omm.keyword(value) for value in values]
            _check_header(header, source, number)
            continue
        fault = None
        if len(values) != len(header):
            reason = "truncated" if len(values) < len(header) else "malformed"
            fault = RowError(f"{len(values)} values under {len(header)} columns", reason)
        fields = dict(zip(header, values, strict=False))
        yield omm.read_message(fields, source, number, fault=fault)


def _check_header(header: list[str], source: str, number: int) -> None:
    for key in ("EPOCH", "MEAN_MOTION", "ECCENTRICITY", "INCLINATION"):
        if key not in header:
            raise InputError(
                f"{source}: line {number}: no column {key}; give the columns of OMM, with commas"
            )
    for place, key in enumerate(header):
        if key in omm.FIELDS and key in header[:place]:
            raise InputError(f"{source}: line {number}: two columns {key}; keep one")


def _split(line: str) -> list[str]:
    try:
        return next(csv.reader([line.rstrip("\r\n")], strict=True))
    except (csv.Error, StopIteration) as error:
        raise RowError(f"not a line of CSV ({error or 'empty'})") from None


_BLANK = re.compile(r"[ \t\r\n]*")


class _Object(dict[str, Any]):
    """A JSON object that records a key given twice, and OMM keywords in any spelling."""

    twice: str | None = None

    @classmethod
    def of(cls, pairs: list[tuple[str, Any]]) -> _Object:
        """The object made from key–value pairs in file order."""
        made, seen = cls(pairs), set[str]()
        for key, value in pairs:
            keyword = omm.keyword(key)
            name = keyword if keyword in omm.FIELDS else key
            if name in seen:
                made.twice = name
            elif isinstance(value, _Object) and value.twice is not None:
                made.twice = value.twice
            seen.add(name)
        return made


_DECODER = json.JSONDecoder(object_pairs_hook=_Object.of)


def read_json(text: str, source: str) -> Iterator[ElementSet | Dropped]:
    """The records of JSON text, in their order.

    The items of the list are decoded one by one: their lines are known, and what stands before
    the place where a file breaks off is not lost.

    Raises
    ------
    InputError
        It is a message of the server, not a catalogue.
    """
    place = _skip(text, 0)
    line, counted = 1, 0
    is_list = text.startswith("[", place)
    if is_list:
        place = _skip(text, place + 1)
        if text.startswith("]", place):
            return
    for ordinal in range(1, len(text) + 1):
        line, counted = line + text.count("\n", counted, place), place
        try:
            item, place = _DECODER.raw_decode(text, place)
        except (ValueError, RecursionError) as error:
            said = "nested too deeply or a number too long"
            if isinstance(error, json.JSONDecodeError):
                said = f"{error.msg}, column {error.colno}"
            yield Dropped(source, line, "", "malformed", f"not JSON: {said}", ordinal)
            return
        if not is_list:
            _refuse_message(item, source)
        yield _one(item, source, line, ordinal)
        place = _skip(text, place)
        if is_list and text.startswith(",", place):
            place = _skip(text, place + 1)
            continue
        if is_list and text.startswith("]", place):
            is_list, place = False, _skip(text, place + 1)
        break
    if is_list or place < len(text):
        line += text.count("\n", counted, place)
        what = f"{shown(text[place : place + 20])!r}" if place < len(text) else "the file ends"
        yield Dropped(source, line, "", "malformed", f"not JSON: {what} after record {ordinal}")


def _skip(text: str, place: int) -> int:
    blank = _BLANK.match(text, place)
    return blank.end() if blank else place


def _one(item: Any, source: str, line: int, ordinal: int) -> ElementSet | Dropped:
    if not isinstance(item, dict):
        detail = f"{shown(item)!r} is not a JSON object with the keywords of OMM"
        return Dropped(source, line, "", "malformed", detail, ordinal)
    fields = {omm.keyword(key): value for key, value in item.items()}
    fault = None
    if isinstance(item, _Object) and item.twice is not None:
        fault = RowError(f"field {shown(item.twice)} is given twice in one object")
    return omm.read_message(fields, source, line, ordinal, fault=fault)


def _refuse_message(item: Any, source: str) -> None:
    if not isinstance(item, dict):
        return
    if "format" in item or not any(omm.keyword(key) in omm.FIELDS for key in item):
        raise InputError(
            f"{source}: a JSON object that is not an OMM, but reads {shown(json.dumps(item), 60)}; "
            "give a catalogue"
        )


LONGEST_KVN_LINE = 1000
HEADER = "CCSDS_OMM_VERS"


def read_kvn(lines: Iterable[str], source: str) -> Iterator[ElementSet | Dropped]:
    """The records of a KVN file, in their order; a message begins with its version."""
    fields: dict[str, str] = {}
    begin, fault, fault_line = 0, None, 0
    for number, raw in enumerate(lines, 1):
        line = raw[:LONGEST_KVN_LINE].strip()
        if not line or line.split(None, 1)[0] == "COMMENT":
            continue
        key, sign, value = line.partition("=")
        key = omm.keyword(key)
        if key == HEADER:
            if begin:
                yield omm.read_message(fields, source, begin, fault=fault, fault_line=fault_line)
            fields, begin, fault = {}, number, None
            continue
        if fault is not None:
            continue
        begin = begin or number
        try:
            if not sign:
                raise RowError(f"{shown(line)!r} is not KEYWORD = value")
            if len(raw) > LONGEST_KVN_LINE:
                raise RowError(f"the line is longer than {LONGEST_KVN_LINE} characters")
            if key in omm.FIELDS:
                if key in fields:
                    raise RowError(f"field {key} is given twice in one message")
                fields[key] = _without_unit(key, value.strip())
        except RowError as error:
            fault, fault_line = error, number
    if begin:
        yield omm.read_message(fields, source, begin, fault=fault, fault_line=fault_line)


def _without_unit(key: str, value: str) -> str:
    if key in omm.UNITS and value.endswith("]") and "[" in value:
        value, _, unit = value[:-1].rpartition("[")
        omm.check_unit(key, unit)
    return value.strip()


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
            yield from reader.drained()
            detail = f"not well-formed XML: {expat.ErrorString(error.code)}"
            yield Dropped(source, error.lineno, omm.label(reader.fields), "malformed", detail)
            return
        yield from reader.drained()
        if begin + len(chunk) - max(parser.CurrentByteIndex, 0) > LONGEST_TOKEN + CHUNK:
            raise InputError(
                f"{source}: line {parser.CurrentLineNumber}: a tag or a comment longer than "
                f"{LONGEST_TOKEN >> 20} MiB; this is no OMM"
            )


class _Reader(XmlReader):
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

    def drained(self) -> list[ElementSet | Dropped]:
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
