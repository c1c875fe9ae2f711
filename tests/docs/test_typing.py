"""What type checkers see of the package: it is found once it is installed, and its calls check."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import textwrap
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("mypy")

ROOT = Path(__file__).parents[2]


def checked(code: str, folder: Path, *options: str, place: Path) -> list[str]:
    """What mypy says of some code, called at a place; a line for each mistake."""
    mine = folder / "mine.py"
    mine.write_text(textwrap.dedent(code), encoding="utf-8")
    ran = subprocess.run(
        [sys.executable, "-m", "mypy", *options, str(mine)],
        cwd=place,
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert ran.returncode in (0, 1), ran.stderr
    return [line for line in ran.stdout.splitlines() if "mine.py" in line]


@pytest.mark.slow
def test_an_editable_install_is_found(tmp_path: Path) -> None:
    """`pip install -e .` makes a path that mypy follows, so that wrong calls are found."""
    pytest.importorskip("setuptools")
    project = tmp_path / "project"
    for package in ("adr_opt", "solvers"):
        shutil.copytree(
            ROOT / package, project / package, ignore=shutil.ignore_patterns("__pycache__")
        )
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, project)
    # What pip calls; without it nothing has to be fetched.
    subprocess.run(
        [
            sys.executable,
            "-c",
            f"from setuptools.build_meta import build_editable; build_editable({str(tmp_path)!r})",
        ],
        cwd=project,
        check=True,
        capture_output=True,
        timeout=120,
    )
    (wheel,) = tmp_path.glob("*.whl")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "venv"], check=True)
    (site,) = (tmp_path / "venv" / "lib").glob("python*/site-packages")
    zipfile.ZipFile(wheel).extractall(site)
    said = checked(
        """
        import adr_opt

        instance: adr_opt.Instance = adr_opt.generate("tiny", 0)
        wrong: int = adr_opt.solve(instance)
        """,
        tmp_path,
        "--python-executable",
        str(tmp_path / "venv" / "bin" / "python"),
        "--follow-imports",
        "silent",
        place=tmp_path,
    )
    (line,) = said
    assert 'error: Incompatible types in assignment (expression has type "Result"' in line


def test_steps_of_the_environment_check(tmp_path: Path) -> None:
    """`env.step` takes an int as well as what NumPy has for it, and no text.

    In the folder of the project, whose own check leaves what mypy knows of the rest.
    """
    pytest.importorskip("gymnasium")
    said = checked(
        """
        import numpy as np

        from adr_opt.learning.environment import MissionEnv

        env = MissionEnv()
        observation, info = env.reset(seed=0)
        action: int = 3
        observation, reward, terminated, truncated, info = env.step(action)
        total: float = reward
        env.step(np.int64(3))
        env.step(env.action_space.sample())
        env.step("3")
        """,
        tmp_path,
        place=ROOT,
    )
    (line,) = said
    assert "mine.py:13: error: " in line
    assert '"step"' in line
