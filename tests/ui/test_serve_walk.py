"""The way from a catalogue to a zip file on the page of ``serve``, in a browser."""

from __future__ import annotations

import os
from pathlib import Path
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


def judged(tab: browser.Browser) -> None:
    """Nothing keeps anybody from using the page as it stands, however it is looked at."""
    for width, dark in LOOKS:
        look(tab, width, dark)
        assert barriers(tab) == [], (width, dark)
    look(tab, *LOOKS[0])


def shown(tab: browser.Browser) -> int:
    """Number of objects that pass the filters."""
    return int(text(tab, "objects-count").split()[0].replace(",", ""))


def brushed(tab: browser.Browser) -> None:
    """Rectangles of two plots intersect; Escape clears them; fields of ranges do the same."""
    drag(tab, ".brushed", (0.65, 0.9), (0.99, 0.05))
    tab.wait_for(f"!document.getElementById('objects-count').textContent.startsWith('{OBJECTS:,}')")
    first = shown(tab)
    drag(tab, ".plot:nth-child(2) .brushed", (0.3, 0.9), (0.5, 0.05))
    tab.wait_for("document.getElementById('chips').children.length === 2")
    assert 0 < shown(tab) < first < OBJECTS
    for kind in ("keyDown", "keyUp"):
        tab.call("Input.dispatchKeyEvent", type=kind, key="Escape", windowsVirtualKeyCode=27)
    tab.wait_for(f"document.getElementById('objects-count').textContent.startsWith('{OBJECTS:,}')")
    put(tab, "Inclination [deg], from", 98)
    put(tab, "Node [deg], from", 100)
    put(tab, "Node [deg], to", 100.8)
    tab.wait_for("!document.getElementById('choose').disabled")
    assert 3 < shown(tab) < 30


def test_from_a_catalogue_to_an_export(tmp_path: Path) -> None:
    """Somebody drops 24,000 objects, brushes, chooses, edits, plans, checks, compares, exports.

    Nothing is on the console, no request leaves the machine, and what is exported are the files
    of the command line.
    """
    catalogue = tmp_path / "drawn.tle"
    catalogue.write_text(as_tle(field(OBJECTS)))
    with (
        served(tmp_path, "--folder", "project") as said,
        browser.Browser(tmp_path / "profile") as tab,
    ):
        tab.go(said["url"])
        on_page(tab, "stage", "empty")
        drop(tab, catalogue)
        on_page(tab, "objects", OBJECTS)
        brushed(tab)
        judged(tab)
        click(tab, "choose")
        on_page(tab, "stage", "mission")
    assert adr_opt
    assert urlsplit
