"""Workers that compute rows: this process, others of this machine, or those of a cluster."""

from __future__ import annotations

import pickle
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import BrokenExecutor
from typing import Any, NamedTuple, Protocol

from .study import Place

Row = Callable[[Any, Place], Any]


class WorkerDied(BrokenExecutor):
    """The process that computed a row died twice."""


class Answer(NamedTuple):
    """Outcome of a key: its row, or an error.

    Attributes
    ----------
    value : object
        Its row; None where there is an error.
    error : Exception or None
    seconds : float
    """

    value: Any
    error: Exception | None
    seconds: float


class Workers(Protocol):
    """Interface of workers that compute rows for groups of keys, several groups at once."""

    @property
    def count(self) -> int:
        """Number of groups at once."""
        ...

    @property
    def busy(self) -> int:
        """Number of groups that are being made."""
        ...

    def submit(self, keys: tuple[Any, ...]) -> None:
        """Submit a group of keys, whose rows one process computes in order."""
        ...

    def wait(self, longest_s: float) -> list[tuple[Any, Answer]]:
        """What has come of keys since the last call, after a wait for the first of them."""
        ...

    def close(self) -> None:
        """End all work, finished or not."""
        ...


class Here:
    """Rows computed in this process, one after another.

    Parameters
    ----------
    row : callable
    place : Place
    """

    count = 1

    def __init__(self, row: Row, place: Place) -> None:
        self._row, self._place = row, place
        self._waiting: deque[Any] = deque()

    @property
    def busy(self) -> int:
        """Number of groups that are being made."""
        return int(bool(self._waiting))

    def submit(self, keys: tuple[Any, ...]) -> None:
        """Take the keys of a group."""
        self._waiting.extend(keys)

    def wait(self, longest_s: float) -> list[tuple[Any, Answer]]:
        """Compute the next row; nothing if it was cut short."""
        key = self._waiting.popleft()
        made = made_of(self._row, key, self._place)
        return [] if self._place.is_over else [(key, made)]

    def close(self) -> None:
        """Discard the remaining keys."""
        self._waiting.clear()


def made_of(row: Row, key: Any, place: Place) -> Answer:
    """The row of a key, or the error that it raised."""
    began = time.perf_counter()
    try:
        value, error = row(key, place), None
    except Exception as raised:
        value, error = None, raised
    return Answer(value, error, time.perf_counter() - began)


def sendable(made: Answer) -> Answer:
    """An answer that can be pickled; an error that cannot is replaced by its text."""
    try:
        pickle.loads(pickle.dumps(made))
    except Exception as raised:
        said = made.error if made.error is not None else raised
        return Answer(None, RuntimeError(f"{type(said).__name__}: {said}"), made.seconds)
    return made
