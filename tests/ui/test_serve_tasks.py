"""What a newcomer does on the page of ``serve``, task by task, with the clicks that it takes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import browser
import pytest
from serve_tab import drag, in_report, on_page, put, served, text

import adr_opt
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import KeepOutZone
from adr_opt.ui.serve.drafts import Draft, TargetsEdit
from adr_opt.ui.serve.drafts import Edit as DraftEdit
from adr_opt.ui.serve.variants import differences

for package in ("plotly", "starlette", "uvicorn"):
    pytest.importorskip(package)

MOST_CLICKS = 5

CLICKED = """(() => {
  if (!document.documentElement?.dataset.complete) return null;
  const chart = document.getElementById("orbits");
  const targets = chart?.marks?.filter(({ name }) => name.startsWith("debris"));
  if (!targets?.length) return null;
  const { left, top } = chart.getBoundingClientRect();
  const { x, y } = targets[0];
  const place = { clientX: left + x, clientY: top + y, bubbles: true, pointerId: 1 };
  chart.dispatchEvent(new PointerEvent("pointerdown", place));
  chart.dispatchEvent(new PointerEvent("pointerup", place));
  chart.dispatchEvent(new MouseEvent("click", place));
  return targets[0].name;
})()"""
"""Clicks on the first target that is seen on the globe; its name."""


def drawn() -> Instance:
    """A small mission whose first target cannot be had: its window closes at once."""
    instance = adr_opt.generate("tiny", seed=3)
    first, *others = instance.targets
    return instance.replace(targets=(first.replace(window_s=(0.0, 6000.0)), *others))


def test_variants_are_named_by_what_differs() -> None:
    """By names of targets where they are few, by numbers otherwise, and by limits; in one line."""
    instance = drawn()
    names = [target.name for target in instance.targets]
    draft = Draft(instance)
    assert differences(instance, draft.instance) == ""

    def edited(**changes: object) -> Instance:
        return draft.edited(DraftEdit.model_validate(changes)).instance

    assert differences(instance, edited(duration_s=86400.0)) == "1 d"
    without = edited(targets=TargetsEdit(names=(names[1],), excluded=True))
    assert differences(instance, without) == f"without {names[1]}"
    fewer = edited(targets=TargetsEdit(names=tuple(names[:3]), excluded=True))
    assert differences(instance, fewer) == "without 3 targets"
    assert differences(instance, edited(targets=TargetsEdit(names=(names[2],), prize=3.0))) == (
        f"prizes of {names[2]}"
    )
    longer = edited(targets=TargetsEdit(names=(names[0],), required=True)).with_limits(
        duration_s=2.0 * 86400.0
    )
    assert differences(instance, longer) == f"required: {names[0]}, 2 d"


class Newcomer:
    """Counts the clicks of somebody, who sees no digest in any sentence."""

    def __init__(self, tab: browser.Browser) -> None:
        self.tab, self.clicks = tab, 0

    def click(self, selector: str) -> None:
        """Press what is there, once it can be pressed."""
        self.tab.wait_for(
            f"(() => {{ const one = document.querySelector('{selector}');"
            " return one !== null && !one.disabled; })()"
        )
        self.tab.evaluate(f"document.querySelector('{selector}').click()")
        self.clicks += 1

    @contextmanager
    def task(self, name: str) -> Iterator[None]:
        """A task, which takes few clicks."""
        self.clicks = 0
        yield
        assert self.clicks <= MOST_CLICKS, name
        assert "sha256" not in self.tab.evaluate("document.body.innerText").lower()

    def verb(self, name: str) -> str:
        """Open a verb and begin it; gives what its button says that it acts on."""
        self.click(f"[aria-controls=verb-{name}]")
        said: str = self.tab.evaluate(f"document.querySelector('#verb-{name} .first').textContent")
        self.click(f"#verb-{name} .first")
        return said


@contextmanager
def shown(instance: Instance, folder: Path) -> Iterator[browser.Browser]:
    """A page on which a mission is shown, and not planned yet."""
    instance.save(folder / "my.json")
    with served(folder, "my.json") as said, browser.Browser(folder / "profile") as tab:
        tab.go(said["url"])
        on_page(tab, "reported", 0)
        yield tab


SLOW_EDITS = """(() => {
  const { fetch } = window;
  const late = () => new Promise((done) => setTimeout(done, 400));
  window.fetch = async (path, options) => {
    if (path === "/edit") await late();
    return fetch(path, options);
  };
})()"""
"""What takes edits longer than anything else that is clicked."""


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
def test_what_follows_an_edit_is_asked_after_it(tmp_path: Path) -> None:
    """Edits and Plan, clicked in one go, come in their order, and of two edits none is undone."""
    names = [target.name for target in drawn().targets]
    with shown(drawn(), tmp_path) as tab:
        tab.evaluate(SLOW_EDITS)
        put(tab, "#limit", "20")
        excluded = [f'[aria-label="Exclude {name}"]' for name in names[1:]]
        clicked = [*excluded, "#add-chasers", "#add-chasers", "#plan"]
        tab.evaluate(
            "[" + ", ".join(f"document.querySelector({one!r})" for one in clicked) + "]"
            ".forEach((one) => one.click())"
        )
        on_page(tab, "reported", 1)
        state = tab.evaluate("fetch('/state').then((answer) => answer.json())")
        assert {name for name, *_, out, _, _, _, _ in state["targets"] if out} == set(names[1:])
        assert len(state["chasers"]) == 3
        assert (state["plan"]["fits"], state["plan"]["targets"]) == (True, 1)


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
@pytest.mark.slow
def test_a_newcomer_finds_the_way(tmp_path: Path) -> None:
    """Six tasks, each in five clicks: plan, require, compare, refine, trade off and export."""
    names = [target.name for target in drawn().targets]
    with shown(drawn(), tmp_path) as tab:
        put(tab, "#limit", "20")
        somebody = Newcomer(tab)
        with somebody.task("plan"):
            somebody.click("#plan")
            on_page(tab, "reported", 1)
        visited = tab.evaluate(
            "[...document.querySelectorAll('tr.visited td')].map((one) =>"
            " one.title).filter(Boolean)"
        )
        with somebody.task("require what cannot be had, and see why"):
            somebody.click(f'[aria-label="Require {names[0]}"]')
            somebody.click("#plan")
            tab.wait_for("!document.getElementById('failed').hidden")
            assert text(tab, "failed").lower().startswith("no plan")
            somebody.click("#undo")
        with somebody.task("compare without one object"):
            somebody.click(f'[aria-label="Exclude {visited[0]}"]')
            somebody.click("#plan")
            on_page(tab, "results", 2)
            somebody.click("#to-results")
            somebody.click('[data-id="1"] input')
            somebody.click('[data-id="2"] input')
            assert f"without {visited[0]}" in text(tab, "results")
            assert f"loses {visited[0]}" in text(tab, "overlay")
            assert "ΔV" in text(tab, "overlay")
            assert "different missions" in text(tab, "compare-why")
        with somebody.task("refine, and see the saving"):
            somebody.click('[data-id="1"] input')
            assert somebody.verb("refine").endswith(f"without {visited[0]} (2)")
            on_page(tab, "results", 3)
            assert " of auto" in tab.evaluate(
                "document.querySelector('[data-id=\"3\"]').textContent"
            )
        with somebody.task("export"):
            somebody.verb("export")
            on_page(tab, "results", 4)
            link = "document.querySelector('[data-id=\"4\"] a')"
            assert tab.evaluate(f"{link}.textContent") == "flight.oem"
            content = tab.evaluate(f"fetch({link}.href).then((answer) => answer.text())")
            assert content.startswith("CCSDS_OEM_VERS")
        with somebody.task("trade off"):
            somebody.click("[aria-controls=verb-tradeoff]")
            put(tab, "#tradeoff-vary", "duration")
            values = "[...document.querySelectorAll('.vary input')].map(({ value }) => value)"
            assert tab.evaluate(values)[:3] == ["0.75", "2.25", "0.375"]
            put(tab, "Vary, step", 0.75)
            somebody.click("#verb-tradeoff .first")
            on_page(tab, "results", 5)
        with somebody.task("drag the duration, and see the frontier"):
            somebody.click("#to-mission")
            tab.evaluate("document.querySelector('.limit').scrollIntoView()")
            drag(tab, ".limit input[type=range]", (0.5, 0.5), (0.9, 0.5))
            tab.wait_for("document.querySelectorAll('#frontier .dot').length === 3")
            assert "the best plan known collects" in text(tab, "frontier")
            tab.wait_for("document.getElementById('undo').title.startsWith('Undo: duration')")
            somebody.click("#undo")
        assert [said for level, said in tab.complaints if level == "error"] == []


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
@pytest.mark.slow
def test_a_sample_is_a_click_away(tmp_path: Path) -> None:
    """Somebody without any file opens the sample, and has a mission to plan."""
    with served(tmp_path, "--folder", "new") as said, browser.Browser(tmp_path / "profile") as tab:
        tab.go(said["url"])
        on_page(tab, "stage", "empty")
        Newcomer(tab).click("#sample")
        on_page(tab, "stage", "mission")
        assert text(tab, "counts").startswith("50 in all")


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
@pytest.mark.slow
def test_an_object_is_clicked_in_the_report(tmp_path: Path) -> None:
    """A click on the globe names an object, which is required, excluded or given a deadline."""
    with shown(drawn(), tmp_path) as tab:
        put(tab, "#limit", "5")
        tab.evaluate("document.getElementById('plan').click()")
        on_page(tab, "reported", 1)
        name = in_report(tab, CLICKED)
        tab.wait_for("document.getElementById('object').open")
        assert text(tab, "object-name") == name
        put(tab, "#object-deadline", 1.25)
        on_page(tab, "revision", 2)
        tab.evaluate("document.getElementById('object-excluded').click()")
        tab.wait_for(f"document.querySelector('[aria-label=\"Exclude {name}\"]').checked")
        draft = adr_opt.load(tmp_path / "my-served" / "draft.json")
        assert name not in {target.name for target in draft.targets}
        tab.evaluate("document.getElementById('undo').click()")
        tab.wait_for(f"!document.querySelector('[aria-label=\"Exclude {name}\"]').checked")
        draft = adr_opt.load(tmp_path / "my-served" / "draft.json")
        (target,) = (each for each in draft.targets if each.name == name)
        assert target.window_s == (0.0, 108000.0)


ZONE = KeepOutZone(min_altitude_m=790e3, max_altitude_m=800e3, start_s=40000.0, end_s=70000.0)


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
@pytest.mark.slow
def test_a_zone_is_dragged_and_taken_back(tmp_path: Path) -> None:
    """What is dragged on the altitude chart is where it was left, and back again after undo."""
    shape = "document.querySelector('#altitude .shapelayer path')"
    with shown(drawn().replace(keep_out_zones=(ZONE,)), tmp_path) as tab:
        put(tab, "#limit", "5")
        tab.evaluate("document.getElementById('plan').click()")
        on_page(tab, "reported", 1)
        there = f"document.documentElement?.dataset.complete && {shape} !== null"
        in_report(tab, f"{there} && ({shape}.closest('section').scrollIntoView(), true)")
        place = (
            f"(() => {{ const {{ x, y, width, height }} = {shape}.getBoundingClientRect();"
            " return [x + width / 2, y + height / 2]; })()"
        )
        x, y = in_report(tab, place)
        left, top = tab.evaluate(
            "(() => { const { x, y } = document.querySelector('iframe').getBoundingClientRect();"
            " return [x, y]; })()"
        )
        for kind, by in (("mousePressed", 0), ("mouseMoved", 20), ("mouseReleased", 20)):
            tab.call(
                "Input.dispatchMouseEvent",
                type=kind,
                button="left",
                buttons=1,
                clickCount=1,
                x=left + x + by,
                y=top + y,
            )
        tab.wait_for("document.getElementById('undo').title === 'Undo: keep-out zones changed'")
        (moved,) = tab.evaluate(ZONES)
        assert moved["start_s"] > ZONE.start_s + 1000.0
        assert moved["end_s"] - moved["start_s"] == pytest.approx(30000.0, abs=2.0)
        assert moved["max_altitude_m"] - moved["min_altitude_m"] == pytest.approx(10e3, abs=100.0)
        tab.evaluate("document.getElementById('undo').click()")
        on_page(tab, "reported", 2)
        in_report(tab, f"{there} && Math.abs({place}[0] - {x}) < 1")
        assert tab.evaluate(ZONES)[0]["start_s"] == ZONE.start_s
        assert [said for level, said in tab.complaints if level == "error"] == []


ZONES = "fetch('/state').then((one) => one.json()).then((one) => one.instance.keep_out_zones)"
