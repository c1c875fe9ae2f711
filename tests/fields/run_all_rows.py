"""Made-up rows of the benchmark, and its modules, which are no package."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

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


def row(load: Load, trial: Any, method: str, visits: int = 20, **changes: Any) -> tuple[str, dict]:
    """A message with a row as a worker tells it."""
    facts = {
        "suite": trial.suite,
        "field": trial.field,
        "iteration": trial.iteration,
        "zones": trial.zones,
        "method": method,
        "seed": 0,
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
        "environment": load("harness.environment").environment(),
    }
    return "row", {**facts, **changes}


def filled(load: Load, folder: Path, asked: Any) -> Any:
    """A store with a row for everything that a protocol asks for, made up."""
    store = load("harness.store").Store(folder)
    run = store.begin_run("test", asked, 1)
    rows = [
        row(load, trial, method.key, 20 + 3 * number + (trial.field + trial.iteration) % 3)
        for trial in asked.trials()
        for number, method in enumerate(asked.methods)
    ]
    store.keep(rows, run)
    store.end_run(run, 1.0, dict.fromkeys((*load("harness.work").PARTS, "task"), 0.1))
    return store
