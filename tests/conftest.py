"""Fixtures of the command line and of the benchmark's modules."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import stand_ins
from hypothesis import settings
from run_all_rows import BENCH, Load

import adr_opt
from adr_opt.common.processors import usable_cores
from adr_opt.ui.cli.entry import main


@dataclass(frozen=True)
class Outcome:
    """Outcome of a command-line call."""

    status: int
    out: str
    err: str


Cli = Callable[..., Outcome]

# What Hypothesis draws is the same in every run, too.
settings.register_profile("same", derandomize=True)
settings.load_profile("same")

LONG = {
    "test_all_rules",
    "test_best_known",
    "test_campaigns",
    "test_cli_interrupted",
    "test_export_thrust",
    "test_large_bound",
    "test_low_thrust_refined",
    "test_models",
    "test_registry",
    "test_serve_walk",
    "test_wheel",
}
"""Begun with: a file is for one process, and none should be left with one of these at the end."""


def pytest_xdist_auto_num_workers() -> int:
    """One process more than cores: browsers, commands and signals are waited for."""
    return usable_cores() + 1


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put tests that take long before all others."""
    items.sort(key=lambda item: item.path.stem not in LONG)


def refused(outcome: Outcome, *named: str) -> None:
    """One line on standard error that names what it should, nothing on standard output, exit 2.

    Where the machine is slow, the notice that it is compiling stands before it, and notes of values
    that look like slips of units.
    """
    assert outcome.status == 2, outcome
    assert outcome.out == ""
    before = ("compiling, once", ": note: ")
    lines = [line for line in outcome.err.splitlines() if not any(word in line for word in before)]
    assert len(lines) == 1, outcome.err
    for text in named:
        assert text in outcome.err


GIVE_BACK = pytest.StashKey[Callable[[], None]]()


@pytest.fixture
def cli(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cli:
    """Run the command line in this process, in an empty folder: a line of words, and more words."""
    monkeypatch.chdir(tmp_path)

    def call(line: str = "", *more: object) -> Outcome:
        capsys.readouterr()
        status = main([*line.split(), *map(str, more)])
        said = capsys.readouterr()
        return Outcome(status, said.out, said.err)

    return call


@pytest.fixture
def full_disk(request: pytest.FixtureRequest) -> Callable[[], None]:
    """To be called: from then on no file can have more than 1000 bytes, as on a full disk."""
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def give_back() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)

    request.node.stash[GIVE_BACK] = give_back
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Give back the disk before the result is said, which may go into a file."""
    try:
        return (yield)
    finally:
        item.stash.get(GIVE_BACK, lambda: None)()


@pytest.fixture
def at(tmp_path: Path) -> Iterator[Any]:
    """A desk of ``serve`` on a new project, with a client: :class:`serve_at.At`."""
    from serve_at import At

    made = At(tmp_path / "project")
    yield made
    made.close()


@pytest.fixture
def tiny_file(tmp_path: Path) -> Path:
    """The file of a tiny instance, in the folder where ``cli`` runs."""
    path = tmp_path / "tiny.json"
    path.write_text(adr_opt.generate("tiny", 0).to_json(), encoding="utf-8")
    return path


@pytest.fixture
def methods(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Methods that show how they were called, installed; returns the folder to import from."""
    return stand_ins.install(tmp_path, monkeypatch)


@pytest.fixture(scope="module")
def load() -> Iterator[Load]:
    """Import a module of the bench folder, which is no package."""
    pytest.importorskip("plotly")
    pytest.importorskip("matplotlib")
    sys.path.insert(0, str(BENCH))
    yield importlib.import_module
    sys.path.remove(str(BENCH))


@pytest.fixture
def imported(cli: Cli) -> Cli:
    """`import` of a catalogue of twelve, with more options."""
    from catalogue_files import as_csv, field

    Path("a.csv").write_text(as_csv(field(12)), encoding="utf-8")
    return lambda *more: cli("import a.csv --out out.json", *more)


@pytest.fixture
def no_network(monkeypatch: pytest.MonkeyPatch) -> None:
    """No network of all connections fits into memory."""
    monkeypatch.setattr("solvers.progress.proof_size.available_bytes", lambda: 0.0)
