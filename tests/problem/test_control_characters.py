"""Names of files cannot move the cursor, clear the screen or write lines of their own."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Cli, refused

import adr_opt

NAMES = ("a\x1b[31mred", "b\x9b2J", "c\nadr-opt: wrote it", "d\u202eabc", "e\x7f", "f\r", "g\x07")


@pytest.fixture
def odd_file(tmp_path: Path) -> Path:
    """A tiny instance whose name and targets hold control characters."""
    instance = adr_opt.generate("tiny", 0)
    targets = [
        target.replace(name=name) for target, name in zip(instance.targets, NAMES, strict=True)
    ]
    path = tmp_path / "odd.json"
    instance.replace(name="in\x1b[2Jstance", targets=targets).save(path)
    return path


def is_harmless(text: str) -> bool:
    """Whether a terminal shows it and does nothing else."""
    return all(each.isprintable() or each == "\n" for each in text)


def test_names_are_said_with_escapes(cli: Cli, odd_file: Path) -> None:
    """Tables, messages and errors show control characters as escapes."""
    solved = cli("solve", odd_file, "--method", "greedy-guarded", "--out", "plan.json")
    assert solved.status == 0
    visited = [leg.destination for leg in adr_opt.plan.plan.load_plan("plan.json").legs]
    assert set(visited) & set(NAMES)
    for call in (
        ("solve", odd_file, "--method", "greedy-guarded"),
        ("check", odd_file, "plan.json"),
        ("bound", odd_file, "--method", "none-such\x1b[2J"),
        ("check", "none\x1b[2J.json", "plan.json"),
    ):
        outcome = cli(*call)
        assert is_harmless(outcome.out + outcome.err), call
    assert "\\u" in solved.out
    refused(cli("price", odd_file, "nobody\nadr-opt: wrote it"), "nobody")


def test_json_is_the_same_json(cli: Cli, odd_file: Path) -> None:
    """What --json prints holds escapes of its own, and says the names as they are."""
    outcome = cli("solve", odd_file, "--method", "greedy-guarded", "--json", "--quiet")
    assert is_harmless(outcome.out)
    content = json.loads(outcome.out)
    left = {each["target"] for each in content["unvisited"]}
    gone = {leg["destination"] for leg in content["routes"][0]["legs"]} - {"station"}
    assert left | gone == set(NAMES)
