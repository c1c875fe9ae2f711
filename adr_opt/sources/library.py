"""The library of instances: names, with the SHA-256 of the generated file.

`instances/library.json` of the repository lists it, so that hundreds of instances take a few
kilobytes and a name still stands for the same bytes everywhere. `instances/write.py` writes the
files.
"""

from __future__ import annotations

import os
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ..common.errors import InputError
from ..common.files import read_model, to_text
from ..common.records import Name, Record
from ..problem.instance import Instance
from .generator import by_name, family_of

FORMAT: Literal["adr-opt-library/1"] = "adr-opt-library/1"


class Entry(Record):
    """One instance of the library: its name (family and seed) and its SHA-256."""

    name: Name
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]

    @property
    def family(self) -> str:
        """The family, from the name."""
        return family_of(self.name)

    def generate(self) -> Instance:
        """Generate the instance.

        Raises
        ------
        InputError
            It is not, byte for byte, what the library lists.
        """
        made = by_name(self.name)
        if made.sha256 != self.sha256:
            raise InputError(
                f"instance {self.name!r}: generated with sha256 {made.sha256[:12]}…, but the "
                f"library lists {self.sha256[:12]}…; use the library that came with this generator"
            )
        return made


class Library(Record):
    """The file ``adr-opt-library/1``.

    Attributes
    ----------
    version : str
        Of the contents: the first number rises when an instance changes or goes, the second when
        instances are added. Cite it.
    instances : tuple of Entry
    """

    format: Literal["adr-opt-library/1"] = FORMAT
    version: Annotated[str, Field(pattern=r"^\d+\.\d+$")]
    instances: Annotated[tuple[Entry, ...], Field(strict=False)]

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        seen = set()
        for number, entry in enumerate(self.instances):
            if entry.name in seen:
                raise ValueError(
                    f"field instances[{number}].name = {entry.name!r}: listed twice; remove one"
                )
            seen.add(entry.name)
        return self

    def find(self, name: str) -> Entry | None:
        """The entry with a name; None if there is none."""
        return next((entry for entry in self.instances if entry.name == name), None)

    def of_family(self, name: str) -> tuple[Entry, ...]:
        """The entries of a family, in order."""
        return tuple(entry for entry in self.instances if entry.family == name)

    def to_json(self) -> str:
        """The library file."""
        return to_text(self.model_dump(mode="json"))


def load_library(path: str | os.PathLike[str]) -> Library:
    """Read a library file.

    Raises
    ------
    InputError
        No such file, not JSON, or not a valid library.
    """
    return read_model(path, Library)
