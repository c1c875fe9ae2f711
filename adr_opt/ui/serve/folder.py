"""The working folder: the latest plan with its instance, and an unplanned draft."""

from __future__ import annotations

import os
from pathlib import Path

from ...common.errors import InputError
from ...plan.plan import Plan
from ...problem.instance import Instance

INSTANCE, PLAN, DRAFT = "instance.json", "plan.json", "draft.json"
"""Files apart from that of given connections; the first two always belong together."""


class Folder:
    """The folder where edits and plans are stored; nothing is written elsewhere.

    A folder with the work of an earlier call is used only to continue that work. Nothing is
    made before :meth:`make`.

    Parameters
    ----------
    path : path
    going_on : path
        The instance file of this call: that in the folder, if work goes on there.

    Raises
    ------
    InputError
        It cannot be made or written to, or it holds the work of an earlier call.
    """

    def __init__(self, path: str | os.PathLike[str], going_on: str | os.PathLike[str]) -> None:
        try:
            self.path = Path(path).resolve()
            is_there = self.path.exists()
        except (OSError, RuntimeError, ValueError):  # links in a circle, a NUL
            raise InputError(f"{os.fspath(path)!r}: no folder can have such a name") from None
        if is_there and not self.path.is_dir():
            raise InputError(f"{path}: not a folder; name another one with --folder")
        if not is_there and not self.path.parent.is_dir():
            raise InputError(
                f"{path}: the folder {self.path.parent} does not exist; create it first"
            )
        if not os.access(self.path if is_there else self.path.parent, os.W_OK | os.X_OK):
            raise InputError(f"{path}: the folder cannot be written to; choose another")
        there = [name for name in (INSTANCE, PLAN, DRAFT) if os.path.lexists(self.path / name)]
        if there and Path(going_on).resolve().parent != self.path:
            raise InputError(
                f"{path}: holds {there[0]} of an earlier call; go on with that by giving the files "
                "in it as INSTANCE and PLAN, or name another folder with --folder"
            )

    def make(self) -> None:
        """Create the folder if it is absent.

        Raises
        ------
        InputError
            That cannot be done.
        """
        try:
            self.path.mkdir(exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{self.path}: the folder cannot be made ({error.strerror}); name another one"
            ) from None

    def keep_draft(self, instance: Instance, *, planned: bool) -> None:
        """Store the draft, unless the stored plan is one of it."""
        path = self._file(DRAFT)
        reference, given = instance.transfer.given, instance.given
        if reference is not None and given is not None:
            # Beside those of the plan, which stay as they are.
            names = reference.file, reference.functions
            drafts = [None if name is None else f"draft-{name}" for name in names]
            for file in drafts:
                if planned and file is not None:
                    self._file(file).unlink(missing_ok=True)
            instance = instance.with_given(given, *drafts)
        if planned:
            path.unlink(missing_ok=True)
        else:
            self._save(instance, path)

    def keep_plan(self, instance: Instance, plan: Plan) -> None:
        """Store a plan and its instance."""
        path = self._file(PLAN)
        self._save(instance, self._file(INSTANCE))
        plan.save(path)

    def _save(self, instance: Instance, path: Path) -> None:
        reference = instance.transfer.given
        for name in () if reference is None else (reference.file, reference.functions):
            if name is not None:
                self._file(name)
        instance.save(path)

    def _file(self, name: str) -> Path:
        """A file of the folder, which must not lead outside."""
        path = self.path / name
        if path.is_symlink():
            raise InputError(f"{path}: a link, which may lead out of the folder; remove it")
        return path
