"""``train``: train a policy."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ...common.errors import InputError, MissingExtra
from . import param
from .bars import busy_bar
from .output import emit_json, say
from .signals import INTERRUPTED

if TYPE_CHECKING:
    from rich.progress import Progress


@click.command("train", short_help="Train a policy for the planner ppo.")
@param.choice(
    "--config",
    ("policy", "published"),
    "The policy of the package, or the network and numbers of the published study.",
    default="policy",
    show_default=True,
)
@param.count("--batch", "N", "Decisions of one step of the optimiser.")
@param.number("--rate", "R", "Learning rate at first.")
@param.count("--rollout", "N", "Steps of each mission between two updates.")
@param.count("--steps", "N", "Environment steps, at least; whole rollouts are played.")
@param.word("--out", "DIR", "Folder of the run; resumed.", required=True)
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--jobs", type=int, default=1, show_default=True, help="Number of threads.")
@click.option(
    "--device",
    default="auto",
    show_default=True,
    help="Of PyTorch: auto for a GPU if there is one.",
)
@param.count(
    "--evaluate-every",
    "N",
    "Steps between evaluations on held-out fields.",
    default=200_000,
    show_default=True,
)
@param.number(
    "--checkpoint-every",
    "S",
    "Seconds between checkpoints.",
    name="checkpoint_s",
    default=60.0,
    show_default=True,
)
@param.as_json
@param.quiet
def command(
    config: str,
    batch: int | None,
    rate: float | None,
    rollout: int | None,
    steps: int | None,
    out: str,
    seed: int,
    jobs: int,
    device: str,
    evaluate_every: int,
    checkpoint_s: float,
    as_json: bool,
    quiet: bool,
) -> int:
    """Train a policy into DIR, from its last checkpoint if DIR holds one.

    Ctrl-C ends the training with a checkpoint and exit status 130, and a second one aborts; the
    same command resumes it.
    """
    try:
        from ...learning.training.configs import config_of
        from ...learning.training.trainer import train
    except ModuleNotFoundError as error:
        raise MissingExtra("train", str(error.name).partition(".")[0], "rl") from None

    chosen = config_of(config, steps=steps, batch=batch, rate=rate, rollout=rollout)
    for name, value, least, most in (
        ("--seed", seed, 0, 2**31 - 1),
        ("--jobs", jobs, 1, 1024),
        ("--evaluate-every", evaluate_every, 1, 10**12),
    ):
        if not least <= value <= most:
            raise InputError(f"{name} = {value}: must be between {least} and {most}")
    if not (checkpoint_s >= 0.0 and math.isfinite(checkpoint_s)):
        raise InputError(f"--checkpoint-every = {checkpoint_s:g}: must be seconds from 0 on")
    folder = Path(out)
    nearest = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not nearest.is_dir():
        raise InputError(f"{nearest}: is a file; give a folder")

    stopped = threading.Event()
    last: dict[str, float] = {}

    from .bars import wanted
    from .signals import signals_to

    with training_bar(wanted(as_json, quiet), quiet, chosen.steps) as bar:

        def interrupt() -> None:
            if not bar.began:  # there is nothing yet to keep
                raise KeyboardInterrupt
            stopped.set()

        def enough() -> bool:
            if stopped.is_set():
                bar.stop()
            return stopped.is_set()

        def report(done: int, means: Mapping[str, float]) -> None:
            last.update(means)
            bar.show(done, means)

        with signals_to(interrupt):
            train(
                chosen,
                folder,
                seed=seed,
                jobs=jobs,
                device=device,
                evaluate_every=evaluate_every,
                checkpoint_s=checkpoint_s,
                enough=enough,
                report=report,
            )
    if stopped.is_set() and not quiet:
        say(f"interrupted: {out} holds a checkpoint; the same command goes on from it")
    if as_json:
        emit_json({"out": out, "config": config, "seed": seed, "held": last})
    return INTERRUPTED if stopped.is_set() else 0


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
