"""The page on a planner's day: its commands and its Python run as they stand, on a small field."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from conftest import Cli

PAGE = (Path(__file__).parents[2] / "docs" / "planners-day.md").read_text(encoding="utf-8")
BREAKS = ("price",)
"""Verbs whose answer may be no on the small field."""


def test_the_commands_of_the_page_run(cli: Cli) -> None:
    """One after the other they do what the page says, and write the files that it names."""
    lines = re.findall(r"(?m)^    python -m adr_opt .*$", PAGE)
    assert len(lines) >= 4
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


def test_the_python_of_the_page_runs(tmp_path: Path, monkeypatch) -> None:
    """Each block, one after the other."""
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert blocks
    for code in blocks:
        exec(code, names)
