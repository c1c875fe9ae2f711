"""OMM as JSON: a list of objects, or a single one, as served by CelesTrak and Space-Track."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

from ...common.errors import InputError
from . import omm
from .records import Dropped, ElementSet, RowError, shown

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
    if isinstance(item, dict) and not any(omm.keyword(key) in omm.FIELDS for key in item):
        raise InputError(
            f"{source}: a JSON object that is no OMM but says {shown(json.dumps(item), 60)}; "
            "download the catalogue again"
        )
