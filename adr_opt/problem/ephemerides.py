"""Ephemerides beside an instance: which files hold them, their digest, and copies of them."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ..common.errors import InputError
from ..common.files import write_bytes
from ..common.records import Name, Record

EphemerisKind = Literal["elements", "oem"]

FileName = Annotated[Name, Field(pattern=r"^[^/\\\x00]+$")]

Digest = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class EphemeridesFile(Record):
    """Reference to the files with the ephemerides of bodies, beside that of the instance.

    ``kind`` "elements": one file of element sets, run by SGP4; "oem": CCSDS Orbit Ephemeris
    Messages, one file or a list. ``sha256`` is that of the file; of several, of their content one
    after the other.
    """

    kind: EphemerisKind
    file: FileName | Annotated[tuple[FileName, ...], Field(strict=False, min_length=2)]
    sha256: Digest

    @model_validator(mode="after")
    def _different_files(self) -> Self:
        if len(set(self.files)) < len(self.files):
            raise ValueError("field file: a file is listed twice; list it once")
        if self.kind == "elements" and len(self.files) > 1:
            raise ValueError("field file: element sets stand in one file; name that")
        return self

    @property
    def files(self) -> tuple[str, ...]:
        """Names of the files."""
        return (self.file,) if isinstance(self.file, str) else self.file

    def contents(self, folder: str | os.PathLike[str]) -> dict[str, bytes]:
        """The content of each file in a folder, whose digest is the one stated.

        Raises
        ------
        InputError
            A file is missing, or they are others than stated.
        """
        found = {}
        for name in self.files:
            path = Path(folder, name)
            try:
                found[name] = path.read_bytes()
            except FileNotFoundError:
                raise InputError(f"{path}: no such file; put the ephemerides there") from None
            except OSError as error:
                raise InputError(f"{path}: cannot be read ({error.strerror})") from None
        digest = digest_of(found.values())
        if digest != self.sha256:
            raise InputError(
                f"{Path(folder, self.files[0])}: not the ephemerides that the instance names: "
                f"their sha256 is {digest}; put the right files there, or import anew"
            )
        return found

    def copy_files(self, source: str | os.PathLike[str], folder: str | os.PathLike[str]) -> None:
        """Copy the files from one folder into another, where they are not there yet.

        Raises
        ------
        InputError
            A file is missing or another than stated, or cannot be written.
        """
        if Path(source).resolve() == Path(folder).resolve():
            return
        for name, content in self.contents(source).items():
            path = Path(folder, name)
            if not path.is_file() or path.read_bytes() != content:
                write_bytes(path, content)


def digest_of(contents: Iterable[bytes]) -> str:
    """SHA-256 of contents one after the other."""
    digest = hashlib.sha256()
    for content in contents:
        digest.update(content)
    return digest.hexdigest()
