"""The comparison of two commits, work by work."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "bench/paired_commits.py"


@pytest.fixture(scope="module")
def script() -> Iterator[ModuleType]:
    """The script, which imports from its folder."""
    spec = importlib.util.spec_from_file_location("paired_commits", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(SCRIPT.parent))
    sys.modules["paired_commits"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["paired_commits"]
    sys.path.remove(str(SCRIPT.parent))


def rows(times_s: list[float], outcome: object) -> list[dict[str, Any]]:
    """What a side answers, as often as it is asked."""
    return [{"wall_s": each, "cpu_s": 2.0 * each, "outcome": outcome} for each in times_s]


def test_ratios_are_those_of_pairs(script: ModuleType) -> None:
    """A machine that is ten times as slow for one pair moves no ratio, and 2 % more show."""
    old = [1.0, 10.0, 1.0, 1.0, 1.0]
    spread = script.Spread.of(old, [1.02 * each for each in old])
    assert spread.low == pytest.approx(1.02)
    assert spread.median == pytest.approx(1.02)
    assert spread.high == pytest.approx(1.02)


def test_other_results_are_named(script: ModuleType) -> None:
    """A row says whether both sides came to the same result, each time."""
    old, new = rows([1.0, 1.0], {"objective": 3}), rows([0.5, 0.5], {"objective": 3})
    row = script.table_row("beam", old, new)
    assert row.startswith("| beam | 1000.0 ms | 500.0 ms | 0.500 |")
    assert row.endswith("| yes |")
    assert script.table_row("beam", old, [*new[:1], *rows([0.5], None)]).endswith("| **no** |")


def test_who_is_first_alternates(script: ModuleType) -> None:
    """Either side begins as often as the other, and both do all works in each repeat."""
    asked: list[tuple[str, str]] = []

    class Fake:
        def __init__(self, name: str) -> None:
            self.name = name

        def do(self, work: str) -> dict[str, Any]:
            asked.append((self.name, work))
            return rows([1.0], None)[0]

    old, new = script.measured([Fake("old"), Fake("new")], ["check"], 4)
    assert len(old["check"]) == len(new["check"]) == 4
    assert [name for name, _ in asked] == ["old", "new", "new", "old"] * 2


@pytest.mark.slow
def test_a_commit_against_the_working_tree(tmp_path: Path) -> None:
    """Both sides do all works, each with the code of its own tree, and leave no worktree."""
    git = ["git", "-C", str(ROOT)]
    if subprocess.run([*git, "rev-parse", "HEAD"], capture_output=True, check=False).returncode:
        pytest.skip("not a checkout")
    works = ["timetable", "environment", "check"]
    command = [sys.executable, str(SCRIPT), "HEAD", "--tiny", "--repeats", "2", "--works", *works]
    env = {**os.environ, "TMPDIR": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=env)
    table = [line.split(" | ")[0] for line in done.stdout.splitlines() if " ms | " in line]
    assert table == [f"| {work}" for work in works]
    assert list(tmp_path.iterdir()) == []
    assert str(tmp_path) not in subprocess.check_output([*git, "worktree", "list"], text=True)
