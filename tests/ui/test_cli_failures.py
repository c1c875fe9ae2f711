"""Internal errors: exit status 3 and one sentence, with the traceback on request alone."""

from __future__ import annotations

import errno
import importlib
import pickle
import re
import subprocess
import sys
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli, Outcome

import adr_opt
from adr_opt.common.errors import InputError, MissingExtra, failure
from adr_opt.ui.cli.entry import VERBS

READ, CATALOGUE = "adr_opt.common.files.read_text", "adr_opt.sources.catalogue.read"

WORK = {
    "generate": (["tiny", "--out", "i.json"], "adr_opt.sources.generator.generate"),
    "worth": (["cloud.tle", "--out", "p.csv"], CATALOGUE),
    "import": (["cloud.tle", "--out", "i.json"], CATALOGUE),
    "solve": (["tiny.json", "--method", "greedy"], "solvers.planners.greedy.greedy"),
    "bound": (["tiny.json"], "adr_opt.run.front.run"),
    "windows": (["tiny.json", "--light"], READ),
    "check": (["tiny.json", "plan.json"], READ),
    "verify": (["tiny.json", "certificate.json"], READ),
    "price": (["tiny.json", "debris-001"], READ),
    "compare": (["tiny.json", "plan.json", "plan.json"], READ),
    "tradeoff": (["tiny.json", "--vary", "delta-v=2000,3000"], READ),
    "replan": (["tiny.json", "plan.json", "--at", "0"], READ),
    "rehearse": (["tiny.json", "plan.json", "--uncertainty", "u.json"], READ),
    "scenario": (["cloud.tle"], CATALOGUE),
    "fly": (["tiny.json", "plan.json"], READ),
    "refine": (["tiny.json", "plan.json", "--out", "r.json"], READ),
    "screen": (["tiny.json", "r.json", "cloud.tle"], READ),
    "dispose": (["tiny.json", "plan.json"], READ),
    "matrix": (["tiny.json", "--at", "0", "--out", "m.npz"], READ),
    "export": (["tiny.json", "plan.json", "--format", "oem", "--out", "o.oem"], READ),
    "report": (["tiny.json", "plan.json", "--out", "r.html"], READ),
    "serve": (["tiny.json", "--no-open"], READ),
    "train": (["--out", "run"], "adr_opt.learning.training.configs.config_of"),
    "methods": ([], "adr_opt.run.methods.names"),
    "warm-up": (["greedy", "--quiet"], "adr_opt.ui.cli.warm_up.compile_for"),
    "doctor": ([], "adr_opt.run.installation.examine"),
    "schema": (["plan"], "json.dumps"),
}
"""For each verb the rest of a call, and a function that it comes to."""


def raising(error: BaseException) -> Any:
    """A function that raises."""

    def fail(*given: object, **named: object) -> None:
        raise error

    return fail


def failed(outcome: Outcome, *named: str) -> None:
    """Exit status 3, and one line on standard error with some words."""
    assert outcome.status == 3, outcome
    (line,) = [each for each in outcome.err.splitlines() if "compiling, once" not in each]
    assert line.startswith("adr-opt: ")
    for word in named:
        assert word in line


def break_verb(verb: str, error: BaseException, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Let the work of a verb raise; returns the call."""
    Path("tiny.json").write_text(adr_opt.generate("tiny", 0).to_json())
    more, function = WORK[verb]
    module, name = function.rsplit(".", 1)
    monkeypatch.setattr(importlib.import_module(module), name, raising(error))
    return [verb, *more]


def test_every_verb_is_tried() -> None:
    """The table of calls has all verbs."""
    assert WORK.keys() == set(VERBS)


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ZeroDivisionError("division\nby zero"), "internal error, ZeroDivisionError: division by"),
        (MemoryError("Unable to allocate 115. GiB"), "memory has run out (Unable to allocate 115"),
    ],
)
def test_an_internal_error_is_one_sentence(
    cli: Cli, verb: str, error: Exception, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever a verb stumbles over, the status is 3, and there is a traceback with --debug."""
    call = break_verb(verb, error, monkeypatch)
    failed(cli(*call), said, "--debug prints the traceback")
    for words in (["--debug", *call], [*call, "--debug"]):
        outcome = cli(*words)
        assert outcome.status == 3
        assert "Traceback (most recent call last)" in outcome.err
        assert "in fail\n" in outcome.err
        assert said in outcome.err.splitlines()[-1]


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (MemoryError(), "memory has run out; end"),
        (OSError(errno.ENOMEM, "Cannot allocate memory"), "memory has run out ("),
        (ImportError("no such symbol", name="numba"), "numba cannot be imported (no such symbol)"),
        (ModuleNotFoundError("No module named 'scipy'", name="scipy"), "'adr-opt doctor' says"),
        (BrokenProcessPool("a child"), "fewer --jobs"),
        (RecursionError("x" * 5000), "internal error, RecursionError: xxx"),
        (KeyError(), "internal error, KeyError"),
    ],
)
def test_each_kind_has_its_sentence(
    cli: Cli, error: Exception, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Memory, packages and processes are named as such, and nothing is longer than a few lines."""
    outcome = cli(*break_verb("check", error, monkeypatch))
    failed(outcome, said)
    assert len(outcome.err) < 500
    assert failure(error) in outcome.err


def test_a_broken_module_of_a_verb_is_one_sentence(
    cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A package that is missing where a verb is imported is said, also before --debug is parsed."""
    monkeypatch.setitem(sys.modules, "adr_opt.ui.cli.check", None)
    failed(cli("check", "--help"), "adr_opt.ui.cli.check cannot be imported")
    assert "Traceback" in cli("check", "--help", "--debug").err


def test_without_click_there_is_a_sentence() -> None:
    """What the command line itself needs is named where it is missing."""
    code = "import sys; sys.modules['click'] = None; from adr_opt.__main__ import main; "
    ran = subprocess.run(
        [sys.executable, "-c", f"{code}sys.exit(main())"], capture_output=True, text=True
    )
    assert ran.returncode == 3
    assert re.fullmatch(r"adr-opt: click cannot be imported .*\n", ran.stderr)


def test_wrong_input_is_no_internal_error(cli: Cli) -> None:
    """With --debug, too, it has its sentence and its status alone."""
    for words in (["--debug", "check", "no.json", "no.json"], ["methods", "no", "--debug"]):
        outcome = cli(*words)
        assert outcome.status == 2
        assert "Traceback" not in outcome.err


@pytest.mark.parametrize("error", [InputError("a: b"), MissingExtra("this", "that", "io")])
def test_errors_come_from_other_processes(error: InputError) -> None:
    """An error that a process hands over says what it said there."""
    again = pickle.loads(pickle.dumps(error))
    assert isinstance(again, InputError)
    assert str(again) == str(error)


@pytest.mark.parametrize(
    "call", ["solve tiny.json", "check tiny.json tiny.json", "matrix tiny.json --at 0 --out m.npz"]
)
def test_without_a_compiler_verbs_say_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str
) -> None:
    """What `doctor` says of NUMBA_DISABLE_JIT is said by whatever would need kernels."""
    adr_opt.generate("tiny", 0).save(tmp_path / "tiny.json")
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    ran = subprocess.run(
        [sys.executable, "-m", "adr_opt", *call.split()],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    said = "NUMBA_DISABLE_JIT is set, so that nothing is compiled; unset it"
    assert (ran.returncode, ran.stdout, ran.stderr) == (2, "", f"adr-opt: {said}\n")
