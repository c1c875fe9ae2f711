"""The first screen of a report tells the story of a mission: a sentence, the globe, the lanes."""

from __future__ import annotations

import base64
import re
from pathlib import Path

import browser
import pytest
from six_kinds import KINDS, SEED

import adr_opt
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.ui.report import write_report
from adr_opt.ui.report.facts import facts
from adr_opt.ui.report.sections import story

SIZES = ((1400, 900), (390, 844))
"""Of a laptop and of a phone [px]."""


def flown(kind: str) -> tuple[Instance, Plan]:
    """A mission of a kind, with a quick plan."""
    family, sizes = KINDS[kind]
    instance = adr_opt.generate(family, SEED, **sizes)
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    return instance, plan


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    "kind",
    [pytest.param(kind, marks=[] if kind == "nominal" else pytest.mark.slow) for kind in KINDS],
)
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


BESIDE_THE_EDITOR = ((940, 832), (390, 792))
"""Of the report on the live page: beside its editor on a laptop, below its tabs on a phone [px]."""


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.parametrize("size", BESIDE_THE_EDITOR)
def test_the_story_is_on_the_first_screen_of_the_live_page(
    tmp_path: Path, size: tuple[int, int]
) -> None:
    """Beside the editor, too, with the ΔV left, and with leg and time in one bar."""
    width, height = size
    write_report(*flown("nominal"), tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile", width=width, height=height) as tab:
        tab.open(tmp_path / "mission.html")
        tab.wait_for("document.documentElement?.dataset.complete")
        ends = tab.evaluate(
            "['.story', '.timebar #leg', '#orbits', '#lanes', '#budget'].map((part) =>"
            " document.querySelector(part).getBoundingClientRect().bottom)"
        )
        assert max(ends) <= height, ends
        assert tab.evaluate("document.documentElement.scrollWidth") == width


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
@pytest.mark.parametrize(
    "kind",
    [pytest.param(kind, marks=[] if kind == "campaign" else pytest.mark.slow) for kind in KINDS],
)
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
