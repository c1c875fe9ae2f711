"""The page on rehearsals: its commands and Python run as they stand, on a small field."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

from conftest import Cli
from pages import read

from adr_opt.analysis.rehearse.policies import BUILT_IN
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.ui.report.rehearsed import REASONS

PAGE = read("docs/rehearsing.md")

SHORTER = {"--time-limit": "1", "--samples": "4", "--bounds": "1", "--replay": "1"}


def test_the_commands_of_the_page_run(cli: Cli) -> None:
    """One after the other they do what the page says, and write the files that it names."""
    (content,) = re.findall(r"```json\n(.*?)```", PAGE, re.DOTALL)
    Path("my-uncertainty.json").write_text(content, encoding="utf-8")
    lines = re.findall(r"(?m)^    python -m adr_opt .*$", PAGE)
    assert len(lines) == 6
    for line in lines:
        _, _, _, verb, *words = shlex.split(line)
        if verb == "generate":
            words[0] = "tiny"
        for option, value in SHORTER.items():
            if option in words:
                words[words.index(option) + 1] = value
        outcome = cli(verb, *words)
        assert outcome.status == 0, (line, outcome)
        for option in ("--out", "--out-instance"):
            if option in words:
                assert Path(words[words.index(option) + 1]).stat().st_size > 0


def test_the_python_of_the_page_runs() -> None:
    """The block collects what its policy collects."""
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    names: dict = {}
    exec(code, names)
    assert len(names["made"].outcomes) == 100


def test_policies_and_reasons_are_described() -> None:
    """The page names every policy, and every reason that an answer may have."""
    for name in (*BUILT_IN, *REASONS):
        assert f"`{name}`" in PAGE
    (content,) = re.findall(r"```json\n(.*?)```", PAGE, re.DOTALL)
    assert Uncertainty.from_json(content).capture.tries == 2
    assert json.loads(content)["format"] in read("docs/files.md")
