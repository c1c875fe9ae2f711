"""Pages whose commands follow one another: they and the Python run, on a small field."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest
from conftest import Cli
from pages import python_blocks, read

from adr_opt.analysis.rehearse.policies import BUILT_IN
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.ui.report.rehearsed import REASONS

PAGES = ("planners-day", "replanning", "rehearsing")
SHORTER = {"--time-limit": "1", "--samples": "4", "--bounds": "1", "--replay": "1", "--at": "0.5"}
BREAKS = ("price",)
"""Verbs whose answer may be no on the small field."""


def uncertainty() -> str:
    """The file that the page on rehearsals shows."""
    (content,) = re.findall(r"```json\n(.*?)```", read("docs/rehearsing.md"), re.DOTALL)
    return content


@pytest.mark.parametrize(
    "page", [pytest.param(page, marks=[pytest.mark.slow] * (page == PAGES[0])) for page in PAGES]
)
def test_the_commands_of_the_page_run(cli: Cli, page: str) -> None:
    """One after the other they do what the page says, and write the files that it names."""
    Path("my-uncertainty.json").write_text(uncertainty(), encoding="utf-8")
    lines = re.findall(r"(?m)^    python -m adr_opt .*$", read(f"docs/{page}.md"))
    assert len(lines) >= 3
    for line in lines:
        _, _, _, verb, *words = shlex.split(line)
        if verb == "generate":
            words[0] = "tiny"
        for option, value in SHORTER.items():
            if option in words:
                words[words.index(option) + 1] = value
        outcome = cli(verb, *words)
        assert outcome.status == 0 or (outcome.status == 1 and verb in BREAKS), (line, outcome)
        for option in ("--out", "--out-instance", "--page"):
            if option in words and outcome.status == 0:
                assert Path(words[words.index(option) + 1]).stat().st_size > 0


@pytest.mark.parametrize("page", PAGES)
def test_the_python_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, page: str
) -> None:
    """Each block, one after the other; a hundred rehearsals are those asked for."""
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    blocks = python_blocks(read(f"docs/{page}.md"))
    assert blocks
    for code in blocks:
        exec(code, names)
    if page == "rehearsing":
        assert len(names["made"].outcomes) == 100


def test_policies_and_reasons_are_described() -> None:
    """The page names every policy, and every reason that an answer may have."""
    for name in (*BUILT_IN, *REASONS):
        assert f"`{name}`" in read("docs/rehearsing.md")
    assert Uncertainty.from_json(uncertainty()).capture.tries == 2
    assert json.loads(uncertainty())["format"] in read("docs/files.md")
