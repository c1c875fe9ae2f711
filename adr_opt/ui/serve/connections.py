"""Connections: few are open to those who have not shown the token, and none for long."""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

from .guard import WELCOME

MOST_KNOWN = 64
"""Maximum number of connections that have shown the token."""

MOST_STRANGERS = 16
"""Maximum number of connections that have not; the oldest of them makes room for the next."""

PATIENCE_S = 5.0
"""Longest wait for the token [s]."""


class Strangers:
    """Open connections that have not shown the token, the oldest first."""

    def __init__(self) -> None:
        self._waiting: dict[H11Protocol, asyncio.TimerHandle] = {}

    def add(self, one: H11Protocol) -> None:
        """Wait for the token of a new connection."""
        self._waiting[one] = one.loop.call_later(PATIENCE_S, self._close, one)
        if len(self._waiting) > MOST_STRANGERS:
            self._close(next(iter(self._waiting)))

    def forget(self, one: H11Protocol) -> None:
        """Stop waiting: the connection is known, or has ended."""
        timer = self._waiting.pop(one, None)
        if timer is not None:
            timer.cancel()

    def _close(self, one: H11Protocol) -> None:
        self.forget(one)
        # Not counted from here on: known connections would be refused until its end is noticed.
        one.connections.discard(one)
        one.transport.abort()


def connections() -> type[H11Protocol]:
    """The protocol of a server, whose connections are strangers at first."""
    strangers = Strangers()

    class Connection(H11Protocol):
        """A connection."""

        def __init__(self, *given: Any, **named: Any) -> None:
            super().__init__(*given, **named)
            self.app_state = {**self.app_state, WELCOME: lambda: strangers.forget(self)}

        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            """Begin as a stranger."""
            super().connection_made(transport)
            strangers.add(self)

        def connection_lost(self, exc: Exception | None) -> None:
            """End."""
            strangers.forget(self)
            super().connection_lost(exc)

    return Connection
