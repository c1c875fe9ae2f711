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
from subprocess import CalledProcessError, run
from typing import Any

from filelock import FileLock, Timeout

from ...common.errors import InputError
from ...common.files import write_text
from ...common.json_text import loaded
from ...common.processors import usable_cores
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
        description = _described(config, seed)
        path = folder / "run.json"
        if path.exists():
            self.facts = self._known(path, description)
        else:
            description["versions"] = {name: version(name) for name in PACKAGES}
            description["commit"] = _commit()
            description["machine"] = f"{platform.platform()}, {usable_cores()} cores"
            description["began"] = datetime.now(UTC).isoformat(timespec="seconds")
            self.facts = description
            self._write()

    def _write(self) -> None:
        write_text(self.folder / "run.json", json.dumps(self.facts, indent=1))

    def begin_with(self, untrained: Mapping[str, float]) -> None:
        """Note mean visits from before an imitation, of which the curve knows nothing."""
        self.facts["untrained"] = dict(untrained)
        self._write()

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
        return read_state(self.checkpoint) if self.checkpoint.exists() else {}

    def last_evaluation(self) -> dict[str, float]:
        """Last row of the curve; empty if there is none."""
        found = self._curve()
        return {} if not found else {name: found[-1][name] for name in list(found[-1])[2:]}

    def _curve(self) -> list[dict[str, float]]:
        """Rows of ``evaluations.csv``.

        Raises
        ------
        InputError
            It is no curve.
        """
        path = self.folder / "evaluations.csv"
        if not path.exists():
            return []
        try:
            with path.open(newline="", encoding="utf-8") as file:
                return [
                    {name: float(of) for name, of in row.items()} for row in csv.DictReader(file)
                ]
        except (OSError, ValueError, TypeError, AttributeError, csv.Error):
            raise InputError(f"{path}: not the curve of a training; remove it") from None

    def card(self, steps: int) -> dict[str, Any]:
        """What a policy's file says of how it came about: see :class:`..policy.Policy`."""
        rows = self._curve()
        before, ends = self.facts.get("untrained"), dict[str, Mapping[str, float]]()
        if rows:
            begun = (
                {"untrained": before, "imitating": rows[0]} if before else {"untrained": rows[0]}
            )
            ends = {**begun, "trained": rows[-1]}
        families = list(rows[0])[2:] if rows else []
        return {
            "name": self.facts["config"]["name"],
            "dynamics": "two-body",
            "kinds": list(self.facts["config"]["kinds"]),
            "imitated": self.facts["config"]["imitated"],
            "steps": steps,
            **{name: self.facts[name] for name in ("seed", "commit", "versions", "began")},
            "curve": [list(row.values()) for row in rows],
            "families": {
                family: {name: row[family] for name, row in ends.items()} for family in families
            },
        }

    def add_to_curve(self, steps: int, seconds: float, means: Mapping[str, float]) -> None:
        """Append a row to ``evaluations.csv``; rows after a resumed checkpoint are dropped."""
        rows = [row for row in self._curve() if row["steps"] < steps]
        rows.append({"steps": steps, "seconds": round(seconds, 1), **means})
        text = io.StringIO()
        writer = csv.DictWriter(text, list(rows[-1]))
        writer.writeheader()
        writer.writerows(rows)
        write_text(self.folder / "evaluations.csv", text.getvalue())


def _described(config: Config, seed: int) -> dict[str, Any]:
    """A training as JSON."""
    text = json.dumps(
        {"config": asdict(config), "seed": seed}, default=lambda of: of.model_dump(mode="json")
    )
    found: dict[str, Any] = loaded(text)
    return found


def _commit() -> str | None:
    """Commit of the code, if it lies in a clone."""
    here = Path(__file__).parent
    try:
        found = run(["git", "rev-parse", "HEAD"], cwd=here, capture_output=True, check=True)
    except (OSError, CalledProcessError):
        return None
    return found.stdout.decode().strip()
