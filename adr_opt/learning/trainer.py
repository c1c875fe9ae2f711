"""Interface and look-up of training configurations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.metadata import entry_points
from pathlib import Path
from typing import Protocol

from ..common.errors import InputError
from ..common.packages import load

TRAINERS = "adr_opt.trainers"
"""Entry-point group; a package that declares one is listed by ``train --config``."""

Report = Callable[[int, Mapping[str, float]], None]
"""Callback with the number of steps done, and the last evaluation if there is a new one."""


class Trainer(Protocol):
    """A training configuration.

    Trains into a folder until a number of environment steps is reached, from the folder's last
    checkpoint if it has one.
    """

    def __call__(  # noqa: PLR0913
        self,
        folder: Path,
        *,
        steps: int | None,
        seed: int,
        jobs: int,
        device: str,
        evaluate_every: int,
        checkpoint_s: float,
        enough: Callable[[], bool],
        report: Report,
    ) -> None:
        """Train.

        Parameters
        ----------
        folder : Path
            Made if it does not exist.
        steps : int or None
            Of the whole training; the configuration's own number if None.
        seed, jobs : int
            ``jobs``: threads.
        device : str
            Of PyTorch: "cpu", "cuda".
        evaluate_every : int
            Steps between evaluations on held fields.
        checkpoint_s : float
            Time between checkpoints [s].
        enough : callable
            Asked after every step; True ends the training with a checkpoint.
        report : callable

        Raises
        ------
        InputError
            The folder holds another training, or a parameter is out of range.
        MissingExtra
            A package is not installed.
        """
        ...


def names() -> tuple[str, ...]:
    """Names of the installed configurations, sorted; nothing is imported."""
    return tuple(sorted(entry.name for entry in entry_points(group=TRAINERS)))


def get(name: str) -> Trainer:
    """The configuration with a name.

    Raises
    ------
    InputError
        There is none of that name; the sentence lists those there are.
    """
    for entry in entry_points(group=TRAINERS):
        if entry.name == name:
            trainer: Trainer = load(entry)
            return trainer
    known = ", ".join(names()) or "none is installed"
    raise InputError(f"config {name!r} is unknown; use one of: {known}")
