"""Installed packages: entry points, requirements of adr-opt, and packages that hide ``solvers``."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import EntryPoint, PackageNotFoundError, requires, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .errors import InputError

HIDEABLE = "solvers"
"""Package of adr-opt whose name other packages use as well, and so may hide it."""

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


OURS = "adr-opt"

_STATED = re.compile(
    r"(?P<package>[\w.-]+)(\[(?P<parts>[\w,-]+)\])?\s*(?P<bounds>[^;]*?)\s*"
    r"(;.*\bextra == ['\"](?P<extra>[\w-]+)['\"])?"
)


@dataclass(frozen=True)
class Requirement:
    """A package that is needed, always or by an extra.

    Attributes
    ----------
    package : str
    bounds : str
        Versions that will do, as "!=1.15.0,>=1.10"; empty for all.
    extra : str
        Empty for what is always needed.
    parts : tuple of str
        Extras that are meant, where the package is adr-opt itself.
    """

    package: str
    bounds: str
    extra: str = ""
    parts: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.package}{self.bounds}"

    def allows(self, found: str) -> bool:
        """Whether a version meets the requirement."""
        for bound in filter(None, self.bounds.split(",")):
            sign, limit = bound[:2], _numbers(bound[2:])
            if sign == "!=" and _numbers(found) == limit:
                return False
            if sign == ">=" and _numbers(found) < limit:
                return False
        return True


def _numbers(text: str) -> tuple[int, ...]:
    """A version as numbers, 1.10 and 1.10.0 the same."""
    found = [int(part) for part in re.findall(r"\d+", text.partition("+")[0])]
    return (*found, 0, 0, 0, 0)[:4]


def requirements(state: Callable[[str], list[str] | None] = requires) -> tuple[Requirement, ...]:
    """All requirements of adr-opt; none if it is not installed as a package."""
    try:
        stated = state(OURS) or []
    except PackageNotFoundError:
        return ()
    found = [_STATED.fullmatch(text) for text in stated]
    return tuple(
        Requirement(
            each["package"],
            each["bounds"],
            each["extra"] or "",
            tuple((each["parts"] or "").split(",")) if each["parts"] else (),
        )
        for each in found
        if each is not None
    )


def installed(package: str) -> str | None:
    """The version of a package that is installed; None if it is not."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None
