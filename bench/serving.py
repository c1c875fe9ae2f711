"""Pages: how fast ``serve`` answers and its page draws, with 24,000 objects and while it plans.

python bench/serving.py browser      # needs Chromium and the extra [serve]
python bench/serving.py latency --seconds 12
"""

from __future__ import annotations

import http.client
import itertools
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from statistics import mean, median, quantiles
from typing import Any
from urllib.parse import urlsplit

from fields import ROOT
from tables import experiment, head, row

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


def _opened(folder: Path, profile: Path, catalogue: Path | None) -> float:
    """Time until the objects are drawn, after a drop or after reopening [s]."""
    with served(folder, "--folder", "project") as said, Browser(profile, width=1440) as tab:
        tab.call("Page.addScriptToEvaluateOnNewDocument", source=WATCH)
        tab.go(said["url"])
        began_ms = 0.0
        if catalogue is not None:
            on_page(tab, "stage", "empty")
            began_ms = tab.evaluate("performance.now()")
            drop(tab, catalogue)
        return (tab.wait_for("window.drawn_ms") - began_ms) / 1000.0


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


def browser(objects: int = 24_000, runs: int = 3) -> None:
    """The page in a browser: its start, brushing, planning; medians of the runs.

    *Dropped* is the time from letting a catalogue of drawn element sets go on the page until all
    plots and the list are there, *reopened* that from asking for the address of the project in a
    new process, *frames* how often the page is drawn a second while a rectangle is dragged, with
    the longest time between two frames, and *plan* the time from pressing Plan until the first plan
    is there, for 120 of the objects near one plane; the first press loads what planning needs.
    """
    with tempfile.TemporaryDirectory() as place:
        folder, opened = Path(place), list[tuple[float, float]]()
        catalogue = folder / "drawn.tle"
        catalogue.write_text(catalogue_files.as_tle(catalogue_files.field(objects)))
        for run in range(runs):
            alone = folder / f"run-{run}"
            alone.mkdir()
            profiles = [folder / f"profile-{run}-{turn}" for turn in (0, 1)]
            files = zip(profiles, (catalogue, None), strict=True)
            opened.append(tuple(_opened(alone, *each) for each in files))
        with (
            served(alone, "--folder", "project") as said,
            Browser(folder / "profile", width=1440) as tab,
        ):
            tab.go(said["url"])
            on_page(tab, "objects", objects)
            frames = [brushing(tab) for _ in range(runs)]
            chosen(tab)
            taken = plans(tab, runs)
    dropped, reopened = (median(each) for each in zip(*opened, strict=True))
    rate, longest = (median(each) for each in zip(*frames, strict=True))
    head("what", "median")
    row(f"dropped, {objects:,} objects", f"{dropped:.2f} s")
    row("reopened", f"{reopened:.2f} s")
    row("frames while brushing", f"{rate:.0f} /s, at most {longest:.0f} ms between two")
    row(f"first plan of about {CLOUD} objects, first press", f"{taken[0]:.1f} s")
    row("the same, warm", f"{median(taken[1:]):.1f} s")


class Asked:
    """A server, asked on one connection after the other."""

    def __init__(self, folder: Path) -> None:
        command = [sys.executable, "-m", "adr_opt", "serve", "--folder", str(folder)]
        self.process = subprocess.Popen(
            [*command, "--no-open", "--json"],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        assert self.process.stdout is not None
        lines = [*itertools.takewhile(lambda line: line != "}\n", self.process.stdout), "}"]
        said = json.loads("".join(lines))
        self.port = said["port"]
        token = urlsplit(said["url"]).query.partition("=")[2]
        self.headers = {"Cookie": f"adr-opt-{self.port}={token}"}

    def answer(self, path: str, body: bytes | None, kind: str) -> http.client.HTTPResponse:
        """The beginning of an answer."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=300.0)
        connection.request(
            "GET" if body is None else "POST", path, body, {**self.headers, "Content-Type": kind}
        )
        return connection.getresponse()

    def ask(self, path: str, body: Any = None, kind: str = "application/json") -> tuple[float, Any]:
        """Time until the whole answer is there [s], and the answer."""
        content = body if body is None or isinstance(body, bytes) else json.dumps(body).encode()
        began = time.perf_counter()
        answer = self.answer(path, content, kind)
        said = answer.read()
        elapsed_s = time.perf_counter() - began
        if answer.status != 200:
            raise SystemExit(f"{path}: {answer.status} {said.decode()}")
        return elapsed_s, json.loads(said)

    def looks(self) -> Iterator[Any]:
        """Looks at the run, as the page hears of them."""
        event = ""
        for line in iter(self.answer("/events", None, "").readline, b""):
            said = line.decode().strip()
            if said.startswith("event: "):
                event = said.removeprefix("event: ")
            elif said.startswith("data: ") and event == "work":
                yield json.loads(said.removeprefix("data: "))


def latency(objects: int = 24_000, targets: int = 120, seconds: float = 20.0) -> None:
    """How fast ``serve`` answers: a large catalogue, the first plan of a cloud, under full load.

    One server, as the command line starts it. A drawn catalogue is dropped and listed; objects of
    like planes become targets; the planner has had the time to load its kernels; then Plan is
    pressed. While it plans, with a bound beside the planner, states are asked for and prizes edited
    one after the other.
    """
    with tempfile.TemporaryDirectory() as place:
        server = Asked(Path(place) / "project")
        try:
            _answers(server, objects, targets, seconds)
        finally:
            server.process.terminate()
            server.process.wait(120.0)


def _answers(server: Asked, objects: int, targets: int, seconds: float) -> None:
    """Print all times of a server."""
    drawn = catalogue_files.as_tle(catalogue_files.field(objects)).encode()
    said, _ = server.ask("/upload?name=all.tle", drawn, "application/octet-stream")
    listed, columns = server.ask("/objects")
    again, _ = server.ask("/objects")
    print(f"{objects} objects: dropped {said:.2f} s, listed {listed:.2f} s, again {again:.2f} s")
    names = [name for _, name in sorted(zip(columns["raan_deg"], columns["names"], strict=True))]
    choosing, _ = server.ask("/choose", {"names": names[:targets]})
    print(f"{targets} targets: chosen {choosing:.2f} s")
    # The first run is short: it waits for the kernels, and the page may have been open for long.
    server.ask("/plan", {"method": "greedy", "time_limit_s": 1.0})
    looks, end = server.looks(), time.perf_counter() + 60.0
    for look in looks:
        if (look["number"] == 1 and not look["runs"]) or time.perf_counter() > end:
            break
    server.ask("/edit", {"duration_s": 8 * 86400.0})  # so that nothing of that run is of use
    began = time.perf_counter()
    order = {"method": "auto", "time_limit_s": seconds, "bound": "exact", "goes_on": False}
    server.ask("/plan", order)
    next(look for look in looks if look["number"] == 2 and look["incumbent"] is not None)
    print(f"first plan {time.perf_counter() - began:.2f} s after Plan was pressed, warm")
    taken = defaultdict[str, list[float]](list)
    for at in itertools.count():
        if time.perf_counter() > began + seconds:
            break
        edit = {"targets": {"names": names[:1], "prize": 1.0 + at % 50}}
        for path in ("/state", "/jobs", "/results", "/choices", "/edit"):
            once, _ = server.ask(path, edit if path == "/edit" else None)
            taken[path].append(once)
            taken["all"].append(once)
        time.sleep(0.05)
    head("while planning", "answers", "median", "95 %", "most", "within 0.1 s")
    for path, times in taken.items():
        figures = median(times), quantiles(times, n=20)[-1], max(times)
        within = f"{mean(each <= 0.1 for each in times):.1%}"
        row(path, len(times), *(f"{1e3 * each:.1f} ms" for each in figures), within)


if __name__ == "__main__":
    sys.exit(experiment(__doc__, browser, latency))
