"""The file of a study: a head that describes the rows, then a line of JSON for each row.

It is only appended to, by one process at a time. A last line without an end was cut off, by a kill
or the end of the machine: it is dropped. Any other line that is no row is refused, and so is a file
of another protocol or of other work. The last row of a key counts.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from io import FileIO
from pathlib import Path
from typing import Any, NamedTuple

from ..common.errors import InputError
from ..common.files import check_writable
from ..common.json_text import parse_json
from ..common.lock import locked
from .study import Study, text_of

FORMAT = "adr-opt-study/1"

FLUSHED_S = 1.0
"""Longest time until rows are safe from a crash of the machine [s]; one of the process never loses
any."""

HEADS_BEFORE = {"adr-opt-designs/1", "adr-opt-scenario/1", "adr-opt-rehearsals/1"}
"""Formats of files of 1.0."""


class Stored(NamedTuple):
    """A row of a file.

    Attributes
    ----------
    where : str
        Its place, for messages.
    key, value : JSON data
    seconds : float
        What it took.
    """

    where: str
    key: Any
    value: Any
    seconds: float


class StudyFile:
    """The file of a study, held for writing until it is closed.

    Parameters
    ----------
    path : path
        It may be there from an earlier call.
    study : Study

    Attributes
    ----------
    found : dict of str to Stored
        What was there, by the text of the key.

    Raises
    ------
    InputError
        It is held by another process, cannot be written, or is no file of this study.
    """

    def __init__(self, path: str | os.PathLike[str], study: Study[Any, Any]) -> None:
        self._path, self._opened = Path(path), ExitStack()
        self._flushed_s = -math.inf
        check_writable(path)
        try:
            # Without a buffer, of which a rest would be written when the file is closed.
            self._file: FileIO = self._opened.enter_context(self._path.open("ab+", buffering=0))
        except OSError as error:
            raise self._unwritable(error) from None
        self._opened.callback(os.fsync, self._file.fileno())
        try:
            self._opened.enter_context(
                locked(self._path, "another call is writing to it; wait until that ends, or end it")
            )
            content = self._content()
            whole = content[: content.rfind(b"\n") + 1]
            head = line_of(head_of(study))
            self.found = rows_of(self._path, content, study)
            self._write(len(whole), b"" if whole else head)
        except BaseException:
            self.close()
            raise

    def append(self, rows: Iterable[tuple[Any, Any, float]]) -> None:
        """Write rows (key, value and seconds) immediately and completely.

        Raises
        ------
        InputError
            They cannot be written; the file has the rows that it had before.
        ValueError
            A number is not finite.
        """
        lines = b"".join(
            line_of({"key": key, "value": value, "seconds": round(seconds, 3)})
            for key, value, seconds in rows
        )
        self._write(os.fstat(self._file.fileno()).st_size, lines)

    def close(self) -> None:
        """Release the file for other writers."""
        self._opened.close()

    def _content(self) -> bytes:
        try:
            self._file.seek(0)
            return self._file.readall()
        except OSError as error:
            raise self._unwritable(error) from None

    def _write(self, size: int, lines: bytes) -> None:
        """Write lines after a number of bytes; on failure, leave the file as it was."""
        try:
            self._file.truncate(size)
            try:
                rest = memoryview(lines)
                while rest:  # a full disk takes a part, and says so at the next call
                    rest = rest[self._file.write(rest) :]
                if time.monotonic() - self._flushed_s > FLUSHED_S:
                    os.fsync(self._file.fileno())
                    self._flushed_s = time.monotonic()
            except OSError:
                self._file.truncate(size)
                raise
        except OSError as error:
            raise self._unwritable(error) from error

    def _unwritable(self, error: OSError) -> InputError:
        said = error.strerror or error
        return InputError(f"{self._path}: cannot be written ({said}); choose another place")


def read(path: str | os.PathLike[str], study: Study[Any, Any]) -> dict[str, Stored]:
    """Rows of a file by the text of their keys, even while another process writes to it.

    Raises
    ------
    InputError
        It cannot be read, or is no file of this study.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        said = error.strerror or error
        raise InputError(f"{path}: cannot be read ({said}); check the path") from None
    return rows_of(Path(path), content, study)


def check_file(path: str | os.PathLike[str] | None, study: Study[Any, Any]) -> None:
    """Refuse, before any work, a file from which a study cannot resume.

    Raises
    ------
    InputError
        It is there and cannot be read, or is no file of this study.
    """
    if path is not None and Path(path).exists():
        read(path, study)


def head_of(study: Study[Any, Any]) -> dict[str, Any]:
    """The first line of a study's file."""
    of = dict(study.of)
    return {"format": FORMAT, "protocol": study.protocol, "version": study.version, "of": of}


def line_of(content: Mapping[str, Any]) -> bytes:
    """A JSON object on a line; numbers that are not finite raise ValueError."""
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode() + b"\n"


def rows_of(path: Path, content: bytes, study: Study[Any, Any]) -> dict[str, Stored]:
    """The rows in the content of a file.

    Raises
    ------
    InputError
        It is no file of this study; the sentence says which line is at fault.
    """
    first, *others = content.split(b"\n")
    if not others and line_of(head_of(study)).startswith(first):
        return {}  # empty, or of a call that ended while it wrote the head
    _check_head(path, first, study, whole=bool(others))
    found = dict[str, Stored]()
    for number, line in enumerate(others[:-1], start=2):
        where = f"{path}: line {number}"
        otherwise = "not a row of a study; name another file"
        row = parse_json(line, where, otherwise)
        if not isinstance(row, dict) or not _is_row(row):
            raise InputError(f"{where}: {otherwise}")
        found[text_of(row["key"])] = Stored(where, **row)
    return found


def _check_head(path: Path, first: bytes, study: Study[Any, Any], *, whole: bool) -> None:
    otherwise = f"not a file of a study ({study.protocol}); name another file"
    head = parse_json(first, str(path), otherwise)
    stated = head.get("format") if isinstance(head, dict) else None
    if isinstance(stated, str) and stated in HEADS_BEFORE:
        raise InputError(
            f"{path}: a file of adr-opt 1.0, which this version cannot resume; name another file"
        )
    if not whole or stated != FORMAT:
        raise InputError(f"{path}: {otherwise}")
    wanted = head_of(study)
    for word in ("protocol", "version"):
        if head.get(word) != wanted[word]:
            raise InputError(
                f"{path}: rows of {head.get('protocol')!r}, version {head.get('version')!r}, and "
                f"not of {study.protocol!r}, version {study.version}; name another file"
            )
    of = head.get("of")
    for word in wanted["of"]:
        if not isinstance(of, dict) or of.get(word) != wanted["of"][word]:
            raise InputError(
                f"{path}: made with other {word}; name another file, or repeat the call that made "
                "it"
            )


def _is_row(row: dict[str, Any]) -> bool:
    """Whether an object has the form of a row, with finite numbers."""
    if row.keys() != {"key", "value", "seconds"}:
        return False
    try:
        text_of(row)  # Python reads NaN and 1e999, which are never written
    except (ValueError, RecursionError):
        return False
    return isinstance(row["seconds"], (int, float)) and row["seconds"] >= 0.0
