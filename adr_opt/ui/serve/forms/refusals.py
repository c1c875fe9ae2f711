"""Refusals in the words of forms: labels and units in place of field names and options."""

from __future__ import annotations

import re
from collections.abc import Iterable

from ....common.json_text import loaded
from .fields import SHOWN, WORDS, unit_of
from .options import JobOption

ELEMENTS = {
    "chasers": "chaser",
    "stations": "station",
    "targets": "target",
    "keep_out_zones": "keep-out zone",
}
"""Elements of lists of an instance, in words."""

PLACE = re.compile(
    r"^(?:the file|field ([a-z_]+)(?:\[(\d+)\])?[a-z_.]*:) "
    r"(?=(?:field )?[a-z]+[a-z_.]*_[a-z_]+ = |must give )"
)
"""Beginning of a sentence on a rule between fields, which names them itself."""

TERM = re.compile(
    r"(?P<field>field )?(?P<path>(?:[a-z_]+(?:\[\d+\])?\.)*)\b(?P<name>[a-z]+(?:_[a-z]+)*)\b"
    r"(?: = (?P<value>\[[^\]]*\]|\"[^\"]*\"|'[^']*'|[^\s:;]+))?"
)
"""A field, with the way to it and its value, as sentences on files have them."""

ELEMENT = re.compile(r"\b(chasers|stations|targets|keep_out_zones)\[(\d+)\]")

LIMIT = re.compile(r"(?P<than>(?:at least|at most|more than|less than)) (?P<value>-?[\d.e+]+)")

PLAINER = (
    (r" \(and \d+ more\)$", ""),
    (r"greater than or equal to", "at least"),
    (r"less than or equal to", "at most"),
    (r"must be greater than", "must be more than"),
    (r"must be an integer", "must be a whole number"),
    (r" = null: must be a (?:number|string)", " must be given"),
    (r": missing; add it$", " must be given"),
    (r": missing, and", " must be given:"),
    (r"; write exactly one of the two", "; give one of the two"),
)


def in_labels(sentence: str, options: Iterable[JobOption] = ()) -> str:
    """A sentence with labels and units of fields, as forms have them.

    Parameters
    ----------
    sentence : str
        About a file, or of the command line.
    options : sequence of JobOption
        Those of the command line that it may name.
    """
    labels = {option.sign: f"“{option.label}”" for option in options if option.sign}
    said = re.sub(r"--[a-z][a-z-]*", lambda sign: labels.get(sign[0], sign[0]), sentence)
    for pattern, plain in PLAINER:
        said = re.sub(pattern, plain, said)
    place = PLACE.match(said)
    whose = ""
    if place:
        said = said[place.end() :]
        whose = _whose(place[1] or "", place[2])
    units: list[tuple[str, float]] = []

    def labelled(found: re.Match[str]) -> str:
        name, value = found["name"], found["value"]
        stands_for_field = "_" in name or value is not None or found["field"] or found["path"]
        if name not in WORDS or not stands_for_field:
            return found[0]
        unit, by = SHOWN.get(name, (unit_of(name), 1.0))
        element = ELEMENT.match(found["path"])
        of = _whose(*element.groups()) if element else whose if not units else ""
        units.append((unit, by))
        label = WORDS[name].label
        if value is None:
            return f"“{label}{f' [{unit}]' if unit else ''}”{of}"
        return f"“{label}”{of} = {_shown(value, unit, by)}"

    said = ELEMENT.sub(lambda found: _whose(*found.groups())[4:], TERM.sub(labelled, said))
    said = said.replace(": must ", " must ")
    if len(units) == 1:
        unit, by = units[0]
        said = LIMIT.sub(lambda found: f"{found['than']} {_shown(found['value'], unit, by)}", said)
    return said


def _whose(part: str, number: str | None) -> str:
    """Which element of a list a field belongs to, counted from 1; empty for what is no element."""
    element = ELEMENTS.get(part)
    return "" if element is None or number is None else f" of {element} {int(number) + 1}"


def _shown(written: str, unit: str, by: float) -> str:
    """A value of a file in the unit of its form; what is no number as it is."""
    try:
        value = loaded(written)
    except ValueError:
        return written
    if value is None:
        return "nothing"
    values = value if isinstance(value, list) else [value]
    if any(isinstance(each, str | bool | dict) for each in values):
        return written
    shown = " to ".join("no end" if each is None else f"{each / by:.6g}" for each in values)
    return f"{shown} {unit}".rstrip()
