"""Ctrl-C is never lost: not while packages are imported, nor where Python or a library drops it."""

from __future__ import annotations

import ctypes
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli
from interruptible import CHILD
from seeds import first_of
from terminals import read_until

import adr_opt
from adr_opt.common import files

pytestmark = pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")

ABORTED = "adr-opt: aborted\n"


@pytest.fixture
def heard() -> Iterator[None]:
    """A process that hears Ctrl-C, which those of a script in the background do not."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupt() -> None:
    """Ctrl-C, in a function that has to do something for the interpreter to notice."""
    os.kill(os.getpid(), signal.SIGINT)
    for _ in range(10):
        time.sleep(0.001)


def in_a_callback() -> None:
    """As where a compiled kernel is loaded."""
    ctypes.CFUNCTYPE(None)(interrupt)()


def in_a_destructor() -> None:
    class Left:
        def __del__(self) -> None:
            interrupt()

    Left()


def cleared() -> None:
    with suppress(BaseException):
        interrupt()


def translated() -> None:
    """As where a module in C prints what it was interrupted with, and cannot be imported."""
    try:
        interrupt()
    except BaseException as error:
        sys.excepthook(type(error), error, error.__traceback__)
        raise ImportError("failed to import") from None


@pytest.mark.usefixtures("heard")
@pytest.mark.parametrize("swallow", [translated, in_a_callback, in_a_destructor, cleared])
def test_a_swallowed_interrupt_comes_again(
    cli: Cli, swallow: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever drops it, the verb ends soon, with 130 and a word, and with no traceback."""

    def read(path: object) -> str:
        swallow()
        for _ in range(6000):
            time.sleep(0.01)
        pytest.fail("it does not come again")

    monkeypatch.setattr(files, "read_text", read)
    outcome = cli("check", "a.json", "b.json")
    assert (outcome.status, outcome.out, outcome.err) == (130, "", ABORTED)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("heard")
def test_tidying_up_is_not_interrupted_again(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupt that is on its way is not raised again in what ends because of it."""
    tidied = []

    def read(path: object) -> str:
        try:
            interrupt()
        finally:
            for _ in range(50):
                time.sleep(0.01)
            tidied.append(path)
        return ""

    monkeypatch.setattr(files, "read_text", read)
    assert cli("check", "a.json", "b.json").status == 130
    assert len(tidied) == 1


AT_IMPORT = """
import os, signal, sys
class Finder:
    def find_spec(name, *more):
        if name == {name!r}:
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Finder)
"""


@pytest.mark.parametrize(
    "name", first_of(["click", "adr_opt.ui.cli.check", "numba", "pydantic", "llvmlite"], gate=2)
)
def test_interrupted_while_packages_are_imported(tiny_file: Path, name: str) -> None:
    """From the first import on it ends the process with 130 and a word."""
    ran = subprocess.run(
        [sys.executable, "-c", AT_IMPORT.format(name=name) + CHILD, "check", str(tiny_file), "no"],
        capture_output=True,
        text=True,
    )
    assert (ran.returncode, ran.stdout, ran.stderr) == (130, "", ABORTED)


def test_interrupted_at_the_end(tmp_path: Path) -> None:
    """While the interpreter ends there is no traceback either."""
    code = "import atexit, os, signal; atexit.register(os.kill, os.getpid(), signal.SIGINT); "
    ran = subprocess.run(
        [sys.executable, "-c", code + CHILD, "--version"], capture_output=True, text=True
    )
    assert (ran.returncode, ran.stderr) == (130, ABORTED)


def train(monkeypatch: pytest.MonkeyPatch, work: Callable[..., None]) -> list[str]:
    """Let a configuration do some work; returns the call."""
    monkeypatch.setattr("adr_opt.learning.training.trainer.train", work)
    return ["train", "--config", "policy", "--out", "run"]


@pytest.mark.usefixtures("heard")
def test_a_training_that_prepares_ends_at_once(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """There is nothing to keep yet: what is done is said, then Ctrl-C ends it with 130."""

    def work(*given: Any, **more: Any) -> None:
        interrupt()
        raise AssertionError

    outcome = cli(*train(monkeypatch, work))
    assert (outcome.status, outcome.out) == (130, "")
    assert outcome.err == "adr-opt: preparing fields\n" + ABORTED


@pytest.mark.usefixtures("heard")
def test_a_training_ends_with_a_checkpoint(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """Once it takes steps the first Ctrl-C asks for an end; the status is 130 all the same."""

    def work(*given: Any, enough: Callable[[], bool], report: Any, **more: Any) -> None:
        report(0, {})
        assert not enough()
        interrupt()
        assert enough()
        assert enough()

    outcome = cli(*train(monkeypatch, work))
    assert outcome.status == 130
    assert outcome.err.splitlines()[1:] == [
        "adr-opt: interrupted: waiting for the checkpoint; interrupt again to abort",
        "adr-opt: interrupted: run holds a checkpoint; the same command resumes from it",
    ]


TRAINER = """
import time
from adr_opt.learning.training import trainer
def work(*given, enough, report, **more):
    time.sleep(1.0)
    report(0, {})
    while not enough(): time.sleep(0.01)
    time.sleep(600.0)
trainer.train = work
"""


def test_a_second_interrupt_aborts_a_training(tmp_path: Path) -> None:
    """On a terminal something moves from the beginning, and the second Ctrl-C ends it."""
    ours, theirs = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", TRAINER + CHILD, "train", "--config", "policy", "--out", "run"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=theirs,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "80"},
    )
    os.close(theirs)
    said = read_until(ours, b"preparing fields")
    said += read_until(ours, b"steps")
    process.send_signal(signal.SIGINT)
    said += read_until(ours, b"again to abort")
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=300.0) == 130
    said += read_until(ours)
    os.close(ours)
    assert b"aborted" in said
    assert b"Traceback" not in said


VERBS = {
    "check": ["tiny.json", "plan.json"],
    "export": ["tiny.json", "plan.json", "--format", "oem", "--out", "o.oem"],
    "matrix": ["tiny.json", "--at", "0", "--out", "m.npz"],
    "report": ["tiny.json", "plan.json", "--out", "r.html"],
    "refine": ["tiny.json", "plan.json", "--out", "r.json"],
    "doctor": [],
}


@pytest.mark.slow
def test_interrupted_at_any_moment(tmp_path: Path) -> None:
    """Of many interrupts, each ends its verb with 130, or comes when that is done."""
    instance = adr_opt.generate("tiny", 0)
    instance.save(tmp_path / "tiny.json")
    plan = adr_opt.solve(instance, method="greedy").plan
    assert plan is not None
    plan.save(tmp_path / "plan.json")
    rng = random.Random(0)
    for _ in range(60):
        verb = rng.choice(list(VERBS))
        process = subprocess.Popen(
            [sys.executable, "-u", "-c", f"print('begun'); {CHILD}", verb, *VERBS[verb]],
            cwd=tmp_path,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(rng.uniform(0.05, 3.0))
        ended = process.poll()
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=120.0)
        # A shell says 130 as well where Python is killed by the signal, as at its very end.
        if ended is None:
            assert process.returncode in (130, -signal.SIGINT) or (
                verb == "refine" and "interrupted" in err
            ), (verb, process.returncode, err)
        assert "Traceback" not in err
