"""Many tabs of the page of ``serve`` in one browser, and tabs whose server has ended."""

from __future__ import annotations

import socket
import threading
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import browser
import pytest
from hand_made import hand_made
from serve_catalogue import catalogue
from serve_desks import session_of, until
from serve_tab import Tabs, click, drop, on_page, put, text

for package in ("plotly", "starlette", "uvicorn", "sgp4"):
    pytest.importorskip(package)

from adr_opt.common.errors import InputError  # noqa: E402
from adr_opt.ui.serve import app  # noqa: E402
from adr_opt.ui.serve.backend import Backend  # noqa: E402
from adr_opt.ui.serve.folder import Folder  # noqa: E402
from adr_opt.ui.serve.server import Server, listening  # noqa: E402

pytestmark = pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")

QUIET_S = 1.5
"""A page that tries to reach its server again and again would have tried by then."""


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[browser.Browser]:
    """One browser for all tests here, which take it in turn."""
    with browser.Browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Backend]:
    """A desk with a mission."""
    made = Backend(session_of(hand_made(), None, Folder(tmp_path / "work", tmp_path / "my.json")))
    yield made
    assert made.close(60.0)


@pytest.fixture
def streams(desk: Backend, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[str, list[int]]]:
    """Address of a server in this process, and which of its streams are open."""
    said, held, count = app.event_stream, [], iter(range(1000))

    async def counted(desk: Backend, closing: threading.Event) -> AsyncIterator[str]:
        number = next(count)
        held.append(number)
        try:
            async for each in said(desk, closing):
                yield each
        finally:
            held.remove(number)

    monkeypatch.setattr(app, "event_stream", counted)
    server = Server(desk, listening())
    server.start()
    yield server.url, held
    server.close()


SEEN = "document.visibilityState === 'visible'"


@pytest.mark.parametrize("count", [2, pytest.param(20, marks=pytest.mark.slow)])
def test_tabs_share_one_stream_and_all_answer(
    tab: browser.Browser, streams: tuple[str, list[int]], count: int
) -> None:
    """Be they more than a browser has connections, all load, answer and see an edit."""
    url, held = streams
    with Tabs(tab, count, windows=True) as tabs:
        for _ in tabs:
            tab.go(url)
            on_page(tab, "phase", "idle")
            tab.wait_for(SEEN)
        put(tab, "Prize of north", "5")
        for _ in tabs:
            on_page(tab, "revision", 1)
            assert tab.evaluate("fetch('/state').then((answer) => answer.status)") == 200
        until(lambda: len(held) == 1)


def test_no_stream_is_open_while_no_tab_is_seen(
    tab: browser.Browser, streams: tuple[str, list[int]]
) -> None:
    """A hidden tab closes its stream, and hears what it has missed when it is seen again."""
    url, held = streams
    with Tabs(tab, 2) as tabs:
        for number in tabs:
            tab.call("Page.bringToFront")
            if number == 0:
                tab.go(url)
                on_page(tab, "phase", "idle")
                until(lambda: len(held) == 1)
        until(lambda: not held)
        for number in tabs:
            if number == 0:
                tab.evaluate(
                    "fetch('/edit', { method: 'POST', body: JSON.stringify({ duration_s: 60000 }),"
                    " headers: { 'Content-Type': 'application/json' } })"
                )
                tab.wait_for(f"!({SEEN})")
                assert tab.evaluate("document.documentElement.dataset.revision") == "0"
                tab.call("Page.bringToFront")
                on_page(tab, "revision", 1)
                until(lambda: len(held) == 1)


def asked(port: int) -> int:
    """How often something is asked at a port within some seconds."""
    with socket.create_server(("127.0.0.1", port)) as listener:
        listener.settimeout(QUIET_S)
        try:
            listener.accept()[0].close()
        except TimeoutError:
            return 0
        return 1


def ended(tab: browser.Browser, said: str) -> None:
    """The page says so of its server, whatever is pressed, and shows nothing as going on."""
    on_page(tab, "over", said)
    sentence = text(tab, "error")
    assert "open the address that" in sentence
    click(tab, "plan")
    click(tab, "undo")
    assert tab.evaluate("new Promise((done) => setTimeout(done, 100))") is None
    assert text(tab, "error") == sentence
    assert tab.evaluate("document.querySelector('header .acts').inert")


def test_a_page_whose_server_has_ended_says_so_once_and_asks_no_more(
    tab: browser.Browser, desk: Backend
) -> None:
    """After a few tries no request comes any more, neither by itself nor by pressing a button."""
    server = Server(desk, listening())
    server.start()
    tab.go(server.url)
    on_page(tab, "phase", "idle")
    server.close()
    ended(tab, "lost")
    assert asked(server.port) == 0


def test_a_page_of_an_earlier_server_follows_no_other(tab: browser.Browser, desk: Backend) -> None:
    """Where another one is started at its port, the page says so and changes nothing there."""
    first = Server(desk, listening())
    first.start()
    with Tabs(tab, 2) as tabs:
        for number in tabs:
            tab.call("Page.bringToFront")
            if number == 0:
                tab.go(first.url)
                on_page(tab, "phase", "idle")
            else:
                first.close()
                second = Server(desk, listening(first.port))
                second.start()
                tab.go(second.url)
                on_page(tab, "phase", "idle")
        for number in tabs:
            if number == 0:
                tab.call("Page.bringToFront")
                ended(tab, "restarted")
            else:
                tab.call("Page.bringToFront")
                assert tab.evaluate("document.documentElement.dataset.over") is None
                put(tab, "Prize of north", "5")
                on_page(tab, "revision", 1)
    second.close()
    assert desk.session.revision == 1


def shown(tab: browser.Browser) -> list[str]:
    """Figures of a run or a plan on the page."""
    return [text(tab, name) for name in ("incumbent", "bound-now", "gap")]


def test_a_failure_is_the_headline_without_figures_of_another_run(
    tab: browser.Browser, desk: Backend, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The reason stands first, also when the page is loaded anew, until a plan is shown again."""
    server = Server(desk, listening())
    server.start()
    tab.go(server.url)
    on_page(tab, "phase", "idle")
    put(tab, "#method", "exact")
    click(tab, "plan")
    on_page(tab, "phase", "done")
    on_page(tab, "reported", 1)
    planned = shown(tab)
    assert planned[0] == "3"
    assert tab.evaluate("document.getElementById('failed').hidden")

    def broken(*given: object, **more: object) -> None:
        raise InputError("the sky has fallen")

    with monkeypatch.context() as patch:
        patch.setattr("adr_opt.run.front.run", broken)
        click(tab, "plan")
        on_page(tab, "phase", "failed")
    for _ in range(2):
        on_page(tab, "reported", 0)
        assert text(tab, "failed").startswith("The sky has fallen. Planning failed")
        assert text(tab, "phase") == "Failed"
        assert shown(tab) == ["—", "—", "—"]
        assert tab.evaluate("document.querySelectorAll('tr.visited, #chart polyline').length") == 0
        assert tab.evaluate("document.getElementById('with-notes').hidden")
        tab.call("Page.reload")
        tab.wait_for("document.documentElement?.dataset.phase === 'failed'")
    tab.evaluate("document.querySelector('#results .acts button').click()")
    on_page(tab, "phase", "idle")
    assert text(tab, "phase") == "The plan that is shown"
    assert shown(tab) == planned
    assert tab.evaluate("document.getElementById('failed').hidden")
    server.close()


def test_what_is_wrong_in_a_file_stands_beside_it(
    tab: browser.Browser, tmp_path: Path, desk: Backend
) -> None:
    """Bad rows have place and cause, a refused file its reason, and both can be removed."""
    lines = catalogue(4).decode().splitlines()
    _, row = (row for row, line in enumerate(lines[:6]) if line.startswith("1 "))
    lines[row] = lines[row][:-1] + str((int(lines[row][-1]) + 1) % 10)
    (tmp_path / "few.tle").write_text("\n".join(lines))
    (tmp_path / "spoilt.tle").write_text("\n".join(lines[row : row + 2]))
    server = Server(desk, listening())
    server.start()
    tab.go(server.url)
    on_page(tab, "phase", "idle")
    drop(tab, tmp_path / "few.tle", tmp_path / "spoilt.tle")
    on_page(tab, "objects", 3)
    tab.wait_for("document.querySelectorAll('#files li').length === 2")
    kept, refused = tab.evaluate(
        "[...document.querySelectorAll('#files li')].map((row) => row.textContent)"
    )
    assert "few.tle catalogue, 3; 1 bad row left out" in kept
    assert f"line {row + 1}" in kept
    assert "spoilt.tle refused" in refused
    assert "line 1" in refused
    assert "checksum" in kept
    assert "checksum" in refused
    assert tab.evaluate("document.body.dataset.view") == "objects"
    for left in (1, 0):
        tab.evaluate("document.querySelector('#files li:last-child button').click()")
        tab.wait_for(f"document.querySelectorAll('#files li').length === {left}")
    on_page(tab, "objects", 0)
    server.close()
