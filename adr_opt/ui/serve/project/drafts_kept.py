"""Instances of the history, each in a folder of its own with the files that belong to it."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

from ....common.errors import InputError
from ....common.files import read_model, write_text
from ....problem.instance import Instance
from .private import passing, private_folder
from .record import KEY

INSTANCE = "instance.json"


class DraftsKept:
    """The folder ``history`` of a project.

    Parameters
    ----------
    folder : path
        Made when something is kept.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._sizes: dict[str, int] = {}

    def keep(self, instance: Instance, before: str | None) -> str:
        """Keep an instance; returns the name of its folder.

        Parameters
        ----------
        instance : Instance
        before : str, optional
            Folder of the step before, whose given connections and ephemerides are shared where
            they are the same.
        """
        key = instance.sha256[:16]
        place = private_folder(self.folder) / key
        if (place / INSTANCE).is_file():
            return key
        made = private_folder(passing(self.folder))
        if before is not None and _linked(instance, self.folder / before, made):
            write_text(made / INSTANCE, instance.to_json())
        else:
            instance.save(made / INSTANCE)
        made.rename(place)
        return key

    def load(self, key: str) -> Instance:
        """An instance that was kept.

        Raises
        ------
        InputError
            It is gone or spoilt.
        """
        return Instance.load(self.folder / key / INSTANCE)

    def size(self, key: str) -> int:
        """Size of the instance file [bytes], linked files excluded."""
        if key not in self._sizes:
            try:
                self._sizes[key] = (self.folder / key / INSTANCE).stat().st_size
            except OSError:
                return 0
        return self._sizes[key]

    def forget(self, kept: Collection[str]) -> None:
        """Remove all instances but some; anything with another name stays."""
        with suppress(OSError):
            for path in self.folder.iterdir():
                if path.name in kept or re.fullmatch(KEY, path.name) is None:
                    continue
                if path.is_dir() and not path.is_symlink():
                    shutil.rmtree(path, ignore_errors=True)


def _linked(instance: Instance, before: Path, made: Path) -> bool:
    """Whether the files beside an instance could be linked from the previous step."""
    if not any(instance.files_beside):
        return False
    try:
        other = read_model(before / INSTANCE, Instance)
        if other.files_beside != instance.files_beside:
            return False
        for path in before.iterdir():
            if path.name != INSTANCE:
                os.link(path, made / path.name)
    except (InputError, OSError):
        return False
    return True
