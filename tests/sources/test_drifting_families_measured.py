"""The families whose nodes drift in the benchmark and in the table of best-known plans."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import adr_opt
from adr_opt.sources.library import Entry, Library
from adr_opt.study import Place

BENCH = Path(__file__).parents[2] / "bench"
NAME = "rocket-bodies-002"


@pytest.fixture(autouse=True)
def _scripts(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let the scripts of the benchmark be imported, which are no package."""
    monkeypatch.syspath_prepend(str(BENCH))
    yield
    sys.modules.pop("best_known", None)


@pytest.mark.slow
def test_the_benchmark_plans_checks_and_bounds_them() -> None:
    """A trial of rocket bodies comes back with a legal plan below its bound, not of the clock."""
    trials, methods = import_module("harness.trials"), import_module("harness.methods")
    rows = import_module("harness.work").Rows()
    assert trials.parse_suites(["rocket-bodies,sso"]) == ("rocket-bodies", "sso")
    trial, (beam,) = trials.Trial("rocket-bodies", 2, 0, 0), methods.parse_methods(["beam"], 10.0)
    row, bound = (
        rows.row(trials.Wanted(trial, what, 0), Place())
        for what in (beam, trials.BoundCall("lagrangian", 3.0))
    )
    assert row["outcome"] == "legal", row
    assert row["visits"] == row["objective"] >= 5.0
    assert row["refuellings"] == 0
    assert row["objective"] <= bound["upper_bound"] <= 20.0


@pytest.mark.slow
def test_the_table_takes_their_plans_and_gives_them_back(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A plan that is found becomes a row, and the order of the row becomes a legal plan again."""
    script: Any = import_module("best_known")
    instance = adr_opt.generate("rocket-bodies", 2)
    entry = Entry(name=NAME, sha256=instance.sha256)
    library = Library(version="1.0", instances=(entry,))
    (tmp_path / "library.json").write_text(library.to_json(), encoding="utf-8")
    there = ["--folder", str(tmp_path)]
    options = [*there, "solve", "--method", "beam", "--bound", "none"]
    assert script.main([*options, "--time-limit", "10", "--family", "rocket-bodies"]) == 0
    row = script.read_table(tmp_path)[NAME]
    assert row.objective == len(row.routes[0]) >= 5
    assert min(row.routes[0]) >= 1
    out = tmp_path / "plan.json"
    assert script.main([*there, "plan", NAME, "--out", str(out)]) == 0
    plan = adr_opt.load_plan(out)
    assert adr_opt.check(instance, plan) == ()
    assert plan.objective == row.objective
    assert plan.delta_v_m_s == pytest.approx(row.delta_v_m_s)
    capsys.readouterr()
    assert script.main([*options, "--missing", "--family", "rocket-bodies"]) == 0
    said = capsys.readouterr().out
    assert "not better" in said or not said
