"""OMM as KVN: lines ``KEYWORD = value [unit]``, one message after another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from . import omm
from .records import Dropped, ElementSet, RowError, shown

LONGEST_LINE = 1000
HEADER = "CCSDS_OMM_VERS"


def read_kvn(lines: Iterable[str], source: str) -> Iterator[ElementSet | Dropped]:
    """The records of a KVN file, in their order; a message begins with its version."""
    fields: dict[str, str] = {}
    begin, fault, fault_line = 0, None, 0
    for number, raw in enumerate(lines, 1):
        line = raw[:LONGEST_LINE].strip()
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
            if len(raw) > LONGEST_LINE:
                raise RowError(f"the line is longer than {LONGEST_LINE} characters")
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
