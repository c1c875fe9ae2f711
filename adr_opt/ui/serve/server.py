"""The server: on 127.0.0.1, until it is stopped."""

from __future__ import annotations

import logging
import secrets
import socket
import threading
from pathlib import Path

import uvicorn

from ...common.errors import InputError
from .app import application
from .connections import MOST_KNOWN, MOST_STRANGERS, connections
from .desk import Desk
from .launch import LaunchFile

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
        raise InputError(f"--port {port}: must be between 0 and 65535; 0 for any that is free")
    try:
        return socket.create_server((HOST, port))
    except OSError as error:
        raise InputError(
            f"--port {port}: cannot be listened at ({error.strerror}); name another one, or none"
        ) from None


class Server:
    """A desk on a local port.

    Parameters
    ----------
    desk : Desk
    listener : socket
        As :func:`listening` gives it.

    Attributes
    ----------
    port : int
    url : str
        The address of the page, with its token.
    """

    def __init__(self, desk: Desk, listener: socket.socket) -> None:
        self._socket = listener
        self.port: int = self._socket.getsockname()[1]
        token = secrets.token_urlsafe(32)
        self.url = f"http://{HOST}:{self.port}/?token={token}"
        self._launch: LaunchFile | None = None
        self._closing = threading.Event()
        self._server = uvicorn.Server(
            uvicorn.Config(
                application(desk, token, self.port, self._closing, self._opened),
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
