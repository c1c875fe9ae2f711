"""The first screen of a report tells the story of a mission: a sentence, the globe, the lanes."""

from __future__ import annotations

import base64
import os
import re
import unicodedata
from pathlib import Path
from typing import Any

import browser
import pytest
from pdf_text import pdf_text
from serve_tab import click, in_report, served
from six_kinds import KINDS, SEED

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.ui.report import write_report
from adr_opt.ui.report.facts import facts
from adr_opt.ui.report.sections import story

SIZES = ((1400, 900), (390, 844))
"""Of a laptop and of a phone [px]."""


def kinds(quick: str) -> list[Any]:
    """All kinds of missions, of which one is tried each time."""
    return [pytest.param(kind, marks=[] if kind == quick else pytest.mark.slow) for kind in KINDS]


def flown(kind: str) -> tuple[Instance, Plan]:
    """A mission of a kind, with a quick plan."""
    family, sizes = KINDS[kind]
    instance = adr_opt.generate(family, SEED, **sizes)
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    return instance, plan


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("kind", kinds("nominal"))
def test_the_story_is_on_the_first_screen(tmp_path: Path, kind: str, size: tuple[int, int]) -> None:
    """Sentence, globe and the lane of the first chaser can be seen without scrolling."""
    width, height = size
    write_report(*flown(kind), tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile", width=width, height=height) as tab:
        tab.open(tmp_path / "mission.html")
        tab.wait_for("document.documentElement?.dataset.complete")
        ends = tab.evaluate(
            "['.story', '#orbits', '#lanes .ytick'].map((part) =>"
            " document.querySelector(part).getBoundingClientRect().bottom)"
        )
        assert max(ends) <= height, ends
        assert tab.evaluate("document.documentElement.scrollWidth") == width


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
@pytest.mark.parametrize("kind", kinds("nominal"))
def test_the_story_is_on_the_first_screen_of_the_live_page(tmp_path: Path, kind: str) -> None:
    """Beside the editor, too, or below the tabs, with leg and time in one bar and all lanes."""
    pytest.importorskip("uvicorn")
    instance, plan = flown(kind)
    instance.save(tmp_path / "my.json")
    plan.save(tmp_path / "plan.json")
    with served(tmp_path, "my.json", "plan.json") as said:
        for width, height in (*SIZES, (1280, 900)):
            folder = tmp_path / f"profile-{width}"
            with browser.Browser(folder, width=width, height=height) as tab:
                tab.go(said["url"])
                tab.wait_for("document.documentElement?.dataset.reported")
                if width < 600:
                    click(tab, "to-report")
                in_report(tab, "innerWidth > 300 && document.documentElement?.dataset.complete")
                above = tab.evaluate("document.querySelector('iframe').getBoundingClientRect().top")
                ends = in_report(
                    tab,
                    "['.story', '.timebar #leg', '#orbits', '#lanes'].map((part) =>"
                    " document.querySelector(part).getBoundingClientRect().bottom)",
                )
                assert above + max(ends) <= height, (width, ends)
                assert in_report(tab, "document.documentElement.scrollWidth === innerWidth")


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
def test_charts_fit_on_paper(tmp_path: Path) -> None:
    """Printed, no chart is wider than a sheet, and all days and all legs stay in view."""
    widths = (
        "[...document.querySelectorAll('.chart .main-svg')]"
        ".map((drawing) => drawing.getBoundingClientRect().width)"
    )
    write_report(*flown("one chaser"), tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile", width=1400, height=900) as tab:
        tab.open(tmp_path / "mission.html")
        tab.wait_for("document.documentElement?.dataset.complete")
        days = tab.evaluate("document.getElementById('budget').layout.xaxis.range")
        wide = max(tab.evaluate(widths))
        tab.evaluate("window.dispatchEvent(new Event('beforeprint'))")
        tab.wait_for(f"Math.max(...{widths}) < 700")
        assert tab.evaluate("document.getElementById('budget').layout.xaxis.range") == days
        tab.call("Emulation.setEmulatedMedia", media="print")
        cut = "[...document.querySelectorAll('.scroll')].filter((one) =>"
        assert tab.evaluate(f"{cut} one.scrollHeight > one.clientHeight + 1).length") == 0
        legs = tab.evaluate(
            "[...document.querySelectorAll('.legs tr[data-leg]')].filter((row) =>"
            " row.getBoundingClientRect().height > 5).length"
        )
        assert legs == tab.evaluate("document.getElementById('leg').options.length") - 1 > 1
        tab.call("Emulation.setEmulatedMedia", media="")
        tab.evaluate("window.dispatchEvent(new Event('afterprint'))")
        tab.wait_for(f"Math.max(...{widths}) === {wide}")


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
def test_every_day_and_leg_is_printed(tmp_path: Path) -> None:
    """The text of the PDF has all days of the charts and, row by row, the cells of all legs."""
    instance, plan = flown("nominal")
    write_report(instance, plan, tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile", width=1400, height=900) as tab:
        tab.open(tmp_path / "mission.html")
        tab.wait_for("document.documentElement?.dataset.complete")
        rows = tab.evaluate(
            "[...document.querySelectorAll('.legs tr[data-leg]')].map((row) =>"
            " [...row.cells].slice(1).map((cell) => cell.textContent).join(''))"
        )
        text = pdf_text(base64.b64decode(tab.call("Page.printToPDF")["data"]))
    days = "".join(str(day) for day in range(round(instance.mission.duration_s / DAY_S) + 1))
    assert text.count(days) >= 3  # lanes, ΔV left, altitude
    assert len(rows) == len(plan.legs) > 10
    for row in rows:
        assert "".join(unicodedata.normalize("NFKC", row).split()) in text


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.parametrize("kind", kinds("campaign"))
def test_two_pages_are_printed_where_they_are_asked_for(tmp_path: Path, kind: str) -> None:
    """One sheet has the story with the globe, the other the legs; printed otherwise it has all."""

    def sheets() -> int:
        pdf = base64.b64decode(tab.call("Page.printToPDF", printBackground=True)["data"])
        return len(re.findall(rb"/Type\s*/Page\b", pdf))

    write_report(*flown(kind), tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile", width=1400, height=900) as tab:
        tab.open(tmp_path / "mission.html")
        tab.wait_for("document.documentElement?.dataset.complete")
        tab.evaluate("window.print = () => {}; document.getElementById('brief').click()")
        assert sheets() == 2
        assert sheets() > 3


def test_the_sentence_says_what_the_plan_says() -> None:
    """Visits, days and refuellings are the plan's, and a bound or a proof is told as such."""
    instance, plan = flown("nominal")
    found = facts(instance, plan)
    said = re.sub("<.*?>", "", story(plan, found, None))
    assert said.startswith(f"{plan.objective:.0f} of 50 targets in ")
    assert said.endswith("no bound is known.")
    bounded = plan.replace(upper_bound=plan.objective + 2.0)
    assert f"at most {plan.objective + 2.0:.0f} are possible" in story(
        bounded, facts(instance, bounded), None
    )
    refined = adr_opt.refine(instance, plan, freedom="planned")
    assert "refined" in story(plan, found, refined)


MOST_MS = 16.0
"""Of the main thread for a frame, at sixty frames a second [ms]."""


@pytest.mark.slow
@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
def test_time_is_played_smoothly(tmp_path: Path) -> None:
    """While time is played the main thread has processor time to spare in each frame."""
    write_report(*flown("nominal"), tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile", width=1400, height=900) as tab:
        tab.open(tmp_path / "mission.html")
        tab.wait_for("document.documentElement?.dataset.complete")
        tab.call("Performance.enable", timeDomain="threadTicks")

        def spent() -> float:
            metrics = tab.call("Performance.getMetrics")["metrics"]
            return next(each["value"] for each in metrics if each["name"] == "TaskDuration")

        before = spent()
        frames = tab.evaluate(
            "new Promise((done) => { const began = performance.now(); let frames = 0;"
            " const count = (now) => { frames += 1; if (now - began < 3000)"
            " requestAnimationFrame(count); else done(frames); };"
            " document.getElementById('play').click(); requestAnimationFrame(count); })"
        )
        assert frames > 10
        assert 1e3 * (spent() - before) / frames < MOST_MS
