"""Recognition of dropped files by their content."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ....analysis.screening import position_errors
from ....analysis.windows import stations
from ....common.errors import InputError
from ....common.files import parse_model
from ....common.json_text import parse_json
from ....plan.plan import Plan
from ....problem.instance import Instance
from ....problem.uncertainty import Uncertainty
from ....sources import catalogue, worth
from ....sources.catalogue.reading import read_bytes
from ....sources.ephemerides.oem import read_oem
from ....sources.file_formats import HEAD, ephemeris_format, head_of
from ..project.record import Content

MOST_BAD = 5
"""Number of a file's bad rows listed one by one."""


@dataclass(frozen=True)
class Recognised:
    """What a file holds.

    Attributes
    ----------
    what : str
    count, skipped : int
        Of the rows in it, those that are good and bad.
    bad : tuple of str
        The first bad rows, with place and reason.
    content : Instance, Plan, Catalogue or None
        Of an instance, a plan or a catalogue.
    """

    what: Content
    count: int
    skipped: int = 0
    bad: tuple[str, ...] = ()
    content: Instance | Plan | catalogue.Catalogue | None = None


def recognised(path: Path, name: str) -> Recognised:
    """What a file holds, which is read as the command line reads it.

    Parameters
    ----------
    path : path
    name : str
        Name that errors give it.

    Raises
    ------
    InputError
        It is nothing that can be used, or it is spoilt.
    """
    try:
        return _recognised(path, name)
    except InputError as error:
        raise InputError(str(error).replace(str(path), name)) from None


def _recognised(path: Path, name: str) -> Recognised:
    with path.open("rb") as file:
        head = file.read(HEAD)
    text = head_of(head)
    begin = text.partition("\n")[0]
    if re.search(r'"format"\s*:\s*"adr-opt-', text):
        return _of_the_project(path, name)
    is_oem = text.startswith("CCSDS_OEM_VERS") or re.search(r"<(\w+:)?oem\b", text)
    if is_oem or ephemeris_format(text):
        return Recognised("ephemerides", len(read_oem(path.read_bytes(), name)))
    if begin.startswith("#JCAT") or "\n#JCAT" in text:
        return Recognised("satcat", len(worth.read_satcat(path)))
    if begin.strip() == ",".join(position_errors.COLUMNS):
        return Recognised("errors", len(position_errors.read_errors(path)))
    if begin.strip() == ",".join(stations.COLUMNS):
        return Recognised("ground stations", len(stations.read_stations(path)))
    columns = {cell.strip().casefold() for cell in begin.split(",")}
    if columns & {"prize", "required", "prize_until"} and columns & {"object", "number", "name"}:
        return Recognised("prizes", len(catalogue.read_wishes(path)))
    found = read_bytes(path.read_bytes(), name, skip_bad=True)
    bad = tuple(each.within for each in found.dropped[:MOST_BAD])
    return Recognised("catalogue", len(found.records), len(found.dropped), bad, found)


def _of_the_project(path: Path, name: str) -> Recognised:
    """A file in one of the formats of this project."""
    try:
        text = path.read_text("utf-8")
    except ValueError:
        raise InputError(f"{name}: not JSON: not text in UTF-8; give a JSON file") from None
    content: Any = parse_json(text, name)
    kind = str(content.get("format") if isinstance(content, dict) else "").partition("/")[0]
    if kind == "adr-opt-instance":
        instance = parse_model(text, Instance, name)
        if any(instance.files_beside):
            raise InputError(
                f"{name}: it refers to other files; open it from the command line, as 'serve "
                "INSTANCE'"
            )
        return Recognised("instance", len(instance.targets), content=instance)
    if kind == "adr-opt-plan":
        plan = parse_model(text, Plan, name)
        return Recognised("plan", len(plan.legs), content=plan)
    if kind == "adr-opt-uncertainty":
        parse_model(text, Uncertainty, name)
        return Recognised("uncertainty", 1)
    raise InputError(f"{name}: a file of the format {kind!r} is of no use here")
