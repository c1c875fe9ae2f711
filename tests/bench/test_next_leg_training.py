"""The training of the choice of the next leg, and the comparison of what came of it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from adr_opt.learning.next_leg.scorer import load_scorer

BENCH = Path(__file__).parents[2] / "bench"


def run(script: str, *words: object) -> str:
    command = [sys.executable, str(BENCH / script), *map(str, words)]
    path = os.pathsep.join([str(BENCH.parent), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=True
    )
    return done.stdout


@pytest.mark.slow
def test_a_training_is_repeated_by_its_seed(tmp_path: Path) -> None:
    """Two short trainings of one seed give the same weights, which planners of legs can read."""
    found = []
    for name in ("one.npz", "other.npz"):
        words = ("--rounds", 30, 30, "--epochs", 2, "--held", 1, "--out", tmp_path / name)
        assert run("train_next_leg.py", "--seed", 3, *words).count("\n") == 4
        found.append(load_scorer(tmp_path / name))
    assert found[0].facts == found[1].facts
    assert found[0].facts["seed"] == 3
    for one, other in zip(found[0].layers, found[1].layers, strict=True):
        assert np.array_equal(one, other)


@pytest.mark.slow
@pytest.mark.parametrize("what", ["known", "uncertain"])
def test_the_frontier_is_told(what: str) -> None:
    """Every method has a row, and what is held is said for both times."""
    told = run("frontier.py", what, "--targets", 20, "--fields", 3, "--widths", 1)
    for method in ("learned", "guarded greedy", "beam of 1"):
        assert f"| {method} | 3 |" in told
    assert "frontier of quality against time per decision" in told
    assert "frontier of quality against total time" in told
