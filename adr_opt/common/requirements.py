"""Requirements: the packages that adr-opt needs, as its metadata state them."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires, version

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
        """Whether a version will do."""
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
    """All that adr-opt needs; nothing where it has not been installed."""
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
