"""File of outcomes: JSON lines, one for each rehearsal, so that a run can be resumed.

The first line says what they belong to. Of a line that was cut off nothing is read.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path

from ...common.errors import InputError
from ...common.files import check_writable, read_text
from .outcome import Outcome

FORMAT = "adr-opt-rehearsals/1"


class OutcomeFile:
    """Outcomes in a file, written as they come.

    Parameters
    ----------
    path : path
        It may be there from an earlier call.
    digest : str
        Of everything that outcomes depend on.

    Attributes
    ----------
    found : tuple of Outcome
        What was there.

    Raises
    ------
    InputError
        It is there and is not such a file, or one of another mission, plan, policy or uncertainty.
    """

    def __init__(self, path: str | os.PathLike[str], digest: str) -> None:
        self._path, self._digest = Path(path), digest
        check_writable(path)
        self.found = self._read() if self._path.exists() else ()

    def append(self, outcomes: Sequence[Outcome]) -> None:
        """Write outcomes at once.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        text = "".join(json.dumps(each.to_dict()) + "\n" for each in outcomes)
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

    def _read(self) -> tuple[Outcome, ...]:
        lines = read_text(self._path).splitlines()
        if not lines:
            return ()
        try:
            head = json.loads(lines[0])
            known = isinstance(head, dict) and head.get("format") == FORMAT
        except json.JSONDecodeError:
            known = False
        if not known:
            raise InputError(f"{self._path}: not a file of rehearsals; name another file")
        if head.get("of") != self._digest:
            raise InputError(
                f"{self._path}: has rehearsals of another mission, plan, policy or uncertainty; "
                "name another file"
            )
        found = []
        for number, line in enumerate(lines[1:], start=2):
            try:
                content = json.loads(line)
            except json.JSONDecodeError:
                continue  # cut off
            try:
                found.append(Outcome.from_dict(content))
            except (KeyError, TypeError):
                raise InputError(
                    f"{self._path}: line {number} is no rehearsal; name another file"
                ) from None
        return tuple(found)
