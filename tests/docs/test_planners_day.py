"""The pages on a planner's day: commands and Python run as they stand, on a small field."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from conftest import Cli

DOCS = Path(__file__).parents[2] / "docs"
PAGES = ("planners-day.md", "replanning.md")
BREAKS = ("price",)
"""Verbs whose answer may be no on the small field."""


@pytest.mark.parametrize(
    "page", [pytest.param("planners-day.md", marks=pytest.mark.slow), "replanning.md"]
)
def test_the_commands_of_the_page_run(cli: Cli, page: str) -> None:
    """One after the other they do what the page says, and write the files that it names."""
    text = (DOCS / page).read_text(encoding="utf-8")
    lines = re.findall(r"(?m)^    python -m adr_opt .*$", text)
    assert len(lines) >= 3
    for line in lines:
        _, _, _, verb, *words = shlex.split(line)
        if verb == "generate":
            words[0] = "tiny"
        if "--time-limit" in words:
            words[words.index("--time-limit") + 1] = "1"
        if "--at" in words:
            words[words.index("--at") + 1] = "0.5"
        outcome = cli(verb, *words)
        assert outcome.status == 0 or (outcome.status == 1 and verb in BREAKS), (line, outcome)
        for option in ("--out", "--page"):
            if option in words and outcome.status == 0:
                assert Path(words[words.index(option) + 1]).stat().st_size > 0


@pytest.mark.parametrize("page", PAGES)
def test_the_python_of_the_page_runs(tmp_path: Path, monkeypatch, page: str) -> None:
    """Each block, one after the other."""
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    text = (DOCS / page).read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert blocks
    for code in blocks:
        exec(code, names)
