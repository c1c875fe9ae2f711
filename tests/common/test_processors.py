"""Cores are counted on every system, and verbs that use them run there."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from catalogue_files import as_csv, field
from conftest import Cli

from adr_opt.common.processors import usable_cores


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """A system that does not tell to which cores a process is bound."""
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    return monkeypatch


def test_there_is_a_core_wherever_nothing_is_told(elsewhere: pytest.MonkeyPatch) -> None:
    """Without a set of cores it is the number of the machine, and 1 if that is unknown."""
    elsewhere.setattr(os, "cpu_count", lambda: 7)
    assert usable_cores() == 7
    elsewhere.setattr(os, "cpu_count", lambda: None)
    assert usable_cores() == 1


def test_cores_are_those_that_the_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that is bound to some cores uses no others."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {3, 5}, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    assert usable_cores() == 2


def test_verbs_run_where_no_cores_are_told(cli: Cli, elsewhere: pytest.MonkeyPatch) -> None:
    """`worth` and `scenario` count cores, and run on macOS and Windows, too."""
    Path("a.csv").write_text(as_csv(field(12)), encoding="utf-8")
    worth = cli("worth", "a.csv", "--out", "p.csv", "--candidates", 4, "--quiet")
    assert worth.status == 0, worth
    scenario = cli("scenario", "a.csv", "--years", 2, "--seeds", 1, "--out", "o.csv", "--quiet")
    assert scenario.status == 0, scenario
