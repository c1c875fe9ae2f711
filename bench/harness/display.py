"""Progress of a run and its expected end: a rich display, or a line now and then."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

from .results import is_failure
from .trials import Trial, Wanted

QUIET_S = 30.0
"""Interval between lines without a terminal."""

GUESS_S = 1.0
"""Initial estimate, as a share of the time limit at most, for an unknown row or a timetable."""


class Forecast:
    """Seconds of work that are left, from the means of what has been seen.

    Parameters
    ----------
    lacking : mapping
        Rows that are missing, by trial.
    """

    def __init__(self, lacking: Mapping[Trial, Sequence[Wanted]]) -> None:
        self._left = Counter(_kind(each) for rows in lacking.values() for each in rows)
        self._limits = {
            _kind(each): each.what.limit_s for rows in lacking.values() for each in rows
        }
        self._seen = dict[tuple[str, str], tuple[float, int]]()
        self._trials, self._rows = len(lacking), self._left.total()
        self._build_s = GUESS_S

    def hear(self, wanted: Wanted, facts: Mapping[str, Any]) -> None:
        """Take note of a row, and of what the timetable took that its trial shares."""
        kind = _kind(wanted)
        self._build_s += 0.1 * (facts.get("build_s", 0.0) - self._build_s)
        total, count = self._seen.get(kind, (0.0, 0))
        seconds = facts.get("planning_s", 0.0) + facts.get("check_s", 0.0)
        self._seen[kind] = total + seconds, count + 1
        self._left[kind] -= 1

    def left_s(self, workers: int) -> float:
        """Wall time left with some workers."""
        share = self._left.total() / max(1, self._rows)
        work = share * self._trials * self._build_s
        for kind, count in self._left.items():
            total, seen = self._seen.get(kind, (0.0, 0))
            work += count * (total / seen if seen else min(GUESS_S, self._limits[kind]))
        return work / max(1, workers)


def _kind(wanted: Wanted) -> tuple[str, str]:
    """What rows of about the same time have in common."""
    what = wanted.key().get("method") or wanted.what.name
    return wanted.trial.suite, what


class Display:
    """Shows a run on standard error; a context manager.

    Parameters
    ----------
    lacking : mapping
        Rows that are missing, by trial.
    workers : int
    quiet : bool
        Show nothing.
    """

    def __init__(
        self, lacking: Mapping[Trial, Sequence[Wanted]], workers: int, *, quiet: bool = False
    ) -> None:
        self._forecast, self._workers = Forecast(lacking), workers
        self._total = sum(map(len, lacking.values()))
        self._kept, self._wrong = 0, 0
        self._quiet = quiet
        self._said = time.monotonic()
        self._progress: Any = None

    def __enter__(self) -> Self:
        """Begin."""
        if not self._quiet and sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
            from rich.progress import TimeElapsedColumn as Elapsed

            self._progress = Progress(
                TextColumn("{task.description}"),
                BarColumn(),
                MofNCompleteColumn(),
                Elapsed(),
                TextColumn("{task.fields[forecast]}"),
                console=Console(stderr=True),
                transient=True,
            )
            self._task = self._progress.add_task("plans", total=self._total, forecast="")
            self._progress.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End."""
        if self._progress is not None:
            self._progress.stop()

    def kept(self, wanted: Wanted, facts: Mapping[str, Any]) -> None:
        """Show how far it is after a row."""
        self._kept += 1
        self._wrong += is_failure(facts)
        self._forecast.hear(wanted, facts)
        forecast = f"about {clock(self._forecast.left_s(self._workers))} left"
        if self._wrong:
            forecast += f", {self._wrong} failed"
        if self._progress is not None:
            self._progress.update(self._task, completed=self._kept, forecast=forecast)
        elif not self._quiet and time.monotonic() - self._said > QUIET_S:
            self._said = time.monotonic()
            print(f"{self._kept} of {self._total}, {forecast}", file=sys.stderr, flush=True)


def clock(seconds: float) -> str:
    """A duration as people say it."""
    if seconds < 60.0:
        return f"{seconds:.0f} s"
    if seconds < 3600.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"
