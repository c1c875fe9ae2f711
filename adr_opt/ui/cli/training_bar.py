"""Progress of a training run, on a terminal or as lines."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

from .bars import busy_bar
from .output import say

if TYPE_CHECKING:
    from rich.progress import Progress

PREPARING = "preparing fields"


@contextmanager
def training_bar(live: bool, quiet: bool, steps: int | None) -> Iterator[TrainingBar]:
    """Show that fields are prepared, then finished steps and evaluations.

    Parameters
    ----------
    live : bool
        Draw a bar; otherwise every evaluation is a line.
    quiet : bool
        Say nothing at all.
    steps : int or None
        Where the bar ends, if it is known.
    """
    say(PREPARING, unless=quiet or live)
    with ExitStack() as bars:
        bars.enter_context(busy_bar(live, PREPARING))
        yield TrainingBar(bars, live, quiet, steps)


class TrainingBar:
    """The bar of :func:`training_bar`.

    Attributes
    ----------
    began : bool
        Whether fields are prepared, and steps are taken.
    """

    def __init__(self, bars: ExitStack, live: bool, quiet: bool, steps: int | None) -> None:
        self._bars, self._live, self._quiet, self._steps = bars, live, quiet, steps
        self._clock = _Clock()
        self._bar: Progress | None = None
        self._is_stopping = False
        self.began = False

    def show(self, done: int, means: Mapping[str, float]) -> None:
        """Receive the number of finished steps, and an evaluation if there is a new one."""
        if not self.began:
            self.began = True
            self._bars.close()
            self._bar = self._steps_bar() if self._live else None
        self._clock.begin(done)
        if self._bar is not None:
            more: dict[str, Any] = {"held": _text(means)} if means else {}
            task = self._bar.task_ids[0]
            self._bar.update(task, completed=done, rate=self._clock.rate(done), **more)
        elif means:
            rate = self._clock.rate(done)
            say(f"{done} steps, {rate}; visits on held fields: {_text(means)}", unless=self._quiet)

    def stop(self) -> None:
        """Say, once, that an interruption was heard."""
        if not self._is_stopping:
            self._is_stopping = True
            word = "interrupted: waiting for the checkpoint; interrupt again to abort"
            say(word, unless=self._quiet)

    def _steps_bar(self) -> Progress:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
        )

        columns = (
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeElapsedColumn(),
            TextColumn("{task.fields[held]}"),
        )
        bar = self._bars.enter_context(Progress(*columns, console=Console(stderr=True)))
        bar.add_task("train", total=self._steps, rate="", held="")
        return bar


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
