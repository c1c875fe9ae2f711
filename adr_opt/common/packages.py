"""Entry points of installed packages, and a foreign package that hides ours."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .errors import InputError

HIDEABLE = "solvers"
"""Package that comes with adr-opt under a name that others use as well."""

INSTALLED = Path(__file__).parents[2]
"""Folder that holds both packages of adr-opt."""


def load(entry: EntryPoint) -> Any:
    """The object that an entry point names, imported.

    Raises
    ------
    InputError
        A foreign package hides the one that it is in.
    ImportError, AttributeError
        It is not where it is said to be.
    """
    if entry.module.partition(".")[0] == HIDEABLE:
        foreign = foreign_package()
        if foreign is not None:  # before its code runs
            raise InputError(f"{entry.name!r} cannot be imported: {foreign}")
    return entry.load()


def foreign_package() -> str | None:
    """The foreign package ``solvers`` that Python finds in place of ours, in a sentence."""
    try:
        spec = find_spec(HIDEABLE)
    except ValueError:  # a module without a specification, as programs make them
        return f"a module named {HIDEABLE!r} hides the one of adr-opt; give it another name"
    if spec is None:
        return f"the package {HIDEABLE!r} of adr-opt is not in {INSTALLED}; install adr-opt again"
    ours = (INSTALLED / HIDEABLE).resolve()
    places = [place for place in (*(spec.submodule_search_locations or ()), spec.origin) if place]
    if any(Path(place).resolve() == ours for place in places):
        return None
    return (
        f"another package named {HIDEABLE!r} hides the one of adr-opt: {places[0]}; rename or "
        "uninstall it, or start from another folder"
    )
