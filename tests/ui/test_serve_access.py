"""``serve``: who gets to the page, and who cannot keep others from it."""

from __future__ import annotations

import http.client
import os
import re
import signal
import socket
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from interruptible import CHILD

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")

from serve_desks import session_of, until

from adr_opt.ui.serve import server as serving
from adr_opt.ui.serve.backend import Backend
from adr_opt.ui.serve.folder import Folder
from adr_opt.ui.serve.server import Server, listening


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    """A server on a new project."""
    desk = Backend(session_of(None, None, Folder(tmp_path / "project")))
    made = Server(desk, listening())
    made.start()
    yield made
    made.close()
    assert desk.close(60.0)


class Known:
    """A connection whose owner has the token."""

    def __init__(self, server: Server) -> None:
        self._server = server
        self._connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30.0)

    def asks(self) -> int:
        """Status of an answer."""
        token = self._server.url.partition("=")[2]
        self._connection.request("GET", f"/state?token={token}")
        answer = self._connection.getresponse()
        answer.read()
        return answer.status

    def close(self) -> None:
        """End it."""
        self._connection.close()


def idle(server: Server, count: int) -> list[socket.socket]:
    """Connections of somebody who says nothing."""
    return [socket.create_connection(("127.0.0.1", server.port)) for _ in range(count)]


def ended(one: socket.socket) -> bool:
    """Whether the server has closed a connection."""
    one.setblocking(False)
    try:
        return one.recv(1) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True


def test_strangers_keep_nobody_out(server: Server) -> None:
    """A hundred idle connections without the token leave room for those that have it."""
    first = Known(server)
    assert first.asks() == 200
    strangers = idle(server, 100)
    try:
        until(lambda: sum(map(ended, strangers)) >= 100 - serving.MOST_STRANGERS)
        assert sum(map(ended, strangers)) == 100 - serving.MOST_STRANGERS
        assert first.asks() == 200
        later = Known(server)
        assert (later.asks(), later.asks()) == (200, 200)
        later.close()
    finally:
        for one in strangers:
            one.close()
        first.close()


def test_an_open_connection_is_answered_while_strangers_come(server: Server) -> None:
    """However many connections are cut off at once, the known one is never refused."""
    first = Known(server)
    answers = [first.asks()]
    for _ in range(5):
        strangers = []
        for _ in range(100):
            one = socket.socket()
            one.setblocking(False)
            one.connect_ex(("127.0.0.1", server.port))
            strangers.append(one)
        answers += [first.asks(), first.asks()]
        for one in strangers:
            one.close()
    first.close()
    assert answers == [200] * len(answers)


def test_a_connection_without_the_token_does_not_last(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who says nothing, or half of something, or has no token, is cut off; the others stay."""
    monkeypatch.setattr(serving, "PATIENCE_S", 0.5)
    known = Known(server)
    assert known.asks() == 200
    silent, slow, wrong = idle(server, 3)
    slow.sendall(b"POST /upload?name=a HTTP/1.1\r\nHost: 127.0.0.1\r\n")
    wrong.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n" % server.port)
    with suppress(OSError):
        assert wrong.recv(12) == b"HTTP/1.1 403"
    for one in (silent, slow):
        until(lambda one=one: ended(one))
        one.close()

    def over() -> bool:
        with suppress(OSError):
            while wrong.recv(4096):
                pass
        return ended(wrong)

    until(over)
    wrong.close()
    assert known.asks() == 200
    known.close()


def test_a_refused_body_is_not_read(server: Server) -> None:
    """Without the token an upload is refused by its head, whatever is said of its size."""
    one = socket.create_connection(("127.0.0.1", server.port))
    one.settimeout(30.0)
    one.sendall(
        b"POST /upload?name=a HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nContent-Length: 1000000000\r\n"
        b"Content-Type: application/octet-stream\r\n\r\n" % server.port
    )
    said = b""
    while more := one.recv(4096):
        said += more
    one.close()
    assert said.startswith(b"HTTP/1.1 403")
    assert b"connection: close" in said.lower()


def test_the_token_goes_to_the_browser_by_a_private_file(server: Server, tmp_path: Path) -> None:
    """The file has the address, is for its owner alone, and is gone once the page was asked for."""
    folder = tmp_path / "project"
    address = server.launch(folder)
    token = server.url.partition("=")[2]
    assert address.startswith("file://")
    assert token not in address
    path = Path(address.removeprefix("file://"))
    assert path.parent == folder
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert server.url in path.read_text()
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30.0)
    connection.request("GET", "/?token=wrong")
    assert connection.getresponse().status == 403
    connection.close()
    assert path.exists()
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30.0)
    connection.request("GET", f"/?token={token}")
    assert connection.getresponse().status == 200
    connection.close()
    assert not path.exists()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="opens files as Linux does")
def test_no_command_line_has_the_token(tmp_path: Path) -> None:
    """What is opened is a file whose name says nothing; at the end it is gone, opened or not."""
    opener = tmp_path / "bin/xdg-open"
    opener.parent.mkdir()
    opener.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/opened\n')
    opener.chmod(0o700)
    process = subprocess.Popen(
        [sys.executable, "-c", CHILD, "serve", "--folder", "project"],
        cwd=tmp_path,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "PATH": f"{opener.parent}{os.pathsep}{os.environ['PATH']}"},
    )
    try:
        assert process.stdout is not None
        url = process.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[\w-]{43}", url)
        until(lambda: (tmp_path / "opened").exists() and (tmp_path / "opened").read_text())
        opened = (tmp_path / "opened").read_text().strip()
        assert url.partition("=")[2] not in opened
        path = Path(opened.removeprefix("file://"))
        assert url in path.read_text()
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=90.0)
    assert process.returncode == 0
    assert not path.exists()
