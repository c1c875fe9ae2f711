"""Rows of the benchmark as a study, in one file, and as the report reads them."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import ConfigDict, Field, TypeAdapter

from adr_opt.common.errors import InputError
from adr_opt.common.json_text import validated
from adr_opt.study import Run, Study
from adr_opt.study.file import read
from adr_opt.study.run import row_of

from .trials import Protocol, Trial, Wanted
from .work import Rows, failed

FILE = "results.jsonl"

Facts = dict[str, Any]

TRIAL = ("suite", "field", "iteration", "zones")

EXACT = ConfigDict(strict=True, allow_inf_nan=False, extra="forbid")

Count = Annotated[int, Field(ge=0, lt=2**53)]


@dataclass(frozen=True)
class _Environment:
    __pydantic_config__: ClassVar[ConfigDict] = EXACT

    host: str
    processor: str
    cores: Count
    python: str
    versions: str


@dataclass(frozen=True)
class _Facts:
    """A row with its key, and the types of them; what it may lack is None."""

    __pydantic_config__: ClassVar[ConfigDict] = EXACT

    suite: str
    field: Count
    iteration: Count
    zones: Count
    environment: _Environment
    method: str | None = None
    seed: Count | None = None
    bound: str | None = None
    limit_s: float | None = None
    outcome: str | None = None
    message: str | None = None
    violations: Count | None = None
    status: str | None = None
    objective: float | None = None
    visits: Count | None = None
    refuellings: Count | None = None
    upper_bound: float | None = None
    warm_s: float | None = None
    planning_s: float | None = None
    planning_cpu_s: float | None = None
    runtime_s: float | None = None
    check_s: float | None = None
    build_s: float | None = None
    build_cpu_s: float | None = None
    delta_v_m_s: float | None = None
    duration_used_s: float | None = None
    sha256: str | None = None
    sequence: str | None = None


OF_LEGAL = ("objective", "visits", "refuellings", "delta_v_m_s", "duration_used_s", "planning_s")
"""What no row of a legal plan lacks."""

OPTIONAL = {each.name for each in fields(_Facts)} - {"environment", "outcome", *TRIAL}


def study() -> Study[Any, Facts]:
    """The study of which all rows are: methods and bounds on trials, or their keys as JSON data."""
    adapter = TypeAdapter(_Facts)

    def from_json(key: Wanted | Mapping[str, Any], value: Facts) -> Facts:
        stated = key.key() if isinstance(key, Wanted) else key
        found = validated(adapter, json.dumps({**stated, **value}))
        if found.method is None and found.bound is None:
            raise ValueError("neither of a method nor of a bound")
        if found.method is not None and found.outcome is None:
            raise ValueError("no outcome")
        if found.outcome == "legal" and any(getattr(found, name) is None for name in OF_LEGAL):
            raise ValueError("a legal plan lacks a fact")
        return value

    return Study(
        "benchmark", 1, Rows().row, key=Wanted.key, from_json=from_json, failed=failed, apart=True
    )


def path_in(folder: Path, *, create: bool) -> Path:
    """The file of results of a folder, which is made if asked for.

    Raises
    ------
    InputError
        The folder cannot be written to, or there is no file.
    """
    path = folder / FILE
    if not create and not path.exists():
        raise InputError(f"{path}: no such file; run once without --report-only first")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be written to ({error.strerror or error}); "
            "give another folder with --out"
        ) from None
    return path


def is_failure(facts: Facts) -> bool:
    """Whether a row has no legal plan, or no bound."""
    return facts.get("message") is not None or facts.get("outcome", "legal") != "legal"


def missing(
    running: Run[Wanted, Facts], protocol: Protocol, *, retry_failed: bool
) -> dict[Trial, tuple[Wanted, ...]]:
    """The rows of a protocol that are to be made, by trial.

    Parameters
    ----------
    running : Run
    protocol : Protocol
    retry_failed : bool
        Whether those that failed are to be made again.
    """
    lacking = {}
    for trial in protocol.trials():
        best, left = -math.inf, []
        for each in protocol.wanted(trial):
            facts = running.known(each)
            if facts is not None and retry_failed and is_failure(facts):
                running.forget(each)
                facts = None
            if facts is None:
                left.append(each)
            elif facts.get("outcome") == "legal":
                best = max(best, facts["objective"])
        if left:
            lacking[trial] = tuple(each._replace(best=best) for each in left)
    return lacking


def results(path: Path) -> tuple[list[Facts], list[Facts]]:
    """Rows of methods, each with the bound of its trial, its gap and its machine; and bounds.

    The bound of a trial is the least that was proven of it, by a bound or with a legal plan.
    """
    rows, bounds = list[Facts](), list[Facts]()
    made = study()
    for stored in read(path, made).values():
        value = row_of(made, stored.key, stored)
        facts = {**dict.fromkeys(OPTIONAL), **stored.key, **value}
        (rows if "method" in stored.key else bounds).append(facts | facts.pop("environment"))
    least: dict[tuple[Any, ...], float] = {}
    for trial, bound in _proven([*rows, *bounds]):
        least[trial] = min(bound, least.get(trial, math.inf))
    for row in rows:
        row["bound"] = bound = least.get(_trial(row))
        row["gap"] = None
        if bound is not None and row["outcome"] == "legal":
            row["gap"] = (bound - row["objective"]) / bound if bound > 0.0 else 0.0
    return rows, bounds


def _trial(facts: Facts) -> tuple[Any, ...]:
    return tuple(facts[name] for name in TRIAL)


def _proven(rows: Iterable[Facts]) -> Iterator[tuple[tuple[Any, ...], float]]:
    for row in rows:
        if row["upper_bound"] is not None and row.get("outcome", "legal") == "legal":
            yield _trial(row), row["upper_bound"]
