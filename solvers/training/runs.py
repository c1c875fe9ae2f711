"""The folder of a training run, and its consistency."""

from __future__ import annotations

import csv
import io
import json
import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from adr_opt.common.errors import InputError
from adr_opt.common.files import write_text
from adr_opt.common.json_text import loaded
from adr_opt.common.processors import usable_cores

from .checkpoints import read_state
from .configs import Config

PACKAGES = ("adr-opt", "numpy", "numba", "torch", "stable-baselines3", "sb3-contrib", "gymnasium")


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Create a folder, and lock it against other training runs until this one ends or is killed.

    Raises
    ------
    InputError
        Another training runs in it, or it cannot be made or written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / "train.lock", timeout=0).acquire()
    except Timeout:
        raise InputError(
            f"{folder}: another training runs in it; wait for its end, or give another folder"
        ) from None
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be made or written ({error.strerror}); give another folder"
        ) from None
    with lock:
        yield


class TrainingRun:
    """A folder with ``run.json``, checkpoint, best weights and the curve of evaluations.

    Every file is replaced as a whole, so a training that is killed loses what came after its last
    checkpoint and nothing else.

    Parameters
    ----------
    folder : Path
        See :func:`locked`.
    config : Config
    seed : int

    Raises
    ------
    InputError
        The folder holds a training of another configuration or seed, or cannot be written.
    """

    def __init__(self, folder: Path, config: Config, seed: int) -> None:
        self.folder = folder
        description = loaded(json.dumps({"config": asdict(config), "seed": seed}))
        path = folder / "run.json"
        if path.exists():
            self.facts = self._known(path, description)
        else:
            description["versions"] = {name: version(name) for name in PACKAGES}
            description["machine"] = f"{platform.platform()}, {usable_cores()} cores"
            description["began"] = datetime.now(UTC).isoformat(timespec="seconds")
            self.facts = description
            write_text(path, json.dumps(description, indent=1))

    def _known(self, path: Path, wanted: Mapping[str, Any]) -> dict[str, Any]:
        try:
            known: dict[str, Any] = loaded(path.read_text(encoding="utf-8"))
            # The number of steps may change: a training can be prolonged.
            known["config"]["steps"] = wanted["config"]["steps"]
            same = all(known[key] == wanted[key] for key in ("config", "seed"))
            known["versions"]
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            raise InputError(f"{path}: not the file of a training; give another folder") from None
        if not same:
            differing = [
                name
                for name, value in wanted["config"].items()
                if known["config"].get(name) != value
            ] or ["seed"]
            raise InputError(
                f"{self.folder} holds a training with another {', '.join(differing)}; give "
                "another folder, or the same call to go on with it"
            )
        return known

    @property
    def checkpoint(self) -> Path:
        """The last checkpoint, for resuming only; see :mod:`.checkpoints`."""
        return self.folder / "checkpoint.safetensors"

    @property
    def state(self) -> dict[str, Any]:
        """Steps, seconds and best evaluation at the last checkpoint; empty if there is none."""
        old = self.folder / "checkpoint.zip"
        if self.checkpoint.exists():
            return read_state(self.checkpoint)
        if old.exists():
            raise InputError(
                f"{old}: a checkpoint that could run code, so it is no longer read; give another "
                "folder, or remove it to begin anew"
            )
        return {}

    @property
    def last(self) -> Path:
        """The policy at the end of the training."""
        return self.folder / "last.onnx"

    def last_evaluation(self) -> dict[str, float]:
        """Last row of the curve; empty if there is none."""
        try:
            with (self.folder / "evaluations.csv").open(newline="", encoding="utf-8") as file:
                row = list(csv.DictReader(file))[-1]
            return {name: float(row[name]) for name in row if name not in ("steps", "seconds")}
        except (OSError, ValueError, TypeError, IndexError, csv.Error):
            return {}

    def add_to_curve(self, steps: int, seconds: float, means: Mapping[str, float]) -> None:
        """Append a row to ``evaluations.csv``; rows after a resumed checkpoint are dropped."""
        path = self.folder / "evaluations.csv"
        rows: list[list[str]] = []
        if path.exists():
            try:
                with path.open(newline="", encoding="utf-8") as file:
                    rows = [row for row in list(csv.reader(file))[1:] if int(row[0]) < steps]
            except (OSError, ValueError, IndexError, csv.Error):
                raise InputError(f"{path}: not the curve of a training; remove it") from None
        rows.append([str(steps), f"{seconds:.1f}", *(f"{value:.4f}" for value in means.values())])
        text = io.StringIO()
        csv.writer(text).writerows([["steps", "seconds", *means], *rows])
        write_text(path, text.getvalue())
