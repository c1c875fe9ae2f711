"""``train``: train a policy."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ...common.errors import InputError, MissingExtra
from . import param
from .output import emit_json, say
from .signals import INTERRUPTED

if TYPE_CHECKING:
    from .bars import Show


PREPARING = "preparing fields"


@click.command("train", short_help="Train a policy for the planner ppo.")
@param.choice(
    "--config",
    ("policy", "published"),
    "Network and settings: those of the package's policy, or those of the published study.",
    default="policy",
    show_default=True,
)
@param.word(
    "--kinds",
    "KIND,…",
    "Missions to train on, each kind as often as the others: varied (nominal, reduced-time, "
    "reduced-fuel and others like them), these three alone, campaign, cloud.",
)
@param.count("--batch", "N", "Decisions per step of the optimiser.")
@param.number("--rate", "R", "Initial learning rate.")
@param.count("--rollout", "N", "Steps of each mission between two updates of the network.")
@param.count("--steps", "N", "Least number of environment steps; the last rollout is completed.")
@param.count(
    "--imitate", "N", "Number of fields whose plans by beams are imitated first.", name="imitated"
)
@param.word("--out", "DIR", "Folder of the run; a run in it is resumed.", required=True)
@param.seeded("Seed of the draws.")
@click.option("--jobs", type=int, default=1, show_default=True, help="Number of threads.")
@click.option(
    "--device",
    default="auto",
    show_default=True,
    help="Device of PyTorch; auto takes a GPU if there is one.",
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
@param.spoken
def command(
    config: str,
    kinds: str | None,
    batch: int | None,
    rate: float | None,
    rollout: int | None,
    steps: int | None,
    imitated: int | None,
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

    chosen = config_of(
        config, kinds, steps=steps, batch=batch, rate=rate, rollout=rollout, imitated=imitated
    )
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

    from .bars import busy_bar, counting_bar, wanted
    from .signals import signals_to

    stopped, live = threading.Event(), wanted(as_json, quiet)
    last: dict[str, float] = {}
    begun: list[tuple[int, float, Show]] = []
    heard: list[str] = []
    say(PREPARING, unless=quiet or live)
    with ExitStack() as bars:
        bars.enter_context(busy_bar(live, PREPARING))

        def interrupt() -> None:
            if not begun:  # there is nothing yet to keep
                raise KeyboardInterrupt
            stopped.set()

        def enough() -> bool:
            if stopped.is_set() and not heard:
                heard.append("interrupted: waiting for the checkpoint; interrupt again to abort")
                say(heard[0], unless=quiet)
            return stopped.is_set()

        def report(done: int, means: Mapping[str, float]) -> None:
            if not begun:
                bars.close()
                show = bars.enter_context(counting_bar(live, "steps"))
                begun.append((done, time.monotonic(), show))
            first, since, show = begun[0]
            show(done, chosen.steps)
            last.update(means)
            if means:
                rate = (done - first) / max(time.monotonic() - since, 1e-9)
                held = ", ".join(f"{name} {value:.2f}" for name, value in means.items())
                said = f"{done} steps, {rate:.0f} steps/s; visits on held fields: {held}"
                say(said, unless=quiet)

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
        say(f"interrupted: {out} holds a checkpoint; the same command resumes from it")
    if as_json:
        emit_json({"out": out, "config": config, "seed": seed, "held": last})
    return INTERRUPTED if stopped.is_set() else 0
