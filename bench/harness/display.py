"""Progress of a run and its expected end: a rich display, or a line now and then."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from types import TracebackType
from typing import Any, Self

from .trials import Protocol, Trial

QUIET_S = 30.0
"""Interval between lines without a terminal."""

GUESS_S = 1.0
"""Initial estimate, as a share of the time limit at most, for an unknown method or a timetable."""


def _bounds(protocol: Protocol, missing: Mapping[Trial, set[str]]) -> int:
    """Maximum number of bounds to prove."""
    return sum(protocol.bound_for(trial.suite) is not None for trial in missing)


class Forecast:
    """Seconds of work that are left, from the means of what has been seen.

    Parameters
    ----------
    protocol : Protocol
    missing : mapping
        Methods that are missing, by trial.
    seconds : mapping
        Mean seconds by suite and method from rows that are there already.
    """

    def __init__(
        self,
        protocol: Protocol,
        missing: Mapping[Trial, set[str]],
        seconds: Mapping[tuple[str, str], float],
    ) -> None:
        self._limits = {method.key: method.limit_s for method in protocol.methods}
        self._sums = {key: (mean, 1) for key, mean in seconds.items()}
        self._left: dict[tuple[str, str], int] = {}
        for trial, keys in missing.items():
            for key in keys:
                self._left[trial.suite, key] = self._left.get((trial.suite, key), 0) + 1
        self._trials, self._rows = len(missing), sum(self._left.values())
        self._build_s = GUESS_S
        self._bounds = _bounds(protocol, missing)
        self._bound_s = protocol.bound.limit_s if protocol.bound is not None else 0.0

    def hear(self, suite: str, method: str, seconds: float, build_s: float) -> None:
        """Take note of a row, and of what the timetable took that its trial shares."""
        self._build_s += 0.1 * (build_s - self._build_s)
        total, count = self._sums.get((suite, method), (0.0, 0))
        self._sums[suite, method] = (total + seconds, count + 1)
        if self._left.get((suite, method), 0) > 0:
            self._left[suite, method] -= 1

    def hear_bound(self, seconds: float) -> None:
        """Take note of a bound."""
        self._bounds = max(0, self._bounds - 1)
        self._bound_s += 0.1 * (seconds - self._bound_s)

    def left_s(self, workers: int) -> float:
        """Wall time left with some workers."""
        share = sum(self._left.values()) / max(1, self._rows)
        work = self._bounds * self._bound_s + share * self._trials * self._build_s
        for (suite, method), count in self._left.items():
            total, seen = self._sums.get((suite, method), (0.0, 0))
            mean = total / seen if seen else min(GUESS_S, self._limits[method])
            work += count * mean
        return work / max(1, workers)


class Display:
    """Shows a run on standard error; a context manager.

    Parameters
    ----------
    protocol, missing, seconds
        As of :class:`Forecast`.
    quiet : bool
        Show nothing.
    """

    def __init__(
        self,
        protocol: Protocol,
        missing: Mapping[Trial, set[str]],
        seconds: Mapping[tuple[str, str], float],
        *,
        quiet: bool = False,
    ) -> None:
        self._forecast = Forecast(protocol, missing, seconds)
        self._total = sum(len(keys) for keys in missing.values())
        self._total += _bounds(protocol, missing)
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

    def kept(self, facts: Mapping[str, Any]) -> None:
        """A row or a bound was kept."""
        self._kept += 1
        seconds = (facts.get("planning_s") or 0.0) + (facts.get("check_s") or 0.0)
        if "outcome" in facts:
            self._forecast.hear(
                facts["suite"], facts["method"], seconds, facts.get("build_s") or 0.0
            )
            self._wrong += facts["outcome"] != "legal"
        else:
            self._forecast.hear_bound(seconds)
            self._wrong += facts.get("message") is not None

    def update(self, workers: int) -> None:
        """Show how far it is."""
        forecast = f"about {clock(self._forecast.left_s(workers))} left"
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
