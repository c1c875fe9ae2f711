"""A file of JSON lines that grows: a head that says what the others belong to, then results.

Lines are written whole or not at all. What follows the last end of a line was cut off, by a killed
process or the end of the machine: it is not read, and gone with the next line that is written.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from io import FileIO
from pathlib import Path
from typing import Any

from .errors import InputError
from .json_text import parse_json


class LinesFile:
    """Lines of JSON objects in a file that may be there from an earlier run.

    Parameters
    ----------
    path : path
    head : dict
        JSON data of the first line; its ``format`` says what kind of file it is.
    what : str
        What the file is, for messages, as in "a file of designs".
    """

    def __init__(self, path: str | os.PathLike[str], head: dict[str, Any], what: str) -> None:
        self.path, self._head, self._what = Path(path), head, what

    def read(self, other: Callable[[str], str]) -> list[tuple[str, bytes]]:
        """Whole lines after the head, each with its place for messages; none without a file.

        Parameters
        ----------
        other : callable
            What to say of a file whose head has another value, by the key of the first of them.

        Raises
        ------
        InputError
            It cannot be read, is another file, or one of other work.
        """
        try:
            content = self.path.read_bytes() if self.path.exists() else b""
        except OSError as error:
            raise InputError(
                f"{self.path}: cannot be read ({error.strerror or error}); name another one"
            ) from None
        first, *others = content.split(b"\n")
        if not others and line_of(self._head).startswith(first):
            return []  # empty, or of a run that ended while it wrote the head
        other_file = f"not {self._what}; name another one"
        head = parse_json(first, str(self.path), other_file)
        if not others or not isinstance(head, dict) or head.get("format") != self._head["format"]:
            raise InputError(f"{self.path}: {other_file}")
        for key, value in self._head.items():
            if head.get(key) != value:
                raise InputError(f"{self.path}: {other(key)}")
        return [
            (f"{self.path}: line {number}", line)
            for number, line in enumerate(others[:-1], start=2)
            if line.strip()
        ]

    def append(self, content: dict[str, Any]) -> None:
        """Write a line at once, after the head if the file has none.

        Raises
        ------
        InputError
            It cannot be written; the file has the lines that it had before.
        """
        line = line_of(content)
        try:
            # Without a buffer, of which a rest would be written when the file is closed.
            with self.path.open("ab+", buffering=0) as file:
                size = _end(file)
                file.truncate(size)
                try:
                    _write(file, (b"" if size else line_of(self._head)) + line)
                    os.fsync(file.fileno())
                except OSError:
                    file.truncate(size)
                    raise
        except OSError as error:
            raise InputError(
                f"{self.path}: cannot be written ({error.strerror or error}); choose another place"
            ) from error


def line_of(content: dict[str, Any]) -> bytes:
    """A JSON object on a line; numbers that are not finite raise ValueError."""
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode() + b"\n"


def _end(file: FileIO) -> int:
    """Number of bytes up to the last end of a line."""
    size = file.seek(0, os.SEEK_END)
    if size:
        file.seek(size - 1)
        if file.read(1) != b"\n":
            file.seek(0)
            size = file.readall().rfind(b"\n") + 1
    return size


def _write(file: FileIO, line: bytes) -> None:
    rest = memoryview(line)
    while rest:
        rest = rest[file.write(rest) :]
