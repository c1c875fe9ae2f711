"""The folder of a training: what it holds, and how it is kept whole."""

from __future__ import annotations

import csv
import json
import os
import platform
from collections.abc import Callable, Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from adr_opt.errors import InputError

from .configs import Config

PACKAGES = ("adr-opt", "numpy", "numba", "torch", "stable-baselines3", "sb3-contrib", "gymnasium")


class Run:
    """A folder with ``run.json``, checkpoint, best weights and the curve of evaluations.

    Every file is replaced as a whole, so a training that is killed loses what came after its last
    checkpoint and nothing else.

    Parameters
    ----------
    folder : Path
        Made if it does not exist.
    config : Config
    seed : int

    Raises
    ------
    InputError
        The folder holds a training of another configuration or seed, or cannot be written.
    """

    def __init__(self, folder: Path, config: Config, seed: int) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot be made ({error.strerror})") from None
        description = json.loads(json.dumps({"config": asdict(config), "seed": seed}))
        path = folder / "run.json"
        if path.exists():
            self.facts = self._known(path, description)
        else:
            description["versions"] = {name: version(name) for name in PACKAGES}
            description["machine"] = f"{platform.platform()}, {os.cpu_count()} cores"
            description["began"] = datetime.now(UTC).isoformat(timespec="seconds")
            self.facts = description
            self.replace(
                "run.json", lambda part: part.write_text(json.dumps(description, indent=1))
            )

    def _known(self, path: Path, wanted: Mapping[str, Any]) -> dict[str, Any]:
        try:
            known: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            # The number of steps may change: a training can be prolonged.
            known["config"]["steps"] = wanted["config"]["steps"]
            same = all(known[key] == wanted[key] for key in ("config", "seed"))
        except (OSError, ValueError, KeyError, TypeError):
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

    def replace(self, name: str, write: Callable[[Path], Any]) -> None:
        """Write a file of the folder, whole or not at all."""
        target = self.folder / name
        part = target.with_name(f"{target.stem}.part{target.suffix}")
        write(part)
        os.replace(part, target)

    @property
    def checkpoint(self) -> Path:
        """The last checkpoint, a file of Stable-Baselines3; its own format, for resuming only."""
        return self.folder / "checkpoint.zip"

    @property
    def state(self) -> dict[str, Any]:
        """Steps, seconds and best evaluation at the last checkpoint; empty if there is none."""
        path = self.folder / "state.json"
        if not (path.exists() and self.checkpoint.exists()):
            return {}
        try:
            state: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            if int(state["steps"]) < 0 or float(state["seconds"]) < 0.0:
                raise ValueError
            float(state["best"])
        except (OSError, ValueError, KeyError, TypeError):
            raise InputError(
                f"{path}: not the state of a training; remove it to begin anew"
            ) from None
        return state

    @property
    def last(self) -> Path:
        """The policy at the end of the training."""
        return self.folder / "last.onnx"

    def last_evaluation(self) -> dict[str, float]:
        """The last row of the curve; empty if there is none."""
        try:
            with (self.folder / "evaluations.csv").open(newline="", encoding="utf-8") as file:
                row = list(csv.DictReader(file))[-1]
            return {name: float(row[name]) for name in row if name not in ("steps", "seconds")}
        except (OSError, ValueError, IndexError):
            return {}

    def add_to_curve(self, steps: int, seconds: float, means: Mapping[str, float]) -> None:
        """One row more in ``evaluations.csv``; rows after a resumed checkpoint are dropped."""
        path = self.folder / "evaluations.csv"
        rows: list[list[str]] = []
        if path.exists():
            with path.open(newline="", encoding="utf-8") as file:
                rows = [row for row in list(csv.reader(file))[1:] if int(row[0]) < steps]
        rows.append([str(steps), f"{seconds:.1f}", *(f"{value:.4f}" for value in means.values())])

        def write(part: Path) -> None:
            with part.open("w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([["steps", "seconds", *means], *rows])

        self.replace("evaluations.csv", write)
