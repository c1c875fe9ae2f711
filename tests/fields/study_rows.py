"""Rows of small studies: in a module of their own, so that other processes can import them."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any, NamedTuple

from adr_opt.common.errors import InputError
from adr_opt.study import Place, Study


class Rows(NamedTuple):
    """Rows that leave a mark for each time that one is made.

    ``raises``, ``dies`` and ``stumbles`` are keys whose rows raise, kill their process each time,
    or the first time only.
    """

    folder: Path
    raises: tuple[int, ...] = ()
    dies: tuple[int, ...] = ()
    stumbles: tuple[int, ...] = ()

    def row(self, key: int, place: Place) -> dict[str, Any]:
        """The square of a key."""
        with (self.folder / f"made-{key}").open("a") as marks:
            marks.write("x")
        if key in self.raises:
            raise InputError(f"{key} has no square")
        if key in self.dies or (key in self.stumbles and self.made(key) == 1):
            os.kill(os.getpid(), signal.SIGKILL)
        return {"square": key * key}

    def made(self, key: int) -> int:
        """How often a row was made."""
        path = self.folder / f"made-{key}"
        return path.stat().st_size if path.exists() else 0


def squares(rows: Rows, *, of: str = "naïve", **more: Any) -> Study[int, dict[str, Any]]:
    """A study of such rows."""
    return Study("squares", more.pop("version", 1), rows.row, {"settings": of}, **more)


def told(key: int, error: Exception) -> dict[str, Any]:
    """The row of a key that failed."""
    return {"failed": type(error).__name__}


def unsendable(key: int, place: Place) -> int:
    """Raise an error that no other process can read."""

    class Odd(Exception):
        pass

    raise Odd(f"{key} is odd")


def asleep(key: int, place: Place) -> int:
    """Take some seconds."""
    time.sleep(key)
    return key
