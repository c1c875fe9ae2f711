"""The rows by suite and method, and what the report says of each."""

from __future__ import annotations

import csv
import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..methods import labels
from ..results import results as rows_of
from .failures import TOLERANCE, failures
from .statistics import Mission, field_means, interval

Row = dict[str, Any]

BEST_KNOWN = Path(__file__).resolve().parents[3] / "instances" / "best-known.csv"


@dataclass(frozen=True)
class Means:
    """One line of the table of means, and of ``summary.csv``.

    Mean and interval are over fields, each the mean of its iterations; a mission without a legal
    plan counts as no visits. Gaps are (bound − objective) / bound and (best − objective) / best,
    over the missions that have a bound, or a best plan. Times are of legal plans only; the
    timetable is built once for all methods of a mission and counts only in the last two of them,
    of which the second is the time of processors; NaN in rows from before that was noted.
    """

    suite: str
    zones: int
    method: str
    fields: int
    missions: int
    failed: int
    visits_mean: float
    visits_half_width: float
    visits_min: int
    visits_max: int
    bounded: int
    gap_to_bound: float
    optimal: int
    gap_to_best_known: float
    delta_v_m_s: float
    duration_used_s: float
    refuellings: float
    planning_median_s: float
    planning_max_s: float
    with_timetable_median_s: float
    with_timetable_cpu_s: float


@dataclass(frozen=True)
class Section:
    """One suite with one number of zones.

    Attributes
    ----------
    suite : str
    zones : int
    rows : dict of str to list of dict
        By method, in the order in which methods were first asked for.
    bounds : dict
        Least proven bound by field and iteration.
    best : dict
        Best objective known by field and iteration.
    """

    suite: str
    zones: int
    rows: dict[str, list[Row]]
    bounds: dict[tuple[int, int], float]
    best: dict[tuple[int, int], float]

    @property
    def title(self) -> str:
        """Title of the section."""
        number = "no keep-out zones" if self.zones == 0 else f"{self.zones} keep-out zones"
        return f"{self.suite}, {number}"

    @property
    def stem(self) -> str:
        """The same as a file's name."""
        return f"{self.suite}-z{self.zones}"

    def visits(self, method: str) -> dict[Mission, float]:
        """Visits by mission; none without a legal plan."""
        return {
            _mission(row): float(row["visits"]) if row["outcome"] == "legal" else 0.0
            for row in self.rows[method]
        }

    def seconds(self, method: str) -> dict[Mission, float]:
        """Planning time by mission, of legal plans [s]."""
        return {
            _mission(row): row["planning_s"]
            for row in self.rows[method]
            if row["outcome"] == "legal"
        }

    def means(self, method: str) -> Means:
        """The line of a method."""
        rows = self.rows[method]
        legal = [row for row in rows if row["outcome"] == "legal"]
        visits = self.visits(method)
        by_field = list(field_means(visits).values())
        mean, half = interval(by_field)
        gaps = [row["gap"] for row in legal if row["gap"] is not None]
        to_best = []
        for row in legal:
            best = self.best[row["field"], row["iteration"]]
            to_best.append((best - row["objective"]) / best if best > 0.0 else 0.0)
        times = [row["planning_s"] for row in legal]
        return Means(
            suite=self.suite,
            zones=self.zones,
            method=method,
            fields=len(by_field),
            missions=len(rows),
            failed=len(rows) - len(legal),
            visits_mean=mean,
            visits_half_width=half,
            visits_min=int(min(visits.values())),
            visits_max=int(max(visits.values())),
            bounded=len(gaps),
            gap_to_bound=_mean(gaps),
            optimal=sum(gap <= TOLERANCE for gap in gaps),
            gap_to_best_known=_mean(to_best),
            delta_v_m_s=_mean([row["delta_v_m_s"] for row in legal]),
            duration_used_s=_mean([row["duration_used_s"] for row in legal]),
            refuellings=_mean([row["refuellings"] for row in legal]),
            planning_median_s=statistics.median(times) if times else math.nan,
            planning_max_s=max(times, default=math.nan),
            with_timetable_median_s=statistics.median(
                [row["planning_s"] + row["build_s"] for row in legal] or [math.nan]
            ),
            with_timetable_cpu_s=statistics.median(
                [_known(row["planning_cpu_s"]) + _known(row["build_cpu_s"]) for row in legal]
                or [math.nan]
            ),
        )


@dataclass(frozen=True)
class Results:
    """Everything that the report is made from."""

    sections: tuple[Section, ...]
    labels: dict[str, str]
    failures: tuple[str, ...]
    machines: tuple[tuple[Row, int], ...]


def read(path: Path) -> Results:
    """Read a file of results."""
    rows, bounds = rows_of(path)
    order = dict.fromkeys(row["method"] for row in rows)
    short = labels(order)
    grouped: dict[tuple[str, int], dict[str, list[Row]]] = {}
    for row in rows:
        section = grouped.setdefault((row["suite"], row["zones"]), {})
        section.setdefault(row["method"], []).append(row)
    known = best_known()
    machines: dict[tuple[Any, ...], tuple[Row, int]] = {}
    for row in rows:
        key = tuple(row[name] for name in ("host", "processor", "cores", "python", "versions"))
        machines[key] = (row, machines.get(key, (row, 0))[1] + 1)
    return Results(
        sections=tuple(
            _section(suite, zones, methods, order, known)
            for (suite, zones), methods in sorted(grouped.items(), key=lambda item: _place(item[0]))
        ),
        labels=short,
        failures=tuple(failures(rows, bounds, short)),
        machines=tuple(machines.values()),
    )


def _section(
    suite: str,
    zones: int,
    methods: dict[str, list[Row]],
    order: Iterable[str],
    known: dict[str, float],
) -> Section:
    bounds: dict[tuple[int, int], float] = {}
    best: dict[tuple[int, int], float] = {}
    for row in (row for rows in methods.values() for row in rows):
        trial = (row["field"], row["iteration"])
        if row["bound"] is not None:
            bounds[trial] = row["bound"]
        if row["outcome"] == "legal":
            so_far = max(best.get(trial, 0.0), known.get(row["sha256"], 0.0))
            best[trial] = max(so_far, row["objective"])
    return Section(
        suite, zones, {key: methods[key] for key in order if key in methods}, bounds, best
    )


def best_known(path: Path = BEST_KNOWN) -> dict[str, float]:
    """Objectives of the best plans known by SHA-256 of the instance; none without the file."""
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as lines:
        return {
            line["sha256"]: float(line["objective"])
            for line in csv.DictReader(lines)
            if line["objective"]
        }


def _known(value: float | None) -> float:
    return math.nan if value is None else value


def _mission(row: Row) -> Mission:
    return row["field"], row["iteration"], row["seed"]


def _place(section: tuple[str, int]) -> tuple[int, str, int]:
    known = ("nominal", "reduced-time", "reduced-fuel")
    suite, zones = section
    return (known.index(suite) if suite in known else len(known), suite, zones)


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values) if values else math.nan
