"""Made-up rows of the benchmark, and its modules, which are no package."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict
from pathlib import Path
from types import ModuleType
from typing import Any

from adr_opt.study.file import StudyFile

BENCH = Path(__file__).parents[2] / "bench"
Load = Callable[[str], ModuleType]


def protocol(load: Load, *specs: str, fields: int = 2, iterations: int = 2, **changes: Any) -> Any:
    trials, methods = load("harness.trials"), load("harness.methods")
    asked = {
        "suites": ("nominal",),
        "fields": fields,
        "iterations": iterations,
        "zones": 6,
        "methods": methods.parse_methods(specs or ("greedy",), 10.0),
        "seed": 0,
        "bound": None,
    }
    return trials.Protocol(**{**asked, **changes})


def row(load: Load, trial: Any, method: str, visits: int = 20, **changes: Any) -> tuple:
    """A row as it stands in a file: key, value and seconds."""
    key = {**asdict(trial), "method": method, "seed": changes.pop("seed", 0)}
    facts = {
        "outcome": "legal",
        "visits": visits,
        "refuellings": 1,
        "objective": float(visits),
        "delta_v_m_s": 5000.0,
        "duration_used_s": 6e5,
        "planning_s": 0.01 * visits,
        "runtime_s": 0.01,
        "check_s": 0.01,
        "build_s": 0.3,
        "sha256": f"{trial.suite}-{trial.field}-{trial.iteration}",
        "environment": load("harness.work").environment(),
    }
    return key, {**facts, **changes}, 1.0


def kept(load: Load, folder: Path, rows: Iterable[tuple]) -> Path:
    """The file of results of a folder, with rows."""
    results = load("harness.results")
    path = results.path_in(folder, create=True)
    file = StudyFile(path, results.study())
    file.append(rows)
    file.close()
    return path


def filled(load: Load, folder: Path, asked: Any) -> Path:
    """A file with a row for everything that a protocol asks for, made up."""
    rows = [
        row(load, trial, method.key, 20 + 3 * number + (trial.field + trial.iteration) % 3)
        for trial in asked.trials()
        for number, method in enumerate(asked.methods)
    ]
    return kept(load, folder, rows)
