"""What is quoted in a message neither breaks its line nor fills the screen."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import Cli

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.wording import LONGEST_NAME

BREAKS = ["\n", "\r", "\t", "\x0b", "\x0c", "\x1c", "\x85", "\u2028", "\u2029", "\x1b[2J", "\u202e"]


@pytest.mark.parametrize("mark", BREAKS)
@pytest.mark.parametrize("quoted", ["name {}", "name {!r}"])
def test_an_error_is_one_line(mark: str, quoted: str) -> None:
    """Separators of lines, control characters and reversals are escaped in every error."""
    said = str(InputError(quoted.format(f"a{mark}b")))
    assert len(said.splitlines()) == 1
    assert mark not in said
    assert said.isprintable()


@pytest.mark.parametrize("quote", ["'", '"'])
def test_quoted_names_are_cut(quote: str) -> None:
    """A long one keeps its beginning, and what stands around it is kept."""
    said = str(InputError(f"body {quote}{'x' * 10_000}{quote} is unknown; use 'a' or {quote}b"))
    assert len(said) < 120
    assert said.startswith(f"body {quote}{'x' * (LONGEST_NAME - 1)}…{quote} is unknown; use 'a' ")
    assert str(InputError(said)) == said


def test_what_is_short_is_kept() -> None:
    """Apostrophes are no quotes, and a name of the longest length is kept."""
    said = f"the chaser's tank, which '{'x' * LONGEST_NAME}' has, isn't that of {'y' * 90} or 's'"
    assert str(InputError(said)) == said


def test_keys_of_files_are_cut_and_escaped(cli: Cli, tmp_path: Path) -> None:
    """A key of megabytes with separators of lines gives one short line."""
    text = adr_opt.generate("tiny", 0).to_json().rstrip().removesuffix("}")
    path = tmp_path / "tiny.json"
    path.write_text(text + ', "' + "k\u2028" * 100_000 + '": 1}', encoding="utf-8")
    outcome = cli("solve", path)
    assert outcome.status == 2
    assert len(outcome.err.splitlines()) == 1
    assert len(outcome.err) < 500
    assert "unknown; remove it" in outcome.err
