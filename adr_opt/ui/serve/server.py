"""The server, on 127.0.0.1 only."""

from __future__ import annotations

import asyncio
import html
import logging
import secrets
import socket
import threading
from pathlib import Path
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from ...common.errors import InputError
from .app import application
from .backend import Backend
from .guard import WELCOME
from .project.private import passing, private_file

PAGE = (
    '<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>adr-opt</title>'
    '<meta name="referrer" content="no-referrer">'
    '<meta http-equiv="refresh" content="0; url={url}"></html>\n'
)


class LaunchFile:
    """A page that leads to an address, readable by its owner alone, until it is removed.

    Parameters
    ----------
    folder : path
        Readable by its owner alone.
    url : str
        The address, with its token.

    Attributes
    ----------
    address : str
        Of the file.
    """

    def __init__(self, folder: Path, url: str) -> None:
        self._path = passing(folder, ".html")
        with private_file(self._path) as file:
            file.write(PAGE.format(url=html.escape(url)).encode())
        self.address = self._path.as_uri()

    def remove(self) -> None:
        """Remove the file after use, or if it is not needed."""
        self._path.unlink(missing_ok=True)


MOST_KNOWN = 64
"""Maximum number of connections that have shown the token."""

MOST_STRANGERS = 16
"""Maximum number of connections without the token; the oldest is closed for a new one."""

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
            """Register the connection as one without the token."""
            super().connection_made(transport)
            strangers.add(self)

        def connection_lost(self, exc: Exception | None) -> None:
            """End."""
            strangers.forget(self)
            super().connection_lost(exc)

    return Connection


HOST = "127.0.0.1"
LAST_ANSWERS_S = 2
"""Longest wait for pending answers at the end [s]."""

KEPT_ALIVE_S = 60
"""How long a known connection is kept for the next request [s]."""


def listening(port: int = 0) -> socket.socket:
    """A socket that listens on a local port, 0 for any free one.

    Raises
    ------
    InputError
        The port is taken, or is none.
    """
    if not 0 <= port <= 65535:
        raise InputError(f"--port {port}: must be between 0 and 65535; 0 for any free port")
    try:
        return socket.create_server((HOST, port))
    except OSError as error:
        raise InputError(
            f"--port {port}: cannot be opened ({error.strerror}); name another one, or none"
        ) from None


class Server:
    """A backend on a local port.

    Parameters
    ----------
    backend : Backend
    listener : socket
        As :func:`listening` gives it.

    Attributes
    ----------
    port : int
    url : str
        The address of the page, with its token.
    """

    def __init__(self, backend: Backend, listener: socket.socket) -> None:
        self._socket = listener
        self.port: int = self._socket.getsockname()[1]
        token = secrets.token_urlsafe(32)
        self.url = f"http://{HOST}:{self.port}/?token={token}"
        self._launch: LaunchFile | None = None
        self._closing = threading.Event()
        self._server = uvicorn.Server(
            uvicorn.Config(
                application(backend, token, self.port, self._closing, self._opened),
                http=connections(),
                ws="none",
                loop="asyncio",
                lifespan="off",
                log_config=None,
                access_log=False,
                server_header=False,
                proxy_headers=False,
                limit_concurrency=MOST_KNOWN + MOST_STRANGERS,
                timeout_keep_alive=KEPT_ALIVE_S,
                timeout_graceful_shutdown=LAST_ANSWERS_S,
            )
        )
        # A thread of its own: signals are heard by the main one, for the planner too.
        self._thread = threading.Thread(
            target=self._server.run, kwargs={"sockets": [self._socket]}, name="server", daemon=True
        )

    def start(self) -> None:
        """Start answering."""
        self._thread.start()

    def launch(self, folder: Path) -> str:
        """Address of a private file in a folder that leads to the page once.

        Raises
        ------
        OSError
            It cannot be written.
        """
        self._launch = LaunchFile(folder, self.url)
        return self._launch.address

    def _opened(self) -> None:
        """The page was asked for."""
        if self._launch is not None:
            self._launch.remove()

    def wait(self, ended: threading.Event) -> None:
        """Answer until ended."""
        while self._thread.is_alive() and not ended.wait(0.5):
            pass

    def close(self) -> None:
        """Stop answering."""
        # What is cut off at the end is meant to be: nobody needs to read of it.
        logging.getLogger("uvicorn.error").setLevel(logging.CRITICAL + 1)
        self._closing.set()
        self._opened()
        self._server.should_exit = True
        self._thread.join(LAST_ANSWERS_S + 3.0)
        self._socket.close()
