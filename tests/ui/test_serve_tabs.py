"""Many tabs of the page of ``serve`` in one browser, and tabs whose server has ended."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import browser
import pytest
from hand_made import hand_made
from serve_desks import session_of
from serve_tab import Tabs, click, on_page, put, served, text

for package in ("plotly", "starlette", "uvicorn"):
    pytest.importorskip(package)

from adr_opt.ui.serve import app  # noqa: E402
from adr_opt.ui.serve.desk import Desk  # noqa: E402
from adr_opt.ui.serve.folder import Folder  # noqa: E402
from adr_opt.ui.serve.server import Server, listening  # noqa: E402

pytestmark = [
    pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium"),
    pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals"),
]

QUIET_S = 3.0
"""A page that tries to reach its server again and again would have tried by then."""


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[browser.Browser]:
    """One browser for all tests here, which take it in turn."""
    with browser.Browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


@pytest.fixture
def streams(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[str, list[int]]]:
    """Address of a server in this process, and which of its streams are open."""
    said, held, count = app.told, [], iter(range(1000))

    async def counted(desk: Desk, closing: threading.Event) -> AsyncIterator[str]:
        number = next(count)
        held.append(number)
        try:
            async for each in said(desk, closing):
                yield each
        finally:
            held.remove(number)

    monkeypatch.setattr(app, "told", counted)
    desk = Desk(session_of(hand_made(), None, Folder(tmp_path / "work", tmp_path / "my.json")))
    server = Server(desk, listening())
    server.start()
    yield server.url, held
    server.close()
    assert desk.close(60.0)


@pytest.mark.parametrize("count", [8, pytest.param(20, marks=pytest.mark.slow)])
def test_tabs_share_one_stream_and_all_answer(
    tab: browser.Browser, streams: tuple[str, list[int]], count: int
) -> None:
    """Each of many tabs loads and answers; all see an edit, by one stream while one is seen."""
    url, held = streams
    with Tabs(tab, count) as tabs:
        for number in tabs:
            tab.call("Page.bringToFront")
            tab.go(url)
            on_page(tab, "phase", "idle", 20.0)
            print(tab.evaluate("document.visibilityState"), held)
            put(tab, "Prize of north", str(number + 2))
            on_page(tab, "revision", number + 1, 20.0)
        assert len(held) == 1
        for _ in tabs:
            tab.call("Page.bringToFront")
            on_page(tab, "revision", count, 20.0)
            assert tab.evaluate("fetch('/state').then((answer) => answer.status)") == 200
            assert len(held) <= 1
