"""A project of ``serve`` by its addresses, without a browser."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

from serve_desks import session_of

from adr_opt.ui.serve.folder import Folder

BYTES = {"content-type": "application/octet-stream"}


class At:
    """A desk on a project folder with a client that has the token."""

    def __init__(self, folder: Path) -> None:
        from starlette.testclient import TestClient

        from adr_opt.ui.serve.app import application
        from adr_opt.ui.serve.backend import Backend

        self.session = session_of(None, None, Folder(folder))
        self.desk = Backend(self.session)
        app = application(self.desk, "token", 8123, threading.Event())
        self.client = TestClient(app, base_url="http://127.0.0.1:8123")
        self.client.cookies.set("adr-opt-8123", "token")

    def get(self, path: str) -> Any:
        """What an address gives."""
        answer = self.client.get(path)
        assert answer.status_code == 200, answer.text
        return answer.json()

    def post(self, path: str, content: Any = None, status: int = 200) -> Any:
        """What an address answers."""
        answer = self.client.post(path, json={} if content is None else content)
        assert answer.status_code == status, answer.text
        return answer.json()

    def drop(self, name: str, content: bytes, status: int = 200) -> Any:
        """What comes of a dropped file."""
        answer = self.client.post("/upload", params={"name": name}, content=content, headers=BYTES)
        assert answer.status_code == status, answer.text
        return answer.json()

    def done(self, job: int) -> dict[str, Any]:
        """A job once it is over."""
        end = time.monotonic() + 120.0
        while True:
            (row,) = [each for each in self.get("/jobs") if each["id"] == job]
            if row["state"] not in ("waiting", "running"):
                return dict(row)
            assert time.monotonic() < end, row
            time.sleep(0.05)

    def close(self) -> None:
        """End all work."""
        assert self.desk.close(60.0)
