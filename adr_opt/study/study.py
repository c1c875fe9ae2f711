"""A study: rows as a function of their keys, with everything else that they depend on."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, NamedTuple, TypeVar

from ..common.stop import Stop

K = TypeVar("K")
V = TypeVar("V")


class Place(NamedTuple):
    """Where a row is made.

    Attributes
    ----------
    alone : bool
        Whether it may use all cores, as no other row is made beside it.
    stop : Stop or None
        What ends the study early; a row that it cuts short is not kept.
    """

    alone: bool = True
    stop: Stop | None = None

    @property
    def is_over(self) -> bool:
        """Whether to begin no further row."""
        return self.stop is not None and self.stop.remaining_s() <= 0.0


def _itself(value: Any) -> Any:
    return value


def _as_stored(key: Any, value: Any) -> Any:
    return value


@dataclass(frozen=True)
class Study(Generic[K, V]):
    """Definition of a study: the function of a row, and the stored form of keys and rows.

    Attributes
    ----------
    protocol : str
        What rows are, in a word.
    version : int
        Of the protocol: rows of another one mean something else.
    row : callable
        Makes the row of a key at a :class:`Place`. To be sent to other processes it has to be
        picklable: a function of a module, or a method of a picklable object. That object is sent
        once to each process, so that it may keep what its rows share.
    of : mapping of str to JSON data
        All that rows depend on besides their keys, by words for messages, as "settings".
    key : callable
        A key as JSON data, by which its row is known.
    to_json : callable
        A row as JSON data, with finite numbers.
    from_json : callable
        The row of a key from such data; raises ValueError, TypeError or KeyError for other data,
        or InputError to say why.
    failed : callable, optional
        The row of a key whose making raised an error, or killed its process twice
        (:class:`.workers.WorkerDied`). Without it the error ends the study.
    apart : bool
        Whether rows are made in other processes even if it is one after the other.
    """

    protocol: str
    version: int
    row: Callable[[K, Place], V]
    of: Mapping[str, Any] = field(default_factory=dict)
    key: Callable[[K], Any] = _itself
    to_json: Callable[[V], Any] = _itself
    from_json: Callable[[K, Any], V] = _as_stored
    failed: Callable[[K, Exception], V] | None = None
    apart: bool = False

    def name(self, key: K) -> str:
        """The one text of a key."""
        return text_of(self.key(key))


def text_of(data: Any) -> str:
    """The one text of JSON data; a number that is not finite raises ValueError."""
    return json.dumps(
        data, ensure_ascii=False, allow_nan=False, sort_keys=True, separators=(",", ":")
    )
