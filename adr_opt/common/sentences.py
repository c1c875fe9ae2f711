"""Validation errors in one sentence, with the intended key if one is misspelt."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches
from inspect import isclass
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from .wording import cut

LEAST_ALIKE = 0.6
"""Smallest similarity (difflib) at which an unknown key counts as a misspelling of another."""


KINDS = {"(station)", "(orbit)", "(word)", "(delta-v)", "(mass)", "(circle)", "(perigee)"}
"""Tags of union members in pydantic's error locations, which are no keys of a file."""

PLAINER = (
    (r"^Input should be an object$", "must be a JSON object {…}"),
    (r"^Input should be a valid array$", "must be a JSON list […]"),
    (r"^Input should be a valid datetime.*", "must be a time like 2026-01-01T00:00:00Z"),
    (r"^Input should have timezone info$", "must say its time zone, like 2026-01-01T00:00:00Z"),
    (r"^Input should be a valid ", "must be a "),
    (r"^must be a integer", "must be an integer"),
    (r"^Input should ", "must "),
    (r"^String should have at least 1 character$", "must not be empty"),
    (r"^Tuple should have at least 1 item .*", "must not be empty"),
    (
        r"^String should match pattern .*parquet.*",
        "must be the name of a file beside this one, without folders, as costs.parquet or costs.nc",
    ),
    (r"^String should match pattern .*x00.*", "must not contain a NUL character"),
    (r"^String should match pattern ", "must match "),
)
"""Messages of pydantic, reworded for users of the files."""


def sentence(error: ValidationError) -> str:
    """The first validation error as a sentence: field, value, what to do."""
    details = error.errors(include_url=False)
    first = details[0]
    if first["type"] == "json_invalid":
        return f"not JSON: {first['ctx']['error']}; give a JSON file"
    first, instead, explained = _misspelt(error.title, details)
    field = ""
    for part in first["loc"]:
        if part in KINDS:
            continue
        key = cut(str(part))
        field += f"[{part}]" if isinstance(part, int) else f".{key}" if field else key
    said = first["msg"].removeprefix("Value error, ")
    for pattern, plain in PLAINER:
        said = re.sub(pattern, plain, said)
    said = said[0].lower() + said[1:] if said else "invalid"
    others = len(details) - 1 - explained
    more = f" (and {others} more)" if others else ""
    if first["loc"] == ("format",) and first["type"] == "literal_error":
        # All other errors follow from this one.
        same = f"'{str(first['input']).partition('/')[0]}/" in first["msg"]
        more = f"; this is {'another version of it' if same else 'a file of another kind'}"
    if not field:
        # a rule between fields, which names them itself
        return f"{said if re.match(r'field |[a-z_]+ = ', said) else 'the file ' + said}{more}"
    if first["type"] == "missing":
        return f"field {field}: missing; add it{more}"
    if instead is not None:
        return f"field {field}: unknown; did you mean {instead}?{more}"
    if first["type"] == "extra_forbidden":
        return f"field {field}: unknown; remove it or correct its name{more}"
    value: Any = first["input"]
    shown = ""
    if not isinstance(value, (dict, list, tuple, BaseModel)):
        shown = f" = {cut(_as_in_json(value))}"
    return f"field {field}{shown}: {said}{more}"


def _misspelt(title: str, details: Sequence[ErrorDetails]) -> tuple[ErrorDetails, str | None, int]:
    """The first error, or the unknown key that explains it, with the key that was probably meant.

    And how many of the other errors are explained by it: a key that is missing but for a typo.
    """
    first = details[0]
    if first["type"] not in ("missing", "extra_forbidden"):
        return first, None, 0
    beside = [each for each in details if each["loc"][:-1] == first["loc"][:-1]]
    lacking = [str(each["loc"][-1]) for each in beside if each["type"] == "missing"]
    for each in beside:
        if each["type"] == "extra_forbidden":
            instead = meant(title, each["loc"], lacking)
            if each is first or instead == first["loc"][-1]:
                return each, instead, int(instead in lacking)
    return first, None, 0


def _as_in_json(value: Any) -> str:
    try:
        return json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError):  # not from a file: a value given in Python
        return repr(value)


def meant(title: str, place: Sequence[int | str], among: Iterable[str] = ()) -> str | None:
    """The known key most like an unknown one; None if none is similar.

    Parameters
    ----------
    title : str
        Name of the class that the whole file is of, as an error of validation says it.
    place : sequence of int or str
        Where the unknown key stands in the file: keys and places in lists, the key itself last.
    among : iterable of str
        Keys that are known to be missing there, which are preferred.
    """
    *way, key = place
    for known in (list(among), _keys_at(title, way)):
        found = get_close_matches(str(key), known, n=1, cutoff=LEAST_ALIKE)
        if found:
            return found[0]
    return None


def _keys_at(title: str, way: Iterable[int | str]) -> list[str]:
    here = {
        each
        for each in _below(BaseModel)
        if each.__name__ == title and each.__module__.startswith("adr_opt.")
    }
    for part in way:
        there = [each.model_fields[part] for each in here if part in each.model_fields]
        if there:  # places in lists, and which of several kinds it is, lead nowhere new
            here = {each for field in there for each in _models_in(field.annotation)}
    return sorted({key for each in here for key in each.model_fields})


def _below(model: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for each in model.__subclasses__():
        yield each
        yield from _below(each)


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """The models within a type, as in lists or unions."""
    if isclass(annotation) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models_in(part)
