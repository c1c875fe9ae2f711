"""Results of a project, each in a folder of its own, complete or absent."""

from __future__ import annotations

import re
import shutil
import threading
from collections import OrderedDict
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ....common.errors import InputError
from ....common.files import read_model, write_text
from ....judge.admit import admit
from ....plan.plan import Plan
from ....problem.instance import Instance
from .plan_files import INSTANCE, NOT_LEGAL, PLAN, load_kept, of_plan, unfinished
from .private import private_folder
from .record import KEPT_VERBS, ResultRecord

RECORD = "result.json"

PLANS_READY = 32
"""Number of cached plans."""


class Results:
    """The folder ``results`` of a project.

    Parameters
    ----------
    folder : path
        Made when the first result is kept.

    Attributes
    ----------
    revision : int
        Counts changes.
    found_again : list of int
        Results of runs that a killed server left unfinished.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.revision = 0
        self.found_again: list[int] = []
        self._lock = threading.RLock()
        self._records: dict[int, ResultRecord] = {}
        self._places: dict[int, Path] = {}
        self._ready: OrderedDict[int, tuple[Instance, Plan]] = OrderedDict()
        self._last = 0

    def read(self) -> None:
        """Read the results, and remove those that a killed server left unfinished.

        Of a planning run the best plan so far is kept. What is no result, by the number and the
        verb in its name, is left where it is.
        """
        for path in list(self.folder.iterdir()) if self.folder.is_dir() else ():
            found = re.fullmatch(r"([0-9]{4,6})-([a-z]+)", path.name)
            if found is None or found[2] not in KEPT_VERBS:
                continue
            if path.is_symlink() or not path.is_dir():
                continue
            self._last = max(self._last, int(found[1]))
            if not (path / RECORD).exists():
                record = unfinished(path, int(found[1]), found[2])
                if record is None:
                    shutil.rmtree(path, ignore_errors=True)
                else:
                    self.found_again.append(self.done(record).number)
                continue
            with suppress(InputError):
                record = read_model(path / RECORD, ResultRecord)
                if record.number == int(found[1]):
                    self._records[record.number], self._places[record.number] = record, path

    def all(self) -> list[ResultRecord]:
        """All results, the newest last."""
        with self._lock:
            return [self._records[number] for number in sorted(self._records)]

    def record(self, number: int) -> ResultRecord:
        """The record of a result.

        Raises
        ------
        InputError
            There is none of that number.
        """
        with self._lock:
            if number not in self._records:
                raise InputError(f"there is no result {number}")
            return self._records[number]

    def place(self, number: int) -> Path:
        """The folder of a result."""
        self.record(number)
        return self._places[number]

    def begin(self, verb: str) -> tuple[int, Path]:
        """Number and folder of a new result, which counts once it is :meth:`done`."""
        with self._lock:
            self._last += 1
            number = self._last
        return number, private_folder(private_folder(self.folder) / f"{number:04d}-{verb}")

    def done(self, record: ResultRecord) -> ResultRecord:
        """Adopt a new result, whose files are complete, with its record."""
        place = self.folder / f"{record.number:04d}-{record.verb}"
        files = sorted(path.name for path in place.iterdir() if path.name != RECORD)
        record = record.replace(files=tuple(files))
        write_text(place / RECORD, record.to_json())
        with self._lock:
            self._records[record.number], self._places[record.number] = record, place
            self.revision += 1
        return record

    def drop(self, place: Path) -> None:
        """Remove the folder of an abandoned result."""
        shutil.rmtree(place, ignore_errors=True)

    def keep_plan(
        self,
        verb: str,
        label: str,
        instance: Instance,
        plan: Plan,
        begun: tuple[int, Path] | None = None,
        **more: Any,
    ) -> ResultRecord:
        """Keep a plan with its instance as a new result.

        Parameters
        ----------
        verb, label : str
        instance : Instance
        plan : Plan
        begun : (int, path), optional
            As :meth:`begin` gives it, and left with what is in it if the plan cannot be kept; by
            default a new one.
        **more
            Further fields of the record.
        """
        number, place = begun or self.begin(verb)
        try:
            instance.save(place / INSTANCE)
            plan.save(place / PLAN)
            record = ResultRecord(
                number=number,
                verb=verb,
                label=label,
                made_at=now(),
                **of_plan(admit(instance, plan, unjudged=True)),
                **more,
            )
            record = self.done(record)
        except BaseException:
            if begun is None:
                self.drop(place)
            raise
        with self._lock:
            self._remember(number, (instance, plan))
        return record

    def plan(self, number: int) -> tuple[Instance, Plan]:
        """Plan of a result, with its instance.

        Raises
        ------
        InputError
            It has none, or that is spoilt.
        """
        record = self.record(number)
        if not record.has_plan:
            raise InputError(f"result {number} ({record.verb}) is not a plan; name one that is")
        with self._lock:
            if number not in self._ready:
                admitted = load_kept(self._places[number])
                self._remember(number, (admitted.instance, admitted.plan))
            self._ready.move_to_end(number)
            return self._ready[number]

    def newest_of(self, instance_sha256: str) -> int | None:
        """Number of the newest plan of an instance; None if there is none."""
        with self._lock:
            for number in sorted(self._records, reverse=True):
                record = self._records[number]
                if record.instance_sha256 == instance_sha256 and record.has_plan:
                    return number
        return None

    def legal_of(self, instance_sha256: str) -> list[ResultRecord]:
        """Legal plans of an instance, the best first."""
        found = (
            record
            for record in self.all()
            if record.has_plan
            and record.instance_sha256 == instance_sha256
            and record.status != NOT_LEGAL
        )
        return sorted(found, key=lambda record: -(record.objective or 0.0))

    def _remember(self, number: int, known: tuple[Instance, Plan]) -> None:
        self._ready[number] = known
        while len(self._ready) > PLANS_READY:
            self._ready.popitem(last=False)


def now() -> datetime:
    """The time, to the second."""
    return datetime.now(UTC).replace(microsecond=0)
