"""Progress of a training run, on a terminal or as lines."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from .output import say

Show = Callable[[int, Mapping[str, float]], None]


@contextmanager
def training_bar(live: bool, quiet: bool, steps: int | None) -> Iterator[Show]:
    """Yield a callback for finished steps and evaluations.

    Parameters
    ----------
    live : bool
        Draw a bar; otherwise every evaluation is a line.
    quiet : bool
        Say nothing at all.
    steps : int or None
        Where the bar ends, if it is known.
    """
    clock = _Clock()
    if quiet:
        yield lambda done, means: None
    elif not live:
        yield (
            lambda done, means: (
                say(f"{done} steps, {clock.rate(done)}; visits on held fields: {_text(means)}")
                if means
                else clock.begin(done)
            )
        )
    else:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
        )

        columns = (
            BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"),
            TimeElapsedColumn(), TextColumn("{task.fields[held]}"),
        )  # fmt: skip
        with Progress(*columns, console=Console(stderr=True)) as bar:
            task = bar.add_task("train", total=steps, rate="", held="")

            def show(done: int, means: Mapping[str, float]) -> None:
                clock.begin(done)
                bar.update(task, completed=done, rate=clock.rate(done))
                if means:
                    bar.update(task, held=_text(means))

            yield show


class _Clock:
    """Steps per second since the first report, without those before a resumption."""

    def __init__(self) -> None:
        self._first: tuple[int, float] | None = None

    def begin(self, done: int) -> None:
        if self._first is None:
            self._first = (done, time.monotonic())

    def rate(self, done: int) -> str:
        self.begin(done)
        assert self._first is not None
        steps, began = self._first
        return f"{(done - steps) / max(time.monotonic() - began, 1e-9):.0f} steps/s"


def _text(means: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:.2f}" for name, value in means.items())
