"""Pages of all verbs for people who see little, use no mouse or hold a phone."""

from __future__ import annotations

import json
from pathlib import Path

import browser
import page_access
import pytest
from catalogue_files import as_csv, field
from conftest import Cli
from rated_fields import pairs_text, rated, worths_of_sets

import adr_opt

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium"),
]

UNCERTAINTY = {
    "format": "adr-opt-uncertainty/1",
    "legs": {"delta_v_factor": {"lognormal_sigma": 0.2}},
}


def written(cli: Cli, folder: Path) -> list[Path]:
    """A page of each verb that writes one."""
    electric = adr_opt.generate("electric", 0, targets=4, chasers=1)
    whole = rated(targets=3)
    for name, text in {
        "t.json": adr_opt.generate("tiny", 0).to_json(),
        "e.json": electric.to_json(),
        "u.json": json.dumps(UNCERTAINTY),
        "i.json": whole.to_json(),
        "w.json": pairs_text(worths_of_sets(whole)),
        "a.csv": as_csv(field(30)),
    }.items():
        (folder / name).write_text(text, encoding="utf-8")
    for call in (
        "solve t.json --method greedy --out p.json",
        "solve t.json --method beam --out q.json",
        "solve e.json --method greedy --out f.json",
        "report t.json q.json --out report.html",
        "report e.json f.json --out low-thrust.html",
        "compare t.json p.json q.json --page compare.html",
        "tradeoff t.json --vary delta-v=500:1500:500 --method greedy --page tradeoff.html",
        "tradeoff i.json --vary launches=1 --vary kits=1,2 --launch-cost 10e6 --kit-cost 2e6 "
        "--kg-cost 50000 --worth w.json --out d.jsonl --page designs.html",
        "rehearse t.json q.json --uncertainty u.json --samples 50 --out rehearse.html",
        "worth a.csv --out r.csv --candidates 12 --page worth.html",
        "import a.csv --max-targets 2 --launches 1 --kits 2 --duration-days 90 --out c.json",
        "scenario a.csv --method greedy --campaign c.json --years 4 --every 2 --targets 4 "
        "--explosions 0.05 --page scenario.html",
    ):
        outcome = cli(call, "--quiet")
        assert outcome.status == 0, outcome
    return sorted(folder.glob("*.html"))


def test_pages_are_for_everybody(cli: Cli, tmp_path: Path) -> None:
    """At desk and phone width, light and dark: names, headings, contrast, width, no requests."""
    found = {}
    with browser.Browser(tmp_path / "profile", options=("--disable-3d-apis",)) as tab:
        pages = written(cli, Path.cwd())
        assert len(pages) == 8
        for path in pages:
            tab.open(path)
            tab.wait_for("document.readyState === 'complete'")
            if tab.evaluate("Boolean(document.getElementById('mission'))"):
                tab.wait_for("document.documentElement.dataset.ready")
                tab.evaluate("document.getElementById('orbits').scrollIntoView()")
                tab.wait_for("document.documentElement.dataset.complete")
            found[path.stem] = page_access.faults(tab)
            assert [said for level, said in tab.complaints if level == "error"] == []
            assert all(url.startswith(("file:", "data:", "blob:")) for url in tab.requests)
    assert found == {path.stem: [] for path in pages}


FAULTS = {
    "<button><i></i></button>": "button without a name",
    "<p id='a'>a</p><p id='a'>b</p>": "id twice: a",
    "<h3>Too deep</h3>": "heading after level 1",
    "<p style='color: #aaa; background: #fff'>pale</p>": "contrast 2.3",
    "<p style='width: 500px; background: red'>a</p>": "390 px: wider than the window",
    "<table><tr><th></th></tr></table>": "column without a heading",
    "<div role=img aria-label=x><button>a</button></div>": "a picture with controls",
    "<div style='overflow: auto; height: 20px'><p>a<br>b</p></div>": "scrolls by mouse only",
    "</main><main>another": "2 main parts",
    "<input aria-label=a aria-controls=b>": "aria-controls of a missing b",
    "<label for=b>a</label>": "for of a missing b",
    "<p style='position: relative; left: -90px'>a</p>": "1280 px: wider than the window",
    "<a href='#' style='outline: none'>a</a>": "focus is not seen",
    "<input>": "textbox without a name",
    "<i style='display: block; width: 3000px'>a</i>": "the page is 30",
    "<svg width=90 height=90 role=img aria-label=x><rect width=90 height=90 fill='#333'/>"
    "<text x=20 y=40 fill='#444'>dim</text></svg>": "contrast 1.3",
}
"""Content of a page, and how its fault is told of."""


def test_faults_are_found(tmp_path: Path) -> None:
    """Each fault is told of, and a page without any has none."""
    with browser.Browser(tmp_path / "profile") as tab:
        for content, wanted in {"<p>plain</p>": None, **FAULTS}.items():
            (tmp_path / "page.html").write_text(
                '<!DOCTYPE html><html lang="en"><meta name="viewport" content="width=device-width">'
                '<meta name="color-scheme" content="light dark"><link rel="icon" href="data:,">'
                f"<title>t</title><main><h1>One</h1>{content}</main></html>",
                encoding="utf-8",
            )
            tab.open(tmp_path / "page.html")
            tab.wait_for("document.readyState === 'complete'")
            found = page_access.faults(tab, settled="1")
            if wanted is None:
                assert found == []
            else:
                assert any(wanted in each for each in found), (wanted, found)
