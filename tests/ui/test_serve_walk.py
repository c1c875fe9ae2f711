"""The way from a catalogue to a zip file on the page of ``serve``, in a browser."""

from __future__ import annotations

import base64
import io
import json
import os
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import browser
import page_access
import pytest
from catalogue_files import as_tle, field
from serve_catalogue import catalogue
from serve_tab import PAINTED, click, drag, drop, look, on_page, put, served, text

import adr_opt
from adr_opt.ui.serve.server import LaunchFile

for package in ("plotly", "starlette", "uvicorn", "sgp4"):
    pytest.importorskip(package)

pytestmark = [
    pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium"),
    pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals"),
]

OBJECTS = 24_000
LOOKS = [(1280, False), (1280, True), (390, False), (390, True)]
"""Widths of the window, and whether it is dark."""


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[browser.Browser]:
    """One browser for all tests here, which take it in turn."""
    with browser.Browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


def judged(tab: browser.Browser, looks: Sequence[tuple[int, bool]] = LOOKS) -> None:
    """Nothing keeps anybody from using the page as it stands, however it is looked at."""
    for width, dark in looks:
        scheme = ("dark" if dark else "light",)
        assert page_access.faults(tab, widths=(width,), schemes=scheme) == [], (width, dark)
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
    tab.evaluate(PAINTED)
    first = shown(tab)
    drag(tab, ".plot:nth-child(2) .brushed", (0.3, 0.85), (0.6, 0.05))
    tab.evaluate(PAINTED)
    assert tab.evaluate("document.getElementById('chips').children.length") == 2
    assert 0 < shown(tab) < first < OBJECTS
    for kind in ("keyDown", "keyUp"):
        tab.call("Input.dispatchKeyEvent", type=kind, key="Escape", windowsVirtualKeyCode=27)
    tab.wait_for(every)


def filtered(tab: browser.Browser) -> set[str]:
    """Set ranges; names of the objects within them, of which as many are shown."""
    put(tab, "Inclination [deg], from", 98)
    put(tab, "Node [deg], from", 100)
    put(tab, "Node [deg], to", 100.8)
    tab.evaluate(PAINTED)
    columns = asked(tab, "/objects")
    rows = zip(columns["names"], columns["inclination_deg"], columns["raan_deg"], strict=True)
    wanted = {name for name, tilt, node in rows if tilt >= 98.0 and 100.0 <= node <= 100.8}
    assert 3 < shown(tab) == len(wanted) < 40
    return wanted


def edit(tab: browser.Browser) -> None:
    """Give the chaser another name by its form; a tank that cannot be is refused at its field."""
    tab.wait_for("document.querySelector('#chasers details') !== null")
    tab.evaluate("document.querySelector('#chasers details').open = true")
    tab.wait_for("document.querySelector('#part-chasers-0-name') !== null")
    tank = "document.querySelector('input[id^=part-chasers-0-tank-]')"
    name = tab.evaluate(f"{tank}.id")
    before = tab.evaluate(f"{tank}.value")
    put(tab, f"#{name}", -1)
    tab.wait_for(f"document.getElementById('{name}-why').textContent.includes('= -1')")
    assert f"{name}-why" in tab.evaluate(f"{tank}.getAttribute('aria-describedby')")
    put(tab, f"#{name}", before)
    tab.wait_for(f"!document.getElementById('{name}').hasAttribute('aria-invalid')")
    put(tab, "#part-chasers-0-name", "tug")
    tab.wait_for("document.querySelector('#chasers summary').textContent === 'tug'")


def press(tab: browser.Browser, verb: str) -> None:
    """Open a verb of the menu, and begin."""
    tab.evaluate(f"document.querySelector('[aria-controls=verb-{verb}]').click()")
    tab.wait_for(f"!document.querySelector('#verb-{verb} .first').disabled")
    tab.evaluate(f"document.querySelector('#verb-{verb} .first').click()")


def check_and_compare(tab: browser.Browser) -> None:
    """Check the plan that is shown, and open the comparison of both."""
    press(tab, "check")
    on_page(tab, "results", 3)
    for number in (1, 2):
        tab.evaluate(f"document.querySelector('[data-id=\"{number}\"] input').click()")
    press(tab, "compare")
    on_page(tab, "paged", 4)


def exported(tab: browser.Browser, path: Path) -> None:
    """Unpack the whole project beside a path."""
    text_of = "btoa(String.fromCharCode(...part))"
    packed = tab.evaluate(
        "fetch('/export').then((answer) => answer.arrayBuffer()).then((content) => {"
        " const bytes = new Uint8Array(content); let text = '';"
        " for (let at = 0; at < bytes.length; at += 6000) {"
        f"  const part = bytes.subarray(at, at + 6000); text += {text_of}; }}"
        " return text; })"
    )
    with zipfile.ZipFile(io.BytesIO(base64.b64decode(packed))) as archive:
        archive.extractall(path.parent)
    (path.parent / "project").rename(path.parent / "exported")


@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_from_a_catalogue_to_an_export(tab: browser.Browser, tmp_path: Path, whole: bool) -> None:
    """Somebody drops 24,000 objects, brushes, chooses, edits, plans and exports.

    On the whole way two plans are made, one is checked, and both are compared. Nothing is on the
    console, no request leaves the machine, and what is exported are files of the command line.
    """
    catalogue = tmp_path / "drawn.tle"
    catalogue.write_text(as_tle(field(OBJECTS)))
    with served(tmp_path, "--folder", "project") as said:
        tab.go(said["url"])
        on_page(tab, "stage", "empty")
        drop(tab, catalogue)
        on_page(tab, "objects", OBJECTS)
        brush(tab)
        wanted = filtered(tab)
        judged(tab)
        click(tab, "choose")
        on_page(tab, "stage", "mission")
        assert {target[0] for target in asked(tab, "/state")["targets"]} == wanted
        edit(tab)
        for number, method in enumerate(("greedy", "beam")[: 1 + whole], 1):
            put(tab, "#method", method)
            put(tab, "#limit", 1)
            click(tab, "plan")
            on_page(tab, "results", number)
            on_page(tab, "reported", number)
        judged(tab, LOOKS if whole else LOOKS[-1:])
        click(tab, "to-results")
        if whole:
            check_and_compare(tab)
            judged(tab)
        exported(tab, tmp_path / "project.zip")
        # A tank that is refused is a status that the browser notes.
        assert [said for _, said in tab.complaints if "status of 422" not in said] == []
        asked_for = {urlsplit(each).netloc for each in tab.requests if each.startswith("http")}
        assert asked_for == {f"127.0.0.1:{said['port']}"}
    instance, plan = (tmp_path / "exported" / name for name in ("instance.json", "plan.json"))
    assert adr_opt.load(instance).chasers[0].name == "tug"
    assert adr_opt.check(adr_opt.load(instance), adr_opt.load_plan(plan)) == ()


UNCERTAINTY = {
    "format": "adr-opt-uncertainty/1",
    "legs": {"delta_v_factor": {"lognormal_sigma": 0.1}},
}

VERBS: dict[str, dict[str, object]] = {
    "bound": {"time_limit_s": 5},
    "verify": {},
    "refine": {},
    "fly": {},
    "screen": {"distance": 1e6},
    "dispose": {"years": 1000},
    "check": {},
    "compare": {},
    "tradeoff": {
        "vary": "delta-v",
        **{"Vary, from": 600, "Vary, to": 3000, "Vary, step": 2400},
        **{"method": "greedy-guarded", "time_limit_s": 2},
    },
    "rehearse": {"samples": 20},
    "report": {},
}
"""Verbs of the menu in an order in which each has what it needs, with options."""

PAGES = {"compare", "dispose", "tradeoff", "rehearse", "report", "screen", "worth"}
"""Verbs whose results open a page."""


def ticked(tab: browser.Browser, *numbers: int) -> None:
    """Select these results alone."""
    tab.evaluate(
        "document.querySelectorAll('#results > li').forEach((row) => {"
        f" const wanted = {json.dumps(list(map(str, numbers)))}.includes(row.dataset.id);"
        " const tick = row.querySelector('input');"
        " if (tick.checked !== wanted) tick.click(); })"
    )


def every_verb(tab: browser.Browser) -> None:
    """Press each verb once; what it makes is listed, and its page opens in the frame."""
    made = 2
    for verb, options in VERBS.items():
        ticked(tab, *((1, 2) if verb == "compare" else ()))
        for name, value in options.items():
            put(tab, name if "," in name else f"#{verb}-{name}", value)
        if verb == "bound":
            tab.evaluate("document.getElementById('bound-certificate').click()")
        press(tab, verb)
        made += 1
        on_page(tab, "results", made)
        row = asked(tab, "/results")[-1]
        assert (row["verb"], row["exit_status"]) == (verb, 0), row
        assert row["has_page"] == (verb in PAGES)
        if verb in PAGES:
            on_page(tab, "paged", made)
            tab.evaluate("document.getElementById('report-again').click()")
            tab.evaluate(f"document.querySelector('[data-id=\"{made}\"] .acts button').click()")
            on_page(tab, "paged", made)
    assert [row["state"] for row in asked(tab, "/jobs")] == ["done"] * len(VERBS)


def points(tab: browser.Browser) -> None:
    """Open the plan of a point by its dot, and of another one by its button and a key."""
    tab.evaluate("document.querySelector('[aria-label^=Points]').click()")
    tab.wait_for("document.querySelectorAll('#points svg a circle').length === 2")
    judged(tab, LOOKS[-1:])
    before = asked(tab, "/state")["result"]
    place = tab.evaluate(
        "(() => { const dot = document.querySelector('#points svg a circle');"
        " dot.scrollIntoView({ block: 'center' });"
        " const { x, y, width, height } = dot.getBoundingClientRect();"
        " return [x + width / 2, y + height / 2]; })()"
    )
    for kind in ("mousePressed", "mouseReleased"):
        tab.call(
            "Input.dispatchMouseEvent",
            type=kind,
            button="left",
            clickCount=1,
            x=place[0],
            y=place[1],
        )
    tab.wait_for(f"document.querySelector('.result.shown')?.dataset.id > {before}")
    state = asked(tab, "/state")
    assert (state["chasers"][0]["amount"], state["plan"]["fits"]) == (600.0, True)
    tab.evaluate("[...document.querySelectorAll('#points button')].at(-1).focus()")
    for kind in ("keyDown", "keyUp"):
        tab.call(
            "Input.dispatchKeyEvent", type=kind, key="Enter", text="\r", windowsVirtualKeyCode=13
        )
    tab.wait_for(
        "document.querySelector('[aria-label^=\"Undo\"]').getAttribute('aria-label')"
        f" !== 'Undo: result {state['result']} shown'"
    )
    assert asked(tab, "/state")["chasers"][0]["amount"] == 3000.0
    click(tab, "undo")
    tab.wait_for("document.getElementById('redo').disabled === false")


def replanned(tab: browser.Browser) -> None:
    """Drag the time over a tenth of the mission, and replan from there."""
    made = len(asked(tab, "/results"))
    tab.evaluate("document.getElementById('replan-at').scrollIntoView({ block: 'center' })")
    drag(tab, "#replan-at", (0.5, 0.5), (0.1, 0.5))
    assert 0 < tab.evaluate("Number(document.getElementById('replan-at').value)") < 200
    assert "UTC" in text(tab, "replan-when")
    click(tab, "replan")
    on_page(tab, "results", made + 1)
    row = asked(tab, "/results")[-1]
    assert (row["verb"], row["has_plan"]) == ("replan", True), row
    tab.evaluate(f"document.querySelector('[data-id=\"{row['id']}\"] .acts button').click()")
    tab.wait_for(f"document.querySelector('.result.shown').dataset.id === '{row['id']}'")


def lit(tab: browser.Browser) -> None:
    """Find windows of light and contact, with which the mission goes on, and lift them."""
    made = len(asked(tab, "/results"))
    click(tab, "to-mission")
    tab.evaluate("document.querySelector('#windows-options').closest('details').open = true")
    judged(tab, LOOKS[-1:])
    put(tab, "#windows-contact", "kiruna, awarua")
    click(tab, "windows")
    on_page(tab, "results", made + 1)
    tab.wait_for("!document.getElementById('lift').disabled")
    assert "bands" in text(tab, "captures")
    assert asked(tab, "/results")[-1]["verb"] == "windows"
    click(tab, "lift")
    tab.wait_for("document.getElementById('lift').disabled")


def wished(tab: browser.Browser) -> None:
    """Options of an import: what is refused stands at its field; the mission follows the others."""
    tab.evaluate("document.querySelector('#import-options').closest('details').open = true")
    judged(tab, LOOKS[-1:])
    put(tab, "#import-duty_cycle", 0.5)
    tab.evaluate("document.getElementById('tick-shown').click()")
    tab.wait_for("!document.getElementById('choose').disabled")
    click(tab, "choose")
    tab.wait_for("document.getElementById('import-duty_cycle-why').textContent.includes('thrust')")
    put(tab, "#import-duty_cycle", "")
    for name, value in {"max_targets": 4, "duration_days": 30}.items():
        put(tab, f"#import-{name}", value)
    put(tab, "#prizes", "criticality")
    tab.wait_for("!document.getElementById('choose').disabled")
    click(tab, "choose")
    on_page(tab, "stage", "mission")
    assert len(asked(tab, "/state")["targets"]) == 4
    assert text(tab, "chosen").startswith("4 targets chosen; left out: max-targets ")


@pytest.mark.slow
def test_each_verb_is_pressed_once(tab: browser.Browser, tmp_path: Path) -> None:
    """On a tiny mission each verb makes its result, pages open, and the console stays silent.

    The page is reached as a browser reaches it at first, by the private file, and stays when it is
    loaded anew.
    """
    (tmp_path / "few.tle").write_bytes(catalogue(60))
    (tmp_path / "uncertainty.json").write_text(json.dumps(UNCERTAINTY))
    with served(tmp_path, "--folder", "project") as said:
        tab.go("about:blank")  # what is there still asks for a server that has ended
        tab.wait_for("location.href === 'about:blank'")
        launched = LaunchFile(tmp_path, said["url"])
        tab.go(launched.address)
        tab.wait_for("location.protocol === 'http:'")
        on_page(tab, "stage", "empty")
        tab.call("Page.reload")
        on_page(tab, "stage", "empty")
        drop(tab, tmp_path / "few.tle", tmp_path / "uncertainty.json")
        on_page(tab, "objects", 60)
        wished(tab)
        put(tab, "#part-dynamics", "j2")
        for number, method in enumerate(("greedy", "beam"), 1):
            put(tab, "#method", method)
            put(tab, "#limit", 2)
            click(tab, "plan")
            on_page(tab, "results", number)
        click(tab, "to-results")
        every_verb(tab)
        points(tab)
        replanned(tab)
        lit(tab)
        click(tab, "to-objects")
        count = len(asked(tab, "/results"))
        click(tab, "work-out")
        on_page(tab, "results", count + 1)
        assert asked(tab, "/results")[-1]["verb"] == "worth"
        tab.wait_for("document.getElementById('colour-by').value === 'worth'")
        click(tab, "to-results")
        tab.evaluate("document.querySelector('[data-verb=worth] .acts button').click()")
        on_page(tab, "paged", count + 1)
        judged(tab)
        exported(tab, tmp_path / "project.zip")
        assert [said for _, said in tab.complaints if "status of 422" not in said] == []
