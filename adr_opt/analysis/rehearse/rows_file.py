"""Files of JSON lines, one for each rehearsal or bound, so that a run can be resumed.

The first line says what they belong to. Of a line that was cut off nothing is read.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from pydantic import ConfigDict, TypeAdapter, ValidationError

from ...common.errors import InputError
from ...common.files import check_writable, read_text
from ...common.json_text import REPEATED, parse_json, validated
from ...common.sentences import sentence

FORMAT = "adr-opt-rehearsals/1"

EXACT = ConfigDict(strict=True, allow_inf_nan=False, extra="forbid")
"""How the data classes of rows are read: of the types that they state, and finite."""


class AsData(Protocol):
    """What a line holds."""

    def to_dict(self) -> dict[str, Any]:
        """As JSON data."""
        ...


R = TypeVar("R", bound=AsData)


class RowsFile(Generic[R]):
    """Rows in a file, written as they come.

    Parameters
    ----------
    path : path
        It may be there from an earlier call.
    digest : str
        Of everything that rows depend on.
    kind : type
        Data class of the rows.

    Attributes
    ----------
    found : tuple of rows
        What was there.

    Raises
    ------
    InputError
        It is there and is not such a file, or one of another mission, plan, policy or uncertainty.
    """

    def __init__(self, path: str | os.PathLike[str], digest: str, kind: type[R]) -> None:
        self._path, self._digest, self._kind = Path(path), digest, TypeAdapter(kind)
        check_writable(path)
        self.found: tuple[R, ...] = self._read() if self._path.exists() else ()

    def append(self, rows: Sequence[R]) -> None:
        """Write rows at once.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        text = "".join(json.dumps(each.to_dict()) + "\n" for each in rows)
        try:
            with self._path.open("ab+") as file:
                size = file.tell()
                if size == 0:
                    text = json.dumps({"format": FORMAT, "of": self._digest}) + "\n" + text
                else:
                    file.seek(size - 1)
                    if file.read(1) != b"\n":
                        text = "\n" + text
                file.write(text.encode())
        except OSError as error:
            raise InputError(
                f"{self._path}: cannot be written ({error.strerror or error}); choose another place"
            ) from error

    def _read(self) -> tuple[R, ...]:
        lines = read_text(self._path).splitlines()
        if not lines:
            return ()
        other_file = "not a file of rehearsals; name another file"
        head = parse_json(lines[0], str(self._path), other_file)
        if not isinstance(head, dict) or head.get("format") != FORMAT:
            raise InputError(f"{self._path}: {other_file}")
        if head.get("of") != self._digest:
            raise InputError(
                f"{self._path}: has rehearsals of another mission, plan, policy or uncertainty; "
                "name another file"
            )
        found = []
        for number, line in enumerate(lines[1:], start=2):
            try:
                found.append(validated(self._kind, line))
            except ValidationError as error:
                if error.errors()[0]["type"] == "json_invalid":
                    continue  # cut off
                if error.errors()[0]["type"] == REPEATED:
                    raise InputError(f"{self._path}: line {number}: {sentence(error)}") from None
                raise InputError(
                    f"{self._path}: line {number} is no rehearsal or bound; name another file"
                ) from None
        return tuple(found)
