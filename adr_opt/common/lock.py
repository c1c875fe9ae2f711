"""A lock that one process holds on a file or folder, released even if that process is killed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .errors import InputError

# Where the module is missing, two processes at one place are the user's own affair.
FCNTL: Any = import_module("fcntl") if find_spec("fcntl") is not None else None


@contextmanager
def locked(path: Path, otherwise: str) -> Iterator[None]:
    """Hold a file or folder until the end of the context, or of the process, however it ends.

    Parameters
    ----------
    path : path
        Must exist.
    otherwise : str
        What to say where another process holds it.

    Raises
    ------
    InputError
        Another process holds it.
    """
    if FCNTL is None:
        yield
        return
    # What is held is locked itself: there is no other file that could be left behind.
    handle = os.open(path, os.O_RDONLY)
    try:
        try:
            FCNTL.flock(handle, FCNTL.LOCK_EX | FCNTL.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"{path}: {otherwise}") from None
        except OSError:  # a file system without locks
            pass
        yield
    finally:
        os.close(handle)
