"""The file of a future: its settings, then a line for each year, appended as it is done.

A killed run goes on from it: plans, rates and draws of its years are taken from the file, and all
that follows from them is worked out again and has to agree.
"""

from __future__ import annotations

import os
from pathlib import Path

from ...common.errors import InputError
from ...common.files import check_writable, write_both
from ...common.json_text import parse_json
from ...common.lines_file import LinesFile
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
        try:
            Path(folder).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{self._path}: cannot be written ({error.strerror or error}); name another folder"
            ) from error
        check_writable(self._path)
        head = {"format": FORMAT, "seed": seed, "digest": digest}
        self._lines = LinesFile(self._path, head, "a file of a scenario")
        self.found = [_year(where, line) for where, line in self._lines.read(_of_other)]

    def append(self, year: dict[str, YearRecord]) -> None:
        """Write a year.

        Raises
        ------
        InputError
            It cannot be written.
        """
        self._lines.append({case: record.to_dict() for case, record in year.items()})

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


def _of_other(key: str) -> str:
    return (
        "of another catalogue, campaign or other settings; name another folder, or repeat the call "
        "that made it"
    )


def _year(where: str, line: bytes) -> dict[str, YearRecord]:
    otherwise = "not a year of a scenario; name another folder"
    parse_json(line, where, otherwise)
    try:
        return records_of(line)
    except (ValueError, RecursionError):
        raise InputError(f"{where}: {otherwise}") from None
