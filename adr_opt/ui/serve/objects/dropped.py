"""Dropped files of a project: catalogue, prizes, and missions made from them."""

from __future__ import annotations

import csv
import re
import threading
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from ....common.errors import InputError
from ....common.files import read_text
from ....plan.plan import Plan
from ....problem.instance import Instance
from ....sources.catalogue import Catalogue
from ....sources.catalogue.reading import load_bytes, read_bytes
from ..forms.refusals import in_labels
from ..project.private import passing, private_folder, refuse_link
from ..project.record import Content, DroppedFile
from ..session import EditingSession
from .catalogue_view import CatalogueView, MissionMade, mission_of
from .import_options import NAMED, wanted_of
from .recognise import Recognised, recognised

ALONE: tuple[Content, ...] = ("errors", "ground stations", "prizes", "satcat", "uncertainty")
"""Contents of which only the latest file counts."""

MOST_FILES = 100
"""Maximum number of dropped files in a project."""

PrizeKind = Literal["one", "worth", "criticality"]
"""Sources of prizes: 1 each, worths or a dropped table, or the ranking of ``import``."""

DETAILS, PRIZES = "details.csv", "prizes.csv"
"""Files of a result of ``worth``."""

NOTHING: dict[str, Any] = {
    "names": [],
    "altitude_km": [],
    "eccentricity": [],
    "inclination_deg": [],
    "raan_deg": [],
    "mass_kg": [],
    "kind": [],
    "worth": [],
    "worth_unit": None,
    "chosen": [],
    "skipped": 0,
    "epoch": None,
}


class DroppedObjects:
    """Objects of the files that were dropped into a session.

    Parameters
    ----------
    session : EditingSession
    """

    def __init__(self, session: EditingSession) -> None:
        self._session = session
        self._folder = session.folder.files
        self._lock = threading.Lock()
        self._parts: dict[str, Catalogue] = {}
        self._view: tuple[tuple[str, ...], CatalogueView] | None = None
        self._worth: tuple[object, list[float | None], str] | None = None

    def of(self, what: Content) -> list[Path]:
        """Files with some content, in the order in which they were dropped."""
        return [
            refuse_link(self._folder / each.file)
            for each in self._session.files
            if each.what == what
        ]

    def latest(self, what: Content) -> Path | None:
        """The latest file with some content; None if there is none."""
        found = self.of(what)
        return found[-1] if found else None

    def drop(self, path: Path, name: str) -> dict[str, Any]:
        """Take an uploaded file into the project; returns what it is, as JSON data.

        Parameters
        ----------
        path : path
            Where it is; it is moved from there if it is kept.
        name : str
            From where it came, for display alone.

        Raises
        ------
        InputError
            It is nothing that can be used, or it is spoilt.
        """
        name = _displayed(name)
        found = recognised(path, name)
        told = {"what": found.what, "count": found.count, "skipped": found.skipped}
        if isinstance(found.content, Instance):
            self._session.begin_anew(found.content, f"{name} dropped")
        elif isinstance(found.content, Plan):
            self._session.adopt(found.content, name)
        else:
            self._keep(path, name, found)
        return told

    def _keep(self, path: Path, name: str, found: Recognised) -> None:
        with self._lock:
            files = self._session.files
            replaced = {
                each.file
                for each in files
                if each.what == found.what and (each.what in ALONE or each.name == name)
            }
            kept = tuple(each for each in files if each.file not in replaced)
            if len(kept) >= MOST_FILES:
                raise InputError(f"{name}: the project has {MOST_FILES} dropped files already")
            number = max((each.number for each in files), default=0) + 1
            file = f"{number}-{_as_file(name)}"
            path.rename(refuse_link(private_folder(self._folder) / file))
            made = DroppedFile(
                file=file,
                name=name,
                what=found.what,
                count=found.count,
                skipped=found.skipped,
                bad=found.bad,
            )
            if isinstance(found.content, Catalogue):
                self._parts[file] = found.content
            self._note((*kept, made), made)
            for each in replaced:
                (self._folder / each).unlink(missing_ok=True)

    def remove(self, number: int) -> None:
        """Remove a file from the project; missions that were made of it stay.

        Raises
        ------
        InputError
            There is no such file.
        """
        with self._lock:
            files = self._session.files
            gone = next((each for each in files if each.number == number), None)
            if gone is None:
                raise InputError("there is no such file; it may have been removed already")
            self._note(tuple(each for each in files if each is not gone), gone)
            self._parts.pop(gone.file, None)
            (self._folder / gone.file).unlink(missing_ok=True)

    def _note(self, files: tuple[DroppedFile, ...], changed: DroppedFile) -> None:
        """Register the files, and discard worths computed from other files."""
        stale = changed.what in ("prizes", "catalogue", "satcat")
        self._session.note(files=files, worth=None if stale else self._session.worth)

    def view(self) -> CatalogueView | None:
        """The catalogue; None if there is none.

        Raises
        ------
        InputError
            Its files are spoilt.
        """
        files = [each for each in self._session.files if each.what == "catalogue"]
        satcat = self.latest("satcat")
        if not files:
            return None
        key = (*(each.file for each in files), str(satcat))
        with self._lock:
            if self._view is None or self._view[0] != key:
                self._view = key, CatalogueView(map(self._part, files), satcat)
                self._parts.clear()
            return self._view[1]

    def _part(self, dropped: DroppedFile) -> Catalogue:
        """Content of a file; errors and instances have its name as it was."""
        part = self._parts.get(dropped.file)
        if part is None:
            path = refuse_link(self._folder / dropped.file)
            part = read_bytes(load_bytes(path), dropped.name, skip_bad=True)
        return part

    def columns(self) -> dict[str, Any]:
        """Columns of all objects as JSON data."""
        view = self.view()
        if view is None:
            return NOTHING
        rows = view.rows
        chosen = sorted({rows[name] for name in self._session.target_names() if name in rows})
        worth, unit = self._rated(view)
        return {**view.columns, "worth": worth, "worth_unit": unit, "chosen": chosen}

    def mission(
        self, names: Iterable[str], prizes: PrizeKind, options: dict[str, Any]
    ) -> MissionMade:
        """The mission of some of the objects.

        Parameters
        ----------
        names : iterable of str
        prizes : {"one", "worth", "criticality"}
        options : dict
            Values of the options of an import, by name.

        Raises
        ------
        InputError
            There is no catalogue, or no such object, or no mission can be made of them.
        """
        view = self.view()
        if view is None:
            raise InputError("there is no catalogue; drop a TLE or OMM file first")
        table = self._prizes() if prizes == "worth" else None
        if prizes == "worth" and table is None:
            raise InputError("worths are unknown; compute them, or drop a table of prizes")
        messages = self.of("ephemerides")
        try:
            wanted = wanted_of(options, messages=bool(messages))
            if prizes == "criticality":
                wanted = wanted._replace(demands=replace(wanted.demands, by_criticality=True))
            return mission_of(
                view.chosen(list(names)),
                wanted,
                table,
                messages,
                lambda: private_folder(passing(self._session.folder.path)),
            )
        except InputError as error:
            raise InputError(in_labels(str(error), NAMED)) from None

    def _prizes(self) -> Path | None:
        """The table of prizes: computed, or dropped."""
        if self._session.worth is None:
            return self.latest("prizes")
        return refuse_link(self._session.results.place(self._session.worth) / PRIZES)

    def _rated(self, view: CatalogueView) -> tuple[list[float | None], str | None]:
        """Worth of each object, and its unit; None for those without."""
        number, table = self._session.worth, self._prizes()
        if table is None:
            return [None] * len(view.records), None
        key = (number, str(table), id(view))
        if self._worth is None or self._worth[0] != key:
            column, unit = (
                ("prize", "prize") if number is None else ("worth_alone", "fragment-years")
            )
            path = table if number is None else table.with_name(DETAILS)
            self._worth = key, view.by_object(_column(path, column)), unit
        return self._worth[1:]


def _column(path: Path, name: str) -> dict[str, float]:
    """A column of numbers of a table by the objects of its rows."""
    found = {}
    for row in csv.DictReader(read_text(path).removeprefix("\ufeff").splitlines()):
        cells = {str(key).strip().casefold(): value for key, value in row.items()}
        said = next((cells[each] for each in ("object", "number", "name") if cells.get(each)), "")
        try:
            found[said.strip()] = float(cells.get(name) or "nan")
        except (TypeError, ValueError):
            continue
    return found


def _displayed(name: str) -> str:
    """A name for display: no folders, no control characters, of limited length."""
    last = re.split(r"[/\\]", name)[-1]
    shown = "".join(letter if letter.isprintable() else "?" for letter in last).strip()[:100]
    return shown or "file"


def _as_file(name: str) -> str:
    """A name for a file on any system."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name)[-60:].strip(".-") or "file"
