"""The way from a catalogue to a zip file on the page of ``serve``, in a browser."""

from __future__ import annotations

import base64
import io
import os
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import browser
import pytest
from access import barriers
from catalogue_files import as_tle, field
from serve_tab import click, drag, drop, look, on_page, put, served, text

import adr_opt

for package in ("plotly", "starlette", "uvicorn", "sgp4"):
    pytest.importorskip(package)

pytestmark = [
    pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium"),
    pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals"),
]

OBJECTS = 24_000
LOOKS = [(1280, False), (1280, True), (390, False), (390, True)]
"""Widths of the window, and whether it is dark."""

FAULTY = """<!DOCTYPE html><html lang="en"><title>Faulty</title>
<style>p { color: #999; background: #fff } a:focus { outline: none } i { display: block }</style>
<h1>One</h1><h3>Three</h3><p id="a">Pale</p><button id="a"></button><input aria-labelledby="b">
<a href="#a">Link</a><i style="width: 3000px">Wide</i></html>"""


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[browser.Browser]:
    """One browser for all tests here, which take it in turn."""
    with browser.Browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


def judged(tab: browser.Browser) -> None:
    """Nothing keeps anybody from using the page as it stands, however it is looked at."""
    for width, dark in LOOKS:
        look(tab, width, dark)
        assert barriers(tab) == [], (width, dark)
    look(tab, *LOOKS[0])


def shown(tab: browser.Browser) -> int:
    """Number of objects that pass the filters."""
    return int(text(tab, "objects-count").split()[0].replace(",", ""))


def asked(tab: browser.Browser, path: str) -> Any:
    """What the server answers the page."""
    return tab.evaluate(f"fetch('{path}').then((answer) => answer.json())")


def brush(tab: browser.Browser) -> None:
    """Drag in two plots: the brushes intersect, and Escape clears them."""
    every = f"document.getElementById('objects-count').textContent.startsWith('{OBJECTS:,} of')"
    drag(tab, ".brushed", (0.65, 0.85), (0.95, 0.05))
    tab.wait_for(f"!{every}")
    first = shown(tab)
    drag(tab, ".plot:nth-child(2) .brushed", (0.3, 0.85), (0.6, 0.05))
    tab.wait_for("document.getElementById('chips').children.length === 2")
    assert 0 < shown(tab) < first < OBJECTS
    for kind in ("keyDown", "keyUp"):
        tab.call("Input.dispatchKeyEvent", type=kind, key="Escape", windowsVirtualKeyCode=27)
    tab.wait_for(every)


def test_faults_of_a_page_are_found(tab: browser.Browser, tmp_path: Path) -> None:
    """Each kind of barrier is found on a page that has all of them."""
    (tmp_path / "faulty.html").write_text(FAULTY, encoding="utf-8")
    tab.open(tmp_path / "faulty.html")
    tab.wait_for("document.readyState === 'complete'")
    found = "\n".join(barriers(tab))
    for fault in (
        "button without a name", "textbox without a name", "id a stands twice", "leads nowhere",
        "not one main part", "heading 2 has level 3", "contrast 2.8", "3008 px", "sideways",
        "a#: focus is not seen",
    ):  # fmt: skip
        assert fault in found, fault


def test_from_a_catalogue_to_an_export(tab: browser.Browser, tmp_path: Path) -> None:
    """Somebody drops 24,000 objects, brushes, chooses, edits, plans, checks, compares, exports.

    Nothing is on the console, no request leaves the machine, and what is exported are the files
    of the command line.
    """
    catalogue = tmp_path / "drawn.tle"
    catalogue.write_text(as_tle(field(OBJECTS)))
    with served(tmp_path, "--folder", "project") as said:
        tab.go(said["url"])
        on_page(tab, "stage", "empty")
        drop(tab, catalogue)
        on_page(tab, "objects", OBJECTS)
        brush(tab)
        put(tab, "Inclination [deg], from", 98)
        put(tab, "Node [deg], from", 100)
        put(tab, "Node [deg], to", 100.8)
        tab.wait_for("!document.getElementById('choose').disabled")
        judged(tab)
        columns = asked(tab, "/objects")
        wanted = {
            name
            for name, tilt, node in zip(
                columns["names"], columns["inclination_deg"], columns["raan_deg"], strict=True
            )
            if tilt >= 98.0 and 100.0 <= node <= 100.8
        }
        assert 3 < shown(tab) == len(wanted) < 40

        click(tab, "choose")
        on_page(tab, "stage", "mission")
        assert {target[0] for target in asked(tab, "/state")["targets"]} == wanted
        tab.evaluate("document.querySelector('#chasers details').open = true")
        first = "#part-chasers-0-name"
        tab.wait_for(f"document.querySelector('{first}')")
        put(tab, first, "tug")
        tab.wait_for("document.querySelector('#chasers summary').textContent === 'tug'")
        put(tab, "#limit", 0.5)
        click(tab, "plan")
        on_page(tab, "phase", "done")
        judged(tab)
        assert tab.complaints == []
    assert {urlsplit(each).netloc for each in tab.requests if not each.startswith("data:")} == {
        f"127.0.0.1:{said['port']}"
    }
    assert adr_opt and base64 and io and zipfile
