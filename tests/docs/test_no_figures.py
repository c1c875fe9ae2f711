"""Pages for contributors state no figures: nobody would notice when they become stale."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

NOT_PROSE = re.compile(r"```.*?```|`[^`]*`|^    .*?$|\]\([^)]*\)|^\d+\. ", re.DOTALL | re.MULTILINE)
"""Code, targets of links, and numbers of lists."""

FIGURE = re.compile(
    r"\S*\d\S*|\b(?:four|five|six|seven|eight|nine|ten|eleven|twelve|twenty|thirty|forty|fifty|sixty"
    r"|hundreds?|thousands?|millions?)\b",
    re.IGNORECASE,
)


def figures(text: str) -> list[str]:
    """Numbers in the prose of a page."""
    return FIGURE.findall(NOT_PROSE.sub(" ", text))


@pytest.mark.parametrize(
    "page",
    ["CONTRIBUTING.md", *sorted(f"docs/{one.name}" for one in ROOT.glob("docs/adding-*.md"))],
)
def test_pages_for_contributors_state_no_figures(page: str) -> None:
    """Counts, times and sizes are printed by scripts that the page names, and stand in no prose."""
    assert figures((ROOT / page).read_text(encoding="utf-8")) == []


def test_the_search_finds_figures() -> None:
    """It finds digits and words in prose, and none in code, links and lists."""
    assert figures("It occurs in 35 modules,\nand Four families.") == ["35", "Four"]
    assert figures("1. see `x[3]` and [that](a.md#22-b)\n\n    pip 3\n\n```\n4\n```\n") == []
