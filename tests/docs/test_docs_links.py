"""Links between the pages lead somewhere."""

from __future__ import annotations

import re

from pages import PAGES, ROOT, read

ROOMS = ("adr_opt", "solvers", "tests", "bench", "docs", "examples")
CITED = re.compile(r"docs/model\.md\s+sections?\s+(\d[\d.]*(?:(?:,| and| to)\s+\d[\d.]*)*)")


def test_links_between_pages_lead_somewhere() -> None:
    """Every relative link of a page names a file or folder, and every anchor a heading."""
    for page in PAGES:
        for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
            if link.startswith(("http:", "https:", "mailto:")):
                continue
            path, _, anchor = link.partition("#")
            target = page.parent / path if path else page
            assert target.exists(), f"{page.name}: {link}"
            if anchor:
                headings = re.findall(
                    r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.MULTILINE
                )
                slugs = [re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings]
                assert anchor in slugs, f"{page.name}: {link}"


def test_sections_of_the_model_that_are_cited_are_there() -> None:
    """Every section of docs/model.md that code or a page cites has a heading with its number."""
    headings = re.findall(r"^#+ (\d+(?:\.\d+)?) ", read("docs/model.md"), re.MULTILINE)
    code = [path for room in ROOMS for path in ROOT.glob(f"{room}/**/*.py")]
    for path in (*PAGES, *code):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"\bMODEL[\s#]+sec", text), path
        for numbers in CITED.findall(text):
            for number in re.findall(r"\d+(?:\.\d+)?", numbers):
                assert number in headings, f"{path}: {number}"
