"""The documentation site: it builds without a warning, works offline, and its pictures are ours."""

from __future__ import annotations

import html
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote
from xml.etree import ElementTree

import browser
import pytest

ROOT = Path(__file__).parents[2]
PICTURES = sorted(ROOT.glob("docs/pictures/*.svg"))
TAKEN = sorted(ROOT.glob("docs/pictures/*.png"))
PHONE = 390


NO_TORCH = """
import sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "torch":
            raise ImportError(name)

sys.meta_path.insert(0, Blocked())
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built as `make docs` builds it, where PyTorch cannot be imported."""
    folder = tmp_path_factory.mktemp("site")
    blocked = tmp_path_factory.mktemp("blocked")
    (blocked / "sitecustomize.py").write_text(NO_TORCH, encoding="utf-8")
    paths = [str(blocked), os.environ.get("PYTHONPATH", "")]
    ran = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)],
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
        env={
            **os.environ,
            "NO_MKDOCS_2_WARNING": "1",
            "PYTHONPATH": os.pathsep.join(path for path in paths if path),
        },
    )
    assert ran.returncode == 0, ran.stderr
    return folder


def pages(site: Path) -> list[Path]:
    """All pages but the one for addresses that are not there."""
    return sorted(page for page in site.rglob("*.html") if page.name != "404.html")


def test_every_page_of_the_repository_is_on_the_site(site: Path) -> None:
    """Each page of docs/ and each family of instances is in the navigation of the first page."""
    first = (site / "index.html").read_text(encoding="utf-8")
    linked = set(re.findall(r'href="([^"#]+\.html)', first)) | {"index.html"}
    documents = [str(path.relative_to(ROOT / "docs")) for path in ROOT.glob("docs/**/*.md")]
    families = [
        f"instances/{path.parent.name}/index.html" for path in ROOT.glob("instances/*/*.md")
    ]
    assert len(documents) >= 15
    assert {name.replace(".md", ".html") for name in documents} <= linked
    assert {*families, "instances/index.html", "examples/index.html", "CHANGELOG.html"} <= linked


def test_links_of_the_site_lead_somewhere(site: Path) -> None:
    """Every link, script, style and picture of every page is a file of the site."""
    for page in pages(site):
        text = page.read_text(encoding="utf-8")
        for link in re.findall(r'(?:href|src)="([^"]*)"', text):
            path = unquote(link.partition("#")[0])
            if path and not re.match(r"https?:|data:|mailto:", path):
                assert (page.parent / path).exists(), f"{page.name}: {link}"


def test_the_site_loads_nothing_from_elsewhere(site: Path) -> None:
    """No page has a script, style, font or picture with an address of the network."""
    for page in pages(site):
        text = page.read_text(encoding="utf-8")
        assert re.findall(r'<(?:script|img|iframe)[^>]*src="(?:https?:)?//[^"]*', text) == []
        links = re.findall(r"<link[^>]*>", text)
        assert [link for link in links if "//" in link and 'rel="canonical"' not in link] == []
    for style in site.rglob("*.css"):
        assert not re.search(r"url\((?:https?:)?//", style.read_text(encoding="utf-8"))


def test_formulas_are_drawn_by_the_browser(site: Path) -> None:
    """The model's formulas are MathML on the site, and no dollar or backslash of them is left."""
    text = (site / "model.html").read_text(encoding="utf-8")
    assert text.count("<math ") > 50
    assert "arithmatex" not in text
    assert not re.search(r"\\(frac|sqrt|mathbf|operatorname|Delta)", text)


def test_links_out_of_docs_are_kept_or_become_text(site: Path) -> None:
    """A link to a page or example of the repository leads there; one to a folder is its text."""
    text = (site / "adding-a-planner.html").read_text(encoding="utf-8")
    assert "<code>examples/random-walks</code>" in text
    assert 'href="examples/random-walks' not in text
    text = (site / "report.html").read_text(encoding="utf-8")
    assert 'href="examples/tour.ipynb"' in text
    assert (site / "examples" / "tour.ipynb").is_file()


def test_the_core_of_verify_is_listed(site: Path) -> None:
    """The site has both files of the core from the first line to the last."""
    text = html.unescape(
        re.sub(r"<[^>]*>", "", (site / "core-listing.html").read_text(encoding="utf-8"))
    )
    for name in ("closed", "completion"):
        path = ROOT / "adr_opt" / "judge" / "verify" / f"{name}.py"
        lines = path.read_text(encoding="utf-8").strip().splitlines()
        assert lines[0] in text
        assert lines[-1] in text


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.parametrize("width", [1280, PHONE])
@pytest.mark.slow
def test_the_site_in_a_browser(site: Path, tmp_path: Path, width: int) -> None:
    """Opened as files, no page complains, asks the network, or is wider than the window."""
    with browser.Browser(tmp_path / "profile", width=width) as tab:
        for page in pages(site):
            tab.open(page)
            tab.wait_for("document.readyState == 'complete'")
            assert [text for level, text in tab.complaints if level == "error"] == [], page.name
            assert [to for to in tab.requests if not to.startswith(("file:", "data:"))] == []
            assert tab.evaluate("document.documentElement.scrollWidth") == width, page.name
            broken = "[...document.images].filter((image) => !image.naturalWidth).length"
            assert tab.evaluate(broken) == 0


@pytest.mark.slow
@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
def test_the_search_works_in_a_folder(site: Path, tmp_path: Path) -> None:
    """Opened as a file, without a server, the site finds pages by words."""
    with browser.Browser(tmp_path / "profile") as tab:
        tab.open(site / "index.html")
        tab.wait_for("document.readyState == 'complete'")
        box = "document.querySelector('.md-search__input').getBoundingClientRect()"
        at = {"x": tab.evaluate(f"{box}.x + 40"), "y": tab.evaluate(f"{box}.y + {box}.height / 2")}
        for kind in ("mousePressed", "mouseReleased"):
            tab.call("Input.dispatchMouseEvent", type=kind, button="left", clickCount=1, **at)
        for letter in "zones":
            tab.call("Input.dispatchKeyEvent", type="keyDown", text=letter, key=letter)
            tab.call("Input.dispatchKeyEvent", type="keyUp", key=letter)
        tab.wait_for("document.querySelectorAll('.md-search-result__item').length > 1")
        found = tab.evaluate("document.querySelector('.md-search-result__list').textContent")
        assert "Keep-out" in found


@pytest.mark.parametrize("picture", PICTURES, ids=lambda path: path.stem)
def test_pictures_are_small_and_self_contained(picture: Path) -> None:
    """Each picture is an SVG file of less than 100 kB that loads nothing and runs nothing."""
    assert picture.stat().st_size < 100_000
    tree = ElementTree.parse(picture)
    assert tree.getroot().tag == "{http://www.w3.org/2000/svg}svg"
    for element in tree.iter():
        assert element.tag.rpartition("}")[2] not in ("script", "image", "foreignObject")
        for name, value in element.attrib.items():
            assert not name.endswith("href") or value.startswith("#")


def test_pictures_that_are_taken_are_small() -> None:
    """Pictures of pages are PNG files of less than 200 kB; docs/draw_serve.py takes them."""
    names = ["reports-before.png", "reports.png", "serve-objects.png", "serve.png"]
    assert [picture.name for picture in TAKEN] == names
    for picture in TAKEN:
        assert picture.stat().st_size < 200_000
        assert picture.read_bytes().startswith(b"\x89PNG\r\n")


def test_every_picture_is_shown_with_a_text_for_those_who_do_not_see_it() -> None:
    """Each drawn picture is on a page, and each picture on a page says in words what it shows."""
    shown = {}
    for page in (*ROOT.glob("docs/**/*.md"), ROOT / "CONTRIBUTING.md"):
        text = page.read_text(encoding="utf-8")
        for words, path in re.findall(r"!\[([^\]]*)\]\(([^)]+)\)", text):
            shown[(page.parent / path).resolve()] = words
    drawn = {picture for picture in (*PICTURES, *TAKEN) if picture.name != "icon.svg"}
    assert set(shown) == drawn
    assert all(len(words.split()) > 5 for words in shown.values())


@pytest.mark.slow
def test_the_pictures_are_what_the_script_draws(tmp_path: Path) -> None:
    """docs/draw_model.py draws the committed pictures: the same files, of about the same size."""
    pytest.importorskip("matplotlib")
    draw = runpy.run_path(str(ROOT / "docs/draw_model.py"))["draw"]
    drawn = draw(tmp_path)
    # The tasks, the benchmark, the page on contributing, the plan that moves and the diagrams have
    # scripts of their own.
    own = ("task-", "time-quality", "house", "plan", "choice", "chaser", "relaxation")
    others = {path.name for path in PICTURES if path.name.startswith(own)}
    assert {path.name for path in drawn} == {path.name for path in PICTURES} - {"icon.svg", *others}
    for path in drawn:
        # Not byte for byte: matplotlib's releases differ in how they write a glyph.
        committed = ROOT / "docs" / "pictures" / path.name
        assert path.stat().st_size == pytest.approx(committed.stat().st_size, rel=0.2)


def test_the_plan_that_moves_is_that_of_the_library(tmp_path: Path) -> None:
    """docs/draw_plan.py draws the committed picture, byte for byte."""
    draw = runpy.run_path(str(ROOT / "docs/draw_plan.py"))["draw"]
    assert draw(tmp_path).read_bytes() == (ROOT / "docs/pictures/plan.svg").read_bytes()


def test_the_diagrams_are_what_their_script_draws(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """docs/draw_diagrams.py draws the committed diagrams: files of about the same size."""
    pytest.importorskip("matplotlib")
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    for path in runpy.run_path(str(ROOT / "docs/draw_diagrams.py"))["draw"](tmp_path):
        committed = ROOT / "docs/pictures" / path.name
        assert path.stat().st_size == pytest.approx(committed.stat().st_size, rel=0.2)
