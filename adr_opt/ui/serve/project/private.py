"""Files and folders that only their owner can read, and that are not links."""

from __future__ import annotations

import os
import secrets
import shutil
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from ....common.errors import InputError

PASSING = ".passing-"
"""Prefix of unfinished files and folders, which a killed server may leave."""


def private_file(path: Path) -> BinaryIO:
    """A new file for writing, of mode 0600; nothing may exist there, not even a link."""
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o600)
    return os.fdopen(handle, "wb")


def private_folder(path: Path) -> Path:
    """A folder of mode 0700, created if missing.

    Raises
    ------
    InputError
        It is a link or a file, or cannot be made.
    """
    refuse_link(path)
    try:
        path.mkdir(mode=0o700, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{path}: the folder cannot be created ({error.strerror}); name another one"
        ) from None
    return path


def refuse_link(path: Path) -> Path:
    """The path, refused if it is a link.

    Raises
    ------
    InputError
        It is one.
    """
    if path.is_symlink():
        raise InputError(f"{path}: a link, which may lead out of the folder; remove it")
    return path


def passing(folder: Path, suffix: str = "") -> Path:
    """Path in a folder for an unfinished file, to be moved or removed."""
    return folder / f"{PASSING}{secrets.token_hex(8)}{suffix}"


def remove_passing(folder: Path) -> None:
    """Remove the unfinished files that a killed server left in a folder."""
    with suppress(OSError):
        for path in folder.glob(f"{PASSING}*"):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)
