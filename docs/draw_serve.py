"""Take the pictures of pages: ``serve`` with objects and with a report, and six reports.

    python docs/draw_serve.py              # into docs/pictures
    python docs/draw_serve.py --out DIR
    python docs/draw_serve.py --checkout DIR --out DIR   # first screens of another version alone
    python docs/draw_serve.py --frames     # time of scripts a frame while the globe turns, alone

Drops a drawn catalogue and chooses ranges of it; plans a generated field, changes what is wanted of
it, and plans again; and opens the reports of six kinds of missions. Needs
Chromium and the extra ``[serve]``; the browser is driven as the tests do it.
"""

from __future__ import annotations

import argparse
import dataclasses
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

import adr_opt
from adr_opt.sources.catalogue import ElementSet

ROOT = Path(__file__).parents[1]
WIDTH, HEIGHT = 1280, 900
LIMIT_S = 30
OBJECTS = 24_000
SHELLS = (
    (0.30, 98.4, 0.9, 14.30, 0.35),
    (0.20, 82.6, 0.4, 13.90, 0.40),
    (0.15, 53.0, 0.3, 15.05, 0.05),
    (0.10, 74.0, 0.3, 14.20, 0.30),
    (0.10, 65.5, 1.5, 14.00, 0.50),
    (0.15, 71.0, 22.0, 13.80, 0.80),
)
"""Share of the objects, inclination [deg] and mean motion [rev/day] with their spreads."""

SCREEN = 1400, 900
SMALLER, GAP = 3, 8

sys.path[:0] = [str(ROOT / "tests/oracles"), str(ROOT / "tests/fields")]

import catalogue_files  # noqa: E402
from browser import Browser  # noqa: E402
from serve_tab import click, drag, drop, on_page, put, served  # noqa: E402
from six_kinds import KINDS, SEED  # noqa: E402


def sky(seed: int = 1) -> list[ElementSet]:
    """Drawn objects in shells and clouds, with names as catalogues have them."""
    random = np.random.default_rng(seed)
    shell = random.choice(len(SHELLS), size=OBJECTS, p=[share for share, *_ in SHELLS])
    made = []
    for number, (record, at) in enumerate(zip(catalogue_files.field(OBJECTS), shell, strict=True)):
        _, tilt, tilts, motion, motions = SHELLS[at]
        kind = ("DEB", "DEB", "R/B", "")[int(random.integers(0, 4))]
        made.append(
            dataclasses.replace(
                record,
                name=f"DRAWN {number % 97} {kind}".strip(),
                inclination_deg=round(abs(random.normal(tilt, tilts)) % 140.0, 4),
                mean_motion_rev_day=round(min(random.normal(motion, motions), 15.6), 8),
            )
        )
    return made


def brushed(tab: Browser, url: str, catalogue: Path) -> None:
    """A catalogue with a rectangle in two of its plots."""
    tab.go(url)
    on_page(tab, "stage", "empty")
    drop(tab, catalogue)
    on_page(tab, "objects", OBJECTS)
    drag(tab, ".brushed", (0.64, 0.8), (0.78, 0.45))
    drag(tab, ".plot:nth-child(2) .brushed", (0.45, 0.85), (0.62, 0.05))
    time.sleep(2.0)


def planned(tab: Browser, url: str) -> None:
    """A field planned, with a target that is worth more, and one that is excluded."""
    tab.go(url)
    on_page(tab, "reported", 0)
    put(tab, "Prize of debris-003", 3)
    on_page(tab, "revision", 1)
    tab.evaluate("document.querySelector('[aria-label=\"Exclude debris-009\"]').click()")
    on_page(tab, "revision", 2)
    put(tab, "#limit", LIMIT_S)
    click(tab, "plan")
    tab.wait_for("document.documentElement.dataset.phase === 'done'", 300.0)
    on_page(tab, "reported", 1)
    tab.evaluate("document.getElementById('said').textContent = ''")
    time.sleep(15.0)  # the report is a page of its own, and draws in its own time


def report_of(folder: Path, checkout: Path, family: str, sizes: dict[str, int]) -> Path:
    """The report of a generated mission, by the command line of a checkout."""
    mission, plan, report = (folder / f"{family}.{end}" for end in ("json", "plan.json", "html"))
    given = [f"--{name}={value}" for name, value in sizes.items()]
    for words in (
        ["generate", family, f"--seed={SEED}", *given, f"--out={mission}"],
        ["solve", mission, "--method=greedy", f"--out={plan}", "--quiet"],
        ["report", mission, plan, f"--out={report}", "--quiet"],
    ):
        command = [sys.executable, "-m", "adr_opt", *map(str, words)]
        subprocess.run(command, cwd=checkout, check=True, capture_output=True)
    return report


def first_screens(folder: Path, checkout: Path) -> Image.Image:
    """The first screens of six kinds of missions, side by side."""
    width, height = SCREEN
    small = width // SMALLER, height // SMALLER
    sheet = Image.new("RGB", (3 * small[0] + 2 * GAP, 2 * small[1] + GAP), "white")
    with Browser(folder / "reports", width=width, height=height) as tab:
        for at, (family, sizes) in enumerate(KINDS.values()):
            tab.open(report_of(folder, checkout, family, sizes))
            tab.wait_for("document.documentElement?.dataset.ready", 300.0)
            time.sleep(15.0)  # charts draw in their own time
            tab.picture(folder / "taken.png", whole=False)
            with Image.open(folder / "taken.png") as picture:
                place = (at % 3 * (small[0] + GAP), at // 3 * (small[1] + GAP))
                sheet.paste(picture.convert("RGB").resize(small, Image.Resampling.LANCZOS), place)
    return sheet


PLAYED = """new Promise((done) => {
  const [button, began] = [document.getElementById("play"), performance.now()];
  let frames = 0;
  const count = (now) => {
    frames += 1;
    if (now - began < 5000) requestAnimationFrame(count);
    else { button.click(); done(frames); }
  };
  button.click();
  requestAnimationFrame(count);
})"""
"""Plays five seconds; number of frames."""


def frames(folder: Path) -> None:
    """Print what the main thread takes a frame while time is played, by Chromium's own counters."""
    with Browser(folder / "frames", width=SCREEN[0], height=SCREEN[1]) as tab:
        for kind, (family, sizes) in KINDS.items():
            tab.open(report_of(folder, ROOT, family, sizes))
            tab.wait_for("document.documentElement?.dataset.complete", 300.0)
            tab.call("Performance.enable", timeDomain="threadTicks")
            before = tab.call("Performance.getMetrics")["metrics"]
            count = tab.evaluate(PLAYED)
            after = {
                each["name"]: each["value"]
                for each in tab.call("Performance.getMetrics")["metrics"]
            }
            taken = {each["name"]: after[each["name"]] - each["value"] for each in before}
            script, task = (
                1e3 * taken[name] / count for name in ("ScriptDuration", "TaskDuration")
            )
            print(f"{kind:12} {count:4} frames, scripts {script:5.1f} ms, all tasks {task:5.1f} ms")


def few_colours(picture: Image.Image) -> Image.Image:
    """A picture in 256 colours, of which those of small marks count as much as those of faces."""
    return picture.convert("RGB").quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=3)


def take(tab: Browser, name: str, out: Path) -> None:
    """Write a picture, with a path in it that is nobody's."""
    tab.evaluate("document.getElementById('folder').textContent = 'Kept in my-served'")
    with tempfile.TemporaryDirectory() as folder:
        tab.picture(Path(folder) / "taken.png", whole=False)
        with Image.open(Path(folder) / "taken.png") as picture:
            few = few_colours(picture)
    few.save(out / name, optimize=True)


def main() -> None:
    """Take them."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "docs/pictures")
    parser.add_argument("--checkout", type=Path)
    parser.add_argument("--frames", action="store_true")
    given = parser.parse_args()
    out = given.out
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        if given.frames:
            frames(folder)
            return
        few = few_colours(first_screens(folder, given.checkout or ROOT))
        few.save(out / "reports.png", optimize=True)
        if given.checkout is not None:
            return
        catalogue, instance = folder / "drawn.tle", folder / "my.json"
        catalogue.write_text(catalogue_files.as_tle(sky()))
        adr_opt.generate("reduced-time", 7).save(instance)
        with Browser(folder / "profile", width=WIDTH, height=HEIGHT) as tab:
            with served(folder, "--folder", "objects") as said:
                brushed(tab, said["url"], catalogue)
                take(tab, "serve-objects.png", out)
            with served(folder, "my.json", "--folder", "mission") as said:
                planned(tab, said["url"])
                take(tab, "serve.png", out)


if __name__ == "__main__":
    main()
