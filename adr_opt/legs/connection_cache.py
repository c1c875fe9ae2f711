"""Cache of connections: all pairs, or those used most recently where memory is short."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable
from threading import Lock

from ..kernels.legs.found import ConnectionArrays

Pair = tuple[int, int]
"""Numbers of origin and destination."""


class ConnectionCache:
    """Least-recently-used cache of the connections of pairs, bounded in bytes.

    Beyond the bound, the least recently used connections are dropped, and computed again when
    next needed. Threads may share it.

    Parameters
    ----------
    room_bytes : float
        Memory that they may take.

    Attributes
    ----------
    room_bytes : float
    bytes : int
        Memory that they take.
    """

    def __init__(self, room_bytes: float = math.inf) -> None:
        self.room_bytes = room_bytes
        self.bytes = 0
        self._found: OrderedDict[Pair, ConnectionArrays] = OrderedDict()
        self._lock = Lock()

    def __len__(self) -> int:
        return len(self._found)

    def limit(self, room_bytes: float) -> None:
        """Change the bound on memory, and keep to it from now on; with 0, nothing is cached."""
        with self._lock:
            self.room_bytes = room_bytes
            self._shrink()

    def get(self, pair: Pair, find: Callable[[], ConnectionArrays]) -> ConnectionArrays:
        """The connections of a pair, computed by ``find`` if not cached."""
        with self._lock:
            known = self._found.get(pair)
            if known is not None:
                self._found.move_to_end(pair)
                return known
        made = find()
        with self._lock:
            if pair not in self._found:
                self._found[pair] = made
                self.bytes += _bytes_of(made)
                self._shrink()
        return made

    def _shrink(self) -> None:
        while self._found and self.bytes > self.room_bytes:
            self.bytes -= _bytes_of(self._found.popitem(last=False)[1])


def _bytes_of(found: ConnectionArrays) -> int:
    return sum(column.nbytes for column in found)
