"""The way of a token to the browser: by a private file, since command lines are seen by all."""

from __future__ import annotations

import html
from pathlib import Path

from .project.private import passing, private_file

PAGE = (
    '<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>adr-opt</title>'
    '<meta name="referrer" content="no-referrer">'
    '<meta http-equiv="refresh" content="0; url={url}"></html>\n'
)


class LaunchFile:
    """A page that leads to an address, readable by its owner alone, until it is removed.

    Parameters
    ----------
    folder : path
        Readable by its owner alone.
    url : str
        The address, with its token.

    Attributes
    ----------
    address : str
        Of the file.
    """

    def __init__(self, folder: Path, url: str) -> None:
        self._path = passing(folder, ".html")
        with private_file(self._path) as file:
            file.write(PAGE.format(url=html.escape(url)).encode())
        self.address = self._path.as_uri()

    def remove(self) -> None:
        """Remove the file, which has been used or will not be."""
        self._path.unlink(missing_ok=True)
