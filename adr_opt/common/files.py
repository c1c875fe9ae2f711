"""JSON files: written completely or not at all, with every error in one sentence."""

from __future__ import annotations

import json
import os
import re
import secrets
import stat
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, Protocol, Self, TypeVar

from pydantic import ValidationError

from .errors import InputError
from .sentences import sentence


class Readable(Protocol):
    """A type that can be read from a JSON file."""

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Parse a text; raises :class:`pydantic.ValidationError`."""
        ...


Model = TypeVar("Model", bound=Readable)

LEFT_OVER_S = 86400.0
"""Age beyond which a temporary file must have been left by a killed writer [s]."""


def read_text(path: str | os.PathLike[str]) -> str:
    """Read a text file, or raise an :class:`InputError` that says what is wrong with it."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except IsADirectoryError:
        raise InputError(f"{path}: this is a folder; name a file in it") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8; give a JSON file") from None
    except OSError as error:
        raise InputError(
            f"{path}: cannot be read ({error.strerror}); check the path and its permissions"
        ) from None
    except ValueError:
        raise InputError(f"{os.fspath(path)!r}: not a valid file name; check the path") from None


def read_model(path: str | os.PathLike[str], model: type[Model]) -> Model:
    """Read and validate a JSON file.

    Raises
    ------
    InputError
        The file is missing, not JSON, or breaks the format; the sentence names the first field
        at fault.
    """
    return parse_model(read_text(path), model, str(path))


def parse_model(text: str, model: type[Model], source: str) -> Model:
    """Validate JSON text; ``source`` names it in errors."""
    try:
        return model.from_json(text)
    except ValidationError as error:
        raise InputError(f"{source}: {sentence(error)}") from None


def parse_content(given: Any, model: type[Model], what: str) -> Model:
    """Validate the content of a JSON file that was given as a dictionary; ``what`` names it.

    Raises
    ------
    InputError
        It is no dictionary, cannot be written as JSON, or breaks the format.
    """
    if not isinstance(given, Mapping):
        raise InputError(
            f"{what} of type {type(given).__name__}: give an {model.__name__}, the path of its "
            "file, or the content of that as a dictionary"
        )
    try:
        text = json.dumps(dict(given))
    except (TypeError, ValueError) as error:
        raise InputError(f"{what}: cannot be written as JSON ({error})") from None
    return parse_model(text, model, what)


def to_text(content: dict[str, Any]) -> str:
    """A JSON object as text, with one line for each list item, nested lists included.

    The same content gives the same bytes on every machine: Python's shortest float repr.
    """
    lines = []
    for key, value in content.items():
        if isinstance(value, list) and value:
            items = ",\n".join("  " + _item(item) for item in value)
            lines.append(f" {json.dumps(key)}: [\n{items}\n ]")
        else:
            lines.append(f" {json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


_write = json.JSONEncoder(ensure_ascii=False).encode


def _item(item: Any) -> str:
    """A list item as text: on one line, except for lists of objects within it."""
    if not isinstance(item, dict) or not any(_is_of_objects(value) for value in item.values()):
        return _write(item)
    parts = []
    for key, value in item.items():
        text = _write(value)
        if _is_of_objects(value):
            lines = ",\n".join("   " + _write(inner) for inner in value)
            text = f"[\n{lines}\n  ]"
        parts.append(f"{json.dumps(key)}: {text}")
    return "{" + ", ".join(parts) + "}"


def _is_of_objects(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], dict)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Raise :class:`InputError` now if ``path`` will not be writable after a long computation."""
    target = Path(path)
    if target.is_dir():
        raise InputError(f"{path}: this is a folder; name a file in it")
    if target.exists() and not target.is_file():
        raise InputError(f"{path}: not an ordinary file; name one that can be replaced")
    try:
        folder = target.resolve().parent
    except (OSError, RuntimeError, ValueError):  # links in a circle, a NUL
        raise InputError(f"{os.fspath(path)!r}: not a valid file name") from None
    if not folder.is_dir():
        raise InputError(f"{path}: the folder {target.parent} does not exist; create it first")
    if not os.access(folder, os.W_OK):
        raise InputError(f"{path}: the folder {target.parent} cannot be written to; choose another")


def write_whole(path: str | os.PathLike[str], write: Callable[[Path], object]) -> None:
    """Write a file completely or not at all: to a temporary neighbour, then renamed over it.

    Parameters
    ----------
    path : path
        A link is followed: the file it points to is replaced, not the link.
    write : callable
        Called with the temporary path, which keeps the suffix of ``path``.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    check_writable(path)
    target = Path(path).resolve()
    _remove_left_overs(target.parent)
    try:
        name = f".{target.stem[:50]}-{secrets.token_hex(4)}.part{target.suffix}"
        temporary = target.parent / name
        # Opened like any other file, so that its mode is that of others: the mask of the process
        # cannot be read without changing it, which other threads would notice.
        os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        try:
            write(temporary)
            temporary.replace(target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(
            f"{path}: cannot be written ({error.strerror or error}); choose another place"
        ) from error


def write_bytes(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file completely or not at all."""
    write_whole(path, lambda temporary: temporary.write_bytes(content))


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file in UTF-8, completely or not at all."""
    write_bytes(path, text.encode("utf-8"))


def write_both(
    path: str | os.PathLike[str], text: str, other: str | os.PathLike[str], other_text: str
) -> None:
    """Write two text files, of which the first refers to the other one.

    The first one appears when the other is complete, and neither where one cannot be written to.
    """
    check_writable(other)

    def write(temporary: Path) -> None:
        temporary.write_text(text, encoding="utf-8")
        write_text(other, other_text)

    write_whole(path, write)


@cache
def _remove_left_overs(folder: Path) -> None:
    """Remove temporary files of killed writers, once per folder."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if re.fullmatch(r"\..*-[a-z0-9_]{8}\.part(\.[^.]*)?", entry.name, re.DOTALL):
                status = entry.stat(follow_symlinks=False)
                if stat.S_ISREG(status.st_mode) and time.time() - status.st_mtime > LEFT_OVER_S:
                    os.unlink(entry.path)
