"""Which key of a file format somebody meant who wrote another one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches
from inspect import isclass
from typing import Any, get_args

from pydantic import BaseModel

LEAST_ALIKE = 0.6
"""Share of letters that two keys have in common, by difflib, below which neither was the other."""


def meant(title: str, place: Sequence[int | str], among: Iterable[str] = ()) -> str | None:
    """The key that one that is unknown was probably meant for; None where none is like it.

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
    """The models that a type is made of, as those of a list or of several kinds."""
    if isclass(annotation) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models_in(part)
