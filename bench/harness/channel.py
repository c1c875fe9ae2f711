"""A line from worker processes of this machine to the coordinator.

Rows arrive the moment they are finished, not when their task is; and a worker whose coordinator is
gone, killed perhaps, hears of it here and ends.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import threading
from collections.abc import Callable
from multiprocessing.connection import Client, Connection, Listener
from typing import Any

Address = tuple[tuple[str, int], bytes]


class Channel:
    """The coordinator's end: listens on a loopback port, with a key that only workers are told.

    Parameters
    ----------
    hear : callable
        Called with every message, from threads of the channel.
    """

    def __init__(self, hear: Callable[[Any], None]) -> None:
        self._hear = hear
        key = secrets.token_bytes(32)
        self._listener = Listener(("127.0.0.1", 0), backlog=64, authkey=key)
        host, port = self._listener.address
        self.address: Address = ((host, port), key)
        self._closed = False
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while not self._closed:
            # A worker that dies while it says hello must not end the line of the others.
            with contextlib.suppress(Exception):
                line = self._listener.accept()
                threading.Thread(target=self._listen, args=(line,), daemon=True).start()

    def _listen(self, line: Connection) -> None:
        with contextlib.suppress(EOFError, OSError), line:
            while True:
                self._hear(line.recv())

    def close(self) -> None:
        """Stop listening."""
        self._closed = True
        self._listener.close()


def connect(address: Address) -> Callable[[Any], None]:
    """A worker's end: what it sends with. The process ends when the coordinator is gone."""
    place, key = address
    line = Client(place, authkey=key)

    def watch() -> None:
        with contextlib.suppress(EOFError, OSError):
            line.recv()  # nothing is ever sent this way
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    return line.send
