"""``serve`` as a process, and its page in a browser."""

from __future__ import annotations

import os
from pathlib import Path
from urllib.parse import urlsplit

import browser
import pytest
from hand_made import hand_made
from serve_tab import click, in_report, on_page, put, served, text

import adr_opt

for package in ("plotly", "starlette", "uvicorn"):
    pytest.importorskip(package)

pytestmark = [
    pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium"),
    pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals"),
]


@pytest.mark.slow
def test_prizes_are_changed_planned_and_undone(tmp_path: Path) -> None:
    """Somebody changes a prize, plans, sees the bound come in and the report, and takes it back.

    The browser asks this server alone, and files come to be in the working folder alone. On a
    phone, in the dark, the page is as wide as the screen, and the report is behind a tab.
    """
    hand_made().save(tmp_path / "my.json")
    work = tmp_path / "my-served"
    with served(tmp_path, "my.json") as said, browser.Browser(tmp_path / "profile") as tab:
        assert said["folder"] == str(work)
        tab.go(said["url"])
        on_page(tab, "reported", 0)
        assert tab.evaluate("location.search") == ""
        put(tab, "Prize of north", "5")
        on_page(tab, "revision", 1)
        assert adr_opt.load(work / "draft.json").targets[0].prize == 5.0
        put(tab, "Prize of north", "-5")
        tab.wait_for("!document.getElementById('error').hidden")
        assert "“Prize” = -5" in text(tab, "error")
        assert tab.evaluate("document.querySelector('[aria-label=\"Prize of north\"]').value") == (
            "5"
        )

        click(tab, "plan")
        tab.wait_for("document.getElementById('bound-now').textContent === '7'")
        on_page(tab, "phase", "done")
        assert [text(tab, name) for name in ("incumbent", "gap")] == ["7", "0 %"]
        assert tab.evaluate("document.querySelectorAll('#chart polyline').length") == 2
        on_page(tab, "reported", 1)
        assert in_report(tab, "document.documentElement?.dataset.ready")
        assert "7" in in_report(tab, "document.querySelector('.headline')?.textContent")
        assert tab.evaluate("document.querySelectorAll('tr.visited').length") == 3
        assert tab.evaluate("document.getElementById('stale').hidden")

        click(tab, "undo")
        on_page(tab, "revision", 3)
        assert not tab.evaluate("document.getElementById('stale').hidden")
        assert tab.evaluate("document.querySelector('[aria-label=\"Prize of north\"]').value") == (
            "1"
        )
        click(tab, "redo")
        tab.wait_for("document.getElementById('stale').hidden")

        put(tab, "#method", "local-search")
        put(tab, "#limit", "3600")
        click(tab, "plan")
        on_page(tab, "phase", "planning")
        click(tab, "stop")
        on_page(tab, "phase", "done")
        on_page(tab, "reported", 3)

        tab.call("Page.reload")
        tab.wait_for("document.documentElement?.dataset.phase === 'done'")
        assert [text for level, text in tab.complaints if "status of 422" not in text] == []
        assert {urlsplit(each).netloc for each in tab.requests if not each.startswith("data:")} == {
            f"127.0.0.1:{said['port']}"
        }
        assert tab.evaluate("document.documentElement.scrollWidth") == 1280
        tab.call(
            "Emulation.setDeviceMetricsOverride",
            width=390,
            height=844,
            deviceScaleFactor=1,
            mobile=True,
        )
        tab.call(
            "Emulation.setEmulatedMedia",
            features=[{"name": "prefers-color-scheme", "value": "dark"}],
        )
        shown = "getComputedStyle(document.getElementById('view')).display"
        assert tab.evaluate("document.documentElement.scrollWidth") == 390
        assert tab.evaluate(shown) == "none"
        click(tab, "to-report")
        assert tab.evaluate(shown) == "block"
        assert in_report(tab, "document.documentElement?.scrollWidth === 390")
        # Whoever ends the verb while it plans waits for what there is.
        put(tab, "#method", "local-search")
        put(tab, "#limit", "3600")
        click(tab, "plan")
        on_page(tab, "phase", "planning")
    assert said["stderr"].startswith("adr-opt: serving 'hand-made', kept in ")
    assert {path.name for path in tmp_path.iterdir()} == {"my.json", "my-served", "profile"}
    assert (tmp_path / "my.json").read_text() == hand_made().to_json()
    instance, plan = adr_opt.load(work / "instance.json"), adr_opt.load_plan(work / "plan.json")
    assert adr_opt.check(instance, plan) == ()
    assert plan.objective == 7.0
