"""The file of a future: its settings, then a line for each year, appended as it is done.

A killed run goes on from it: plans, rates and draws of its years are taken from the file, and all
that follows from them is worked out again and has to agree.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ...common.errors import InputError
from ...common.files import write_both
from .records import YearRecord, records_of

FORMAT = "adr-opt-scenario/1"

PLANS = "plans"
"""Folder of instances and plans."""


class YearsFile:
    """The file of one seed.

    Parameters
    ----------
    folder : path
    seed : int
    digest : str
        Of all that the futures depend on.

    Attributes
    ----------
    found : list of dict
        Years of an earlier run: case → record.

    Raises
    ------
    InputError
        It cannot be read, or is of another scenario.
    """

    def __init__(self, folder: str | os.PathLike[str], seed: int, digest: str) -> None:
        self._path = Path(folder) / f"seed-{seed}.jsonl"
        self._header = {"format": FORMAT, "seed": seed, "digest": digest}
        self.found: list[dict[str, YearRecord]] = []
        try:
            Path(folder).mkdir(parents=True, exist_ok=True)
            content = self._path.read_bytes() if self._path.exists() else b""
            whole = content[: content.rfind(b"\n") + 1]  # a line that was cut off is done again
            lines = whole.splitlines()
            if not lines:
                self._path.write_bytes(_line(self._header))
                return
            self._check(lines[0])
            self.found = [self._year(line, at) for at, line in enumerate(lines[1:])]
            if len(whole) < len(content):
                os.truncate(self._path, len(whole))
        except OSError as error:
            raise InputError(
                f"{self._path}: cannot be written ({error.strerror or error}); name another folder"
            ) from error

    def append(self, year: dict[str, YearRecord]) -> None:
        """Write a year.

        Raises
        ------
        InputError
            It cannot be written.
        """
        line = _line({case: record.to_dict() for case, record in year.items()})
        try:
            with self._path.open("ab") as file:
                file.write(line)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise InputError(
                f"{self._path}: cannot be written ({error.strerror or error}); name another folder"
            ) from error

    def keep(self, year: int, instance: str, plan: str) -> None:
        """Write the instance of a campaign and its first plan, for other verbs.

        Raises
        ------
        InputError
            They cannot be written.
        """
        folder = self._path.parent / PLANS
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{folder}: cannot be made ({error.strerror or error}); name another folder"
            ) from error
        stem = f"{self._path.stem}-year-{year}"
        write_both(folder / f"{stem}.plan.json", plan, folder / f"{stem}.json", instance)

    def _check(self, line: bytes) -> None:
        try:
            header = json.loads(line)
        except ValueError:
            header = None
        if not isinstance(header, dict) or header.get("format") != FORMAT:
            raise InputError(f"{self._path}: not a file of a scenario; name another folder")
        if header != self._header:
            raise InputError(
                f"{self._path}: of another catalogue, campaign or other settings; name another "
                "folder, or repeat the call that made it"
            )

    def _year(self, line: bytes, at: int) -> dict[str, YearRecord]:
        try:
            return records_of(line)
        except ValueError:
            raise InputError(
                f"{self._path}: line {at + 2}: not a year of a scenario; name another folder"
            ) from None


def _line(content: dict[str, Any]) -> bytes:
    return json.dumps(content, sort_keys=True, separators=(",", ":")).encode() + b"\n"
