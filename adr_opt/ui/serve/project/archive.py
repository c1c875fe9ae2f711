"""The whole project as one zip file."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path

from .private import private_file


def archived(folder: Path, to: Path) -> Path:
    """A zip file of all files of a project; the caller removes it.

    Hidden files, which are being written, and links are left out.

    Parameters
    ----------
    folder : path
        The project folder, whose name all names within the archive begin with.
    to : path
        Where to write it; must not be there yet.
    """
    with private_file(to) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        for path in sorted(_files(folder)):
            made.write(path, Path(folder.name) / path.relative_to(folder))
    return to


def _files(folder: Path) -> list[Path]:
    found = []
    for place, folders, files in os.walk(folder, followlinks=False):
        folders[:] = [name for name in folders if not name.startswith(".")]
        paths = [Path(place) / name for name in files if not name.startswith(".")]
        found += [path for path in paths if path.is_file() and not path.is_symlink()]
    return found
