"""Measure the page of ``serve`` in a browser: its start with 24,000 objects, brushing, planning.

    python bench/serve_page.py                  # needs Chromium and the extra [serve]
    python bench/serve_page.py --objects 24000 --runs 5

`dropped` is the time from letting a catalogue of drawn element sets go on the page until all plots
and the list are there, `reopened` that from asking for the address of the project in a new
process, `frames` how often the page is drawn a second while a rectangle is dragged, and the longest
time between two frames, and `plan` the time from pressing Plan until the first plan is there, for
120 of the objects near one plane; the first press loads what planning needs, the others are warm.
Medians of the runs.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests/oracles"), str(ROOT / "tests/fields")]

import catalogue_files  # noqa: E402
from browser import Browser  # noqa: E402
from serve_tab import click, drag, drop, on_page, put, served, text  # noqa: E402

CLOUD = 120
WATCH = """
new MutationObserver(() => {
  if (!document.documentElement?.dataset.objects || window.there) return;
  window.there = true;
  requestAnimationFrame(() => requestAnimationFrame((now) => { window.drawn_ms = now; }));
}).observe(document, { attributes: true, subtree: true, attributeFilter: ["data-objects"] });
"""
"""Notes when the objects are drawn: the second frame after the one that they came in."""

FRAMES = """
(() => {
  const times = window.frames_ms = [];
  const note = (now) => {
    times.push(now);
    if (window.frames_ms === times) requestAnimationFrame(note);
  };
  requestAnimationFrame(note);
})()
"""

NUMBER = "fetch('/state').then((answer) => answer.json()).then((state) => state.plan.number)"
"""Number of the plan that is shown."""


def since(tab: Browser, began_ms: float) -> float:
    """Seconds from a time of the page until the objects were drawn."""
    drawn: float = tab.wait_for("window.drawn_ms")
    return (drawn - began_ms) / 1000.0


def start(folder: Path, profile: Path, again: Path, catalogue: Path) -> tuple[float, float]:
    """Time until the objects are there, after a drop and after reopening [s]."""
    with served(folder, "--folder", "project") as said, Browser(profile, width=1440) as tab:
        tab.call("Page.addScriptToEvaluateOnNewDocument", source=WATCH)
        tab.go(said["url"])
        on_page(tab, "stage", "empty")
        began = tab.evaluate("performance.now()")
        drop(tab, catalogue)
        dropped = since(tab, began)
    with served(folder, "--folder", "project") as said, Browser(again, width=1440) as tab:
        tab.call("Page.addScriptToEvaluateOnNewDocument", source=WATCH)
        tab.go(said["url"])
        return dropped, since(tab, 0.0)


def brushing(tab: Browser) -> tuple[float, float]:
    """Frames a second while a rectangle is dragged, and the longest time between two [ms]."""
    tab.evaluate(FRAMES)
    drag(tab, ".brushed", (0.15, 0.85), (0.9, 0.15), steps=150)
    at = tab.evaluate("window.frames_ms")
    tab.call("Input.dispatchKeyEvent", type="keyDown", key="Escape", windowsVirtualKeyCode=27)
    gaps = [later - earlier for earlier, later in pairwise(at)]
    return 1000.0 / statistics.mean(gaps), max(gaps)


def plans(tab: Browser, runs: int) -> list[float]:
    """Time from pressing Plan until there is a plan [s], the first with nothing loaded."""
    taken = []
    put(tab, "#limit", 10)
    tab.evaluate("document.getElementById('goes-on').checked = false")
    for _ in range(1 + runs):
        began = time.perf_counter()
        click(tab, "plan")
        tab.wait_for(
            "document.documentElement.dataset.phase === 'planning'"
            " && document.getElementById('incumbent').textContent !== '—'"
        )
        taken.append(time.perf_counter() - began)
        click(tab, "stop")
        on_page(tab, "phase", "done")
        # The report takes processor time, too: the next press finds it there.
        on_page(tab, "reported", tab.evaluate(NUMBER), 300.0)
    return taken


def chosen(tab: Browser) -> None:
    """Make a mission of objects about one plane: nodes around a value, so that few remain."""
    put(tab, "Inclination [deg], from", 98)
    width = 30.0
    while True:
        put(tab, "Node [deg], from", 100)
        put(tab, "Node [deg], to", 100 + width)
        time.sleep(0.5)
        count = int(text(tab, "objects-count").split()[0].replace(",", ""))
        if count <= CLOUD:
            break
        width *= max(CLOUD / count, 0.5) * 0.98
    click(tab, "choose")
    on_page(tab, "stage", "mission")


def measured(objects: int, runs: int) -> list[str]:
    """Rows of the table."""
    opened: list[Any] = []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        catalogue = folder / "drawn.tle"
        catalogue.write_text(catalogue_files.as_tle(catalogue_files.field(objects)))
        for run in range(runs):
            alone = folder / f"run-{run}"
            alone.mkdir()
            profiles = [folder / f"profile-{run}-{turn}" for turn in (0, 1)]
            opened.append(start(alone, *profiles, catalogue))
        with (
            served(alone, "--folder", "project") as said,
            Browser(folder / "profile", width=1440) as tab,
        ):
            tab.go(said["url"])
            on_page(tab, "objects", objects)
            frames = [brushing(tab) for _ in range(runs)]
            chosen(tab)
            taken = plans(tab, runs)
    dropped, reopened = (statistics.median(each) for each in zip(*opened, strict=True))
    rate, longest = (statistics.median(each) for each in zip(*frames, strict=True))
    return [
        f"| dropped, {objects:,} objects | {dropped:.2f} s |",
        f"| reopened | {reopened:.2f} s |",
        f"| frames while brushing | {rate:.0f} /s, at most {longest:.0f} ms between two |",
        f"| first plan of about {CLOUD} objects, first press | {taken[0]:.1f} s |",
        f"| the same, warm | {statistics.median(taken[1:]):.1f} s |",
    ]


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--objects", type=int, default=24_000)
    parser.add_argument("--runs", type=int, default=3)
    given = parser.parse_args()
    print("| what | median |\n|---|---|")
    for row in measured(given.objects, given.runs):
        print(row)


if __name__ == "__main__":
    main()
