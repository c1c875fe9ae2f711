"""The whole project as one zip file."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from .private import private_file


def archived(folder: Path, own: Iterable[Path], to: Path) -> Path:
    """A zip file of what is of a project; the caller removes it.

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
