"""``train``: train a policy."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping
from pathlib import Path

import click

from ...common.errors import InputError
from . import complete, take
from .output import emit_json, say
from .signals import INTERRUPTED


@click.command("train", short_help="Train a policy for the planner ppo.")
@take.word(
    "--config",
    "NAME",
    "set, set-transfer or published.",
    name="config",
    required=True,
    shell_complete=complete.trainings,
)
@take.count("--steps", "N", "Environment steps, at least; whole rollouts are played.")
@take.word("--out", "DIR", "Folder of the run; resumed.", required=True)
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--jobs", type=int, default=1, show_default=True, help="Number of threads.")
@click.option("--device", default="cpu", show_default=True, help="PyTorch device: cpu or cuda.")
@take.count(
    "--evaluate-every",
    "N",
    "Steps between evaluations on held-out fields.",
    default=200_000,
    show_default=True,
)
@take.number(
    "--checkpoint-every",
    "S",
    "Seconds between checkpoints.",
    name="checkpoint_s",
    default=60.0,
    show_default=True,
)
@take.as_json
@take.quiet
def command(
    config: str,
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
    from ...learning.trainer import get

    train = get(config)
    for name, value, least, most in (
        ("--steps", 1 if steps is None else steps, 1, 10**12),
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

    from .live import wanted
    from .signals import signals_to
    from .training_bar import training_bar

    with training_bar(wanted(as_json, quiet), quiet, steps) as bar:

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
                folder,
                steps=steps,
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
