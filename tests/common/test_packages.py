"""Packages and cores: foreign packages are noticed, and cores are counted on every system."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from catalogue_files import as_csv, field
from conftest import Cli

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.packages import HIDEABLE, foreign_package
from adr_opt.common.processors import usable_cores

ROOT = Path(__file__).parents[2]


def called(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """`python -m adr_opt` in a folder, which Python looks in first."""
    return subprocess.run(
        [sys.executable, "-m", "adr_opt", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )


@pytest.mark.parametrize(
    ("form", "verb"),
    [
        ("a module", ("solve", "tiny.json")),
        ("a package", ("matrix", "tiny.json", "--out", "tiny.lp")),
    ],
)
def test_a_foreign_package_is_one_sentence(
    tiny_file: Path, form: str, verb: tuple[str, ...]
) -> None:
    """Every verb that needs our package says which one is in its place, and runs none of it."""
    program = "raise SystemExit('run')\n"
    if form == "a module":
        (place := tiny_file.parent / f"{HIDEABLE}.py").write_text(program)
    else:
        (place := tiny_file.parent / HIDEABLE).mkdir()
        (place / "__init__.py").write_text(program)
    done = called(tiny_file.parent, *verb)
    assert done.returncode == 2
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert f"another package named 'solvers' hides the one of adr-opt: {place}; rename" in line


def test_a_folder_of_the_name_is_no_package(tmp_path: Path) -> None:
    """Python finds ours behind a folder without code, and so do we."""
    (tmp_path / HIDEABLE).mkdir()
    done = called(tmp_path, "methods", "greedy")
    assert (done.returncode, done.stderr) == (0, "")
    assert "cannot be imported" not in done.stdout


def test_a_module_made_by_a_program_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A module without a place, put where imports look first, hides ours as well."""
    assert foreign_package() is None
    monkeypatch.setitem(sys.modules, HIDEABLE, ModuleType(HIDEABLE))
    with pytest.raises(InputError, match=r"^'greedy' cannot be imported: a module named 'solvers'"):
        adr_opt.solve(adr_opt.generate("tiny", 0), "greedy")


def test_a_missing_package_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where ours is gone, the sentence says from where."""
    monkeypatch.setattr("adr_opt.common.packages.find_spec", lambda name: None)
    assert str(ROOT) in str(foreign_package())


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """A system that does not tell to which cores a process is bound."""
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    return monkeypatch


def test_there_is_a_core_wherever_nothing_is_told(elsewhere: pytest.MonkeyPatch) -> None:
    """Without a set of cores it is the number of the machine, and 1 if that is unknown."""
    elsewhere.setattr(os, "cpu_count", lambda: 7)
    assert usable_cores() == 7
    elsewhere.setattr(os, "cpu_count", lambda: None)
    assert usable_cores() == 1


def test_cores_are_those_that_the_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that is bound to some cores uses no others."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {3, 5}, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    assert usable_cores() == 2


def test_verbs_run_where_no_cores_are_told(cli: Cli, elsewhere: pytest.MonkeyPatch) -> None:
    """`worth` and `scenario` count cores, and run on macOS and Windows, too."""
    Path("a.csv").write_text(as_csv(field(12)), encoding="utf-8")
    worth = cli("worth", "a.csv", "--out", "p.csv", "--candidates", 4, "--quiet")
    assert worth.status == 0, worth
    scenario = cli("scenario", "a.csv", "--years", 2, "--seeds", 1, "--out", "o.csv", "--quiet")
    assert scenario.status == 0, scenario
