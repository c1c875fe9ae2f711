"""Python processes of the server: of lower priority, and never outliving it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

NICENESS = 10
"""Increment of niceness over the server's, so that the server answers while all cores work."""

PRIVATE = 0o077
"""Mask of modes of the files that they write."""


def started(
    module: str, arguments: Sequence[str], variables: Mapping[str, str] | None = None, **more: Any
) -> subprocess.Popen[bytes]:
    """Start a module of this package in a Python process of its own.

    Its standard input is a pipe that ends when this process does; Ctrl-C does not reach it. What
    lies in its working folder is not imported.

    Parameters
    ----------
    module : str
        Its full name.
    arguments : sequence of str
    variables : mapping of str to str, optional
        Further variables of its environment.
    **more
        Of :class:`subprocess.Popen`.
    """
    package = Path(__file__).resolve().parents[3]
    known = os.environ.get("PYTHONPATH")
    path = os.pathsep.join([str(package), *([known] if known else [])])
    return subprocess.Popen(
        [sys.executable, "-P", "-m", module, *arguments],
        stdin=subprocess.PIPE,
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": path, "PYTHONUNBUFFERED": "1", **(variables or {})},
        **more,
    )


@contextmanager
def private_files() -> Iterator[None]:
    """Make new files readable by their owner only."""
    before = os.umask(PRIVATE)
    try:
        yield
    finally:
        os.umask(before)


def settle_in() -> None:
    """Lower the priority and make files private; called by the process itself."""
    os.umask(PRIVATE)
    with suppress(OSError, AttributeError):
        os.nice(NICENESS)


def leave() -> None:
    """End this process and all its children at once."""
    with suppress(OSError, AttributeError):
        if os.getpgrp() == os.getpid():
            os.killpg(os.getpid(), signal.SIGKILL)
    os._exit(1)


def end(process: subprocess.Popen[bytes]) -> None:
    """End a process and all its children at once."""
    with suppress(OSError, AttributeError):
        os.killpg(process.pid, signal.SIGKILL)
    with suppress(OSError):
        process.kill()
