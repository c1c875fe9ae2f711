"""The project folder: history, results, dropped files, and the latest plan."""

from __future__ import annotations

import os
import stat
import zipfile
from collections.abc import Iterable
from contextlib import AbstractContextManager, suppress
from pathlib import Path

from ...common.errors import InputError
from ...common.files import read_model, write_text
from ...common.lock import locked
from ...plan.plan import Plan
from ...problem.instance import Instance
from ...problem.instance_file import InstanceFile
from .project.drafts_kept import DraftsKept
from .project.private import private_file, private_folder, refuse_link, remove_passing
from .project.record import ProjectRecord
from .project.results import Results

INSTANCE, PLAN, DRAFT = "instance.json", "plan.json", "draft.json"
"""Files of the current state; the first two always belong together."""

PROJECT = "project.json"

HISTORY, RESULTS, FILES = "history", "results", "files"
"""Folders of a project; without the project's file, they are not ours."""


class Folder:
    """The folder where edits and plans are stored; nothing is written elsewhere.

    A folder with the work of an earlier call is used only to continue that work. Nothing is
    made before :meth:`make`.

    Parameters
    ----------
    path : path
    going_on : path, optional
        The instance file of this call: that in the folder, if work goes on there. Without one the
        folder is a project that is opened as it was.

    Attributes
    ----------
    drafts : DraftsKept
    results : Results

    Raises
    ------
    InputError
        It cannot be made or written to, or it holds the work of an earlier call.
    """

    def __init__(
        self, path: str | os.PathLike[str], going_on: str | os.PathLike[str] | None = None
    ) -> None:
        try:
            self.path = Path(path).resolve()
            is_there = self.path.exists()
        except (OSError, RuntimeError, ValueError):  # links in a circle, a NUL
            raise InputError(f"{os.fspath(path)!r}: not a valid folder name") from None
        if is_there and not self.path.is_dir():
            raise InputError(f"{path}: not a folder; name another one with --folder")
        if not is_there and not self.path.parent.is_dir():
            raise InputError(
                f"{path}: the folder {self.path.parent} does not exist; create it first"
            )
        if not os.access(self.path if is_there else self.path.parent, os.W_OK | os.X_OK):
            raise InputError(f"{path}: the folder cannot be written to; choose another")
        if is_there and self.path.stat().st_mode & stat.S_IWOTH and os.name == "posix":
            raise InputError(
                f"{path}: all users of this machine can write to the folder; choose another, or "
                "remove that permission"
            )
        there = [
            name for name in (INSTANCE, PLAN, DRAFT, PROJECT) if os.path.lexists(self.path / name)
        ]
        if going_on is not None:
            if there and Path(going_on).resolve().parent != self.path:
                raise InputError(
                    f"{path}: holds {there[0]} of an earlier call; continue by giving the files in "
                    "it as INSTANCE and PLAN, or name another folder with --folder"
                )
        elif there and PROJECT not in there:
            raise InputError(
                f"{path}: holds {there[0]}, but is not a project; give the files in it as INSTANCE "
                "and PLAN, or name another folder with --folder"
            )
        for name in () if PROJECT in there else (HISTORY, RESULTS, FILES):
            if os.path.lexists(self.path / name):
                raise InputError(
                    f"{path}: holds {name}, but no {PROJECT} that marks a project; name another "
                    "folder with --folder"
                )
        self.drafts = DraftsKept(self.path / HISTORY)
        self.results = Results(self.path / RESULTS)
        self.files = self.path / FILES

    def make(self) -> None:
        """Create the folder if it does not exist.

        Raises
        ------
        InputError
            That cannot be done.
        """
        private_folder(self.path)

    def locked(self) -> AbstractContextManager[None]:
        """Holds the folder, which must exist, against other servers."""
        return locked(
            self.path,
            "another server uses this folder; end it, or name another folder with --folder",
        )

    def read(self) -> ProjectRecord | None:
        """The project stored in the folder; None if it is new.

        Raises
        ------
        InputError
            Its file is spoilt.
        """
        for place in (self.path, self.drafts.folder, self.results.folder, self.files):
            refuse_link(place)
            remove_passing(place)
        self.results.read()
        path = self._file(PROJECT)
        return read_model(path, ProjectRecord) if path.exists() else None

    def own(self) -> list[Path]:
        """All files and folders named by the project; some may be missing.

        Raises
        ------
        InputError
            The file of the project is spoilt.
        """
        record = read_model(self._file(PROJECT), ProjectRecord)
        names = {PROJECT, INSTANCE, PLAN, DRAFT}
        for name in (INSTANCE, DRAFT):
            if (self.path / name).exists():
                with suppress(InputError):
                    names |= _beside(read_model(self._file(name), InstanceFile))
        return [
            *(self.path / name for name in names),
            *(self.drafts.folder / step.draft for step in record.steps if step.draft is not None),
            *(self.files / each.file for each in record.files),
            *(self.results.place(each.number) for each in self.results.all()),
        ]

    def keep(self, record: ProjectRecord) -> None:
        """Store the file of the project."""
        write_text(self._file(PROJECT), record.to_json())

    def keep_draft(self, instance: Instance | None, *, planned: bool) -> None:
        """Store the draft, unless there is none or the stored plan belongs to it."""
        path = self._file(DRAFT)
        if instance is None:
            path.unlink(missing_ok=True)
            return
        reference, given = instance.transfer.given, instance.given
        if reference is not None and given is not None:
            # Beside those of the plan, which stay as they are.
            names = reference.file, reference.functions
            drafts = [None if name is None else f"draft-{name}" for name in names]
            for file in drafts:
                if planned and file is not None:
                    self._file(file).unlink(missing_ok=True)
            instance = instance.with_given(given, *drafts)
        windows = instance.windows_read
        if instance.windows is not None and windows is not None:
            file = f"draft-{instance.windows.file}"
            if planned:
                self._file(file).unlink(missing_ok=True)
            instance = instance.with_windows(windows, file)
        if planned:
            path.unlink(missing_ok=True)
        else:
            self._save(instance, path)

    def keep_plan(self, instance: Instance, plan: Plan) -> None:
        """Store a plan and its instance as the current ones."""
        path = self._file(PLAN)
        self._save(instance, self._file(INSTANCE))
        plan.save(path)

    def _save(self, instance: Instance, path: Path) -> None:
        for name in _beside(instance):
            self._file(name)
        instance.save(path)

    def _file(self, name: str) -> Path:
        """A file of the folder, which must not lead outside."""
        return refuse_link(self.path / name)


def _beside(instance: InstanceFile) -> set[str]:
    """Names of the files that belong to an instance."""
    given, ephemerides, windows = instance.transfer.given, instance.ephemerides, instance.windows
    names = set() if given is None else {given.file, given.functions}
    names |= set() if windows is None else {windows.file}
    return {name for name in names if name is not None} | set(
        () if ephemerides is None else ephemerides.files
    )


def archived(folder: Path, own: Iterable[Path], to: Path) -> Path:
    """A zip file of the project; the caller removes it.

    Hidden files, which are being written, and links are left out, and so is what has gone in the
    meantime. Nothing is left of a file that cannot be written as a whole.

    Parameters
    ----------
    folder : path
        The project folder, whose name all names within the archive begin with.
    own : iterable of path
        Files and folders of the project in it.
    to : path
        Where to write it; must not be there yet.

    Raises
    ------
    OSError
        It cannot be written.
    """
    try:
        with (
            private_file(to) as file,
            zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, strict_timestamps=False) as made,
        ):
            for path in sorted({each for one in own for each in _files(one)}):
                with suppress(FileNotFoundError):
                    made.write(path, Path(folder.name) / path.relative_to(folder))
    except BaseException:
        to.unlink(missing_ok=True)
        raise
    return to


def _files(own: Path) -> list[Path]:
    """The file, or all files in the folder."""
    if own.is_symlink() or own.parent.is_symlink():
        return []
    if own.is_file():
        return [own]
    found = []
    for place, folders, files in os.walk(own, followlinks=False):
        folders[:] = [name for name in folders if not name.startswith(".")]
        paths = [Path(place) / name for name in files if not name.startswith(".")]
        found += [path for path in paths if path.is_file() and not path.is_symlink()]
    return found
