"""One server for each project folder: a lock that a kill releases."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ....common.errors import InputError

# Where the module is missing, two servers of one folder are the user's own affair.
FCNTL: Any = import_module("fcntl") if find_spec("fcntl") is not None else None


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a project folder until the end of the context, or of the process, however it ends.

    Parameters
    ----------
    folder : path
        Must exist.

    Raises
    ------
    InputError
        Another server holds it.
    """
    if FCNTL is None:
        yield
        return
    # The folder itself is locked: there is no file that could be left behind.
    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            FCNTL.flock(handle, FCNTL.LOCK_EX | FCNTL.LOCK_NB)
        except BlockingIOError:
            raise InputError(
                f"{folder}: another server is working in this folder; end that one, or name "
                "another folder with --folder"
            ) from None
        except OSError:  # a file system without locks
            pass
        yield
    finally:
        os.close(handle)
