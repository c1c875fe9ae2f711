"""Signals and the live line: what `solve` does on a terminal, and when it is told to stop."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from interruptible import CHILD
from terminals import parts, read_until

import adr_opt
from adr_opt.plan.plan import load_plan
from adr_opt.ui.cli.bars import describe

PATIENCE_S = 300.0
"""After so long what is waited for does not come, however busy the machine."""


@pytest.mark.parametrize(
    ("incumbent", "bound", "expected"),
    [
        (float("-inf"), float("inf"), "2.5 s  no plan yet"),
        (3.0, float("inf"), "2.5 s  incumbent 3"),
        (3.0, 4.0, "2.5 s  incumbent 3  bound 4  gap 25.0%"),
        (float("-inf"), 4.0, "2.5 s  no plan yet  bound 4"),
    ],
)
def test_live_line_tells_what_is_known(incumbent: float, bound: float, expected: str) -> None:
    """The line has the elapsed time, and incumbent, bound and gap as far as there are any."""
    assert describe(2.5, incumbent, bound) == expected


def test_live_line_tells_how_much_of_the_timetable_is_built() -> None:
    """Before there is anything to plan with, the line says how far that is."""
    assert describe(2.5, -math.inf, math.inf, 0.374) == "2.5 s  timetable 37 %"


def begin(tiny_file: Path, method: str, *more: str, **how: Any) -> subprocess.Popen[str]:
    """Start `solve` as a process and wait until the planner runs."""
    process = subprocess.Popen(
        [
            sys.executable,
            "-c",
            CHILD,
            "solve",
            str(tiny_file),
            "--method",
            method,
            "--time-limit",
            "inf",
            *more,
        ],
        cwd=tiny_file.parent,
        text=True,
        stdout=subprocess.PIPE,
        **{"stderr": subprocess.PIPE, **how},
    )
    deadline = time.monotonic() + PATIENCE_S
    while not (tiny_file.parent / "started").exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return process


posix = pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")


@posix
@pytest.mark.usefixtures("methods")
@pytest.mark.parametrize(
    ("number", "more"),
    [(signal.SIGINT, []), pytest.param(signal.SIGTERM, ["--json"], marks=pytest.mark.slow)],
)
def test_first_signal_asks_for_the_best_plan(tiny_file: Path, number: int, more: list[str]) -> None:
    """Ctrl-C once: the best plan so far is printed and written, exit 0, a message on stderr.

    Into a pipe nothing is said but messages: there is no live line.
    """
    process = begin(tiny_file, "patient", *more, "--out", "plan.json")
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0, err
    # Its one visit is fewer than those of the plan that every method falls back on.
    plan = load_plan(tiny_file.parent / "plan.json")
    assert plan.objective == 3.0
    assert (plan.to_json() == out) == bool(more)
    assert "interrupted: this is the best result so far" in err
    assert all(line.startswith("adr-opt: ") for line in err.splitlines())
    assert "incumbent" not in err


@posix
@pytest.mark.usefixtures("methods")
def test_second_signal_aborts(tiny_file: Path) -> None:
    """Ctrl-C twice ends a planner that does not listen: exit 130, nothing written."""
    process = begin(tiny_file, "deaf", "--out", "plan.json")
    process.send_signal(signal.SIGINT)
    assert process.stderr is not None
    assert "interrupt again to abort" in process.stderr.readline()
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert out == ""
    assert err == "adr-opt: aborted\n"
    assert not (tiny_file.parent / "plan.json").exists()


@pytest.mark.slow
@posix
@pytest.mark.usefixtures("methods")
def test_aborting_gives_the_cursor_back(tiny_file: Path) -> None:
    """The live line hides the cursor; also after the second Ctrl-C it is shown again."""
    ours, theirs = os.openpty()
    environment = {**os.environ, "TERM": "xterm"}
    process = begin(tiny_file, "deaf", stderr=theirs, env=environment)
    os.close(theirs)
    said = b""
    sent = 0
    for part in parts(ours):
        said += part
        if sent == (b"to abort" in said):
            process.send_signal(signal.SIGINT)
            sent += 1
    os.close(ours)
    assert process.wait(timeout=PATIENCE_S) == 130
    hidden, shown = said.rfind(b"\x1b[?25l"), said.rfind(b"\x1b[?25h")
    assert 0 <= hidden < shown


@posix
@pytest.mark.usefixtures("methods")
@pytest.mark.parametrize(
    "more", [[], *(pytest.param([word], marks=pytest.mark.slow) for word in ("--json", "--quiet"))]
)
def test_live_line_only_on_a_terminal(tiny_file: Path, more: list[str]) -> None:
    """On a terminal the line shows incumbent, bound and gap, but not with --json or --quiet."""
    ours, theirs = os.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "80"}
    process = begin(tiny_file, "patient", *more, stderr=theirs, env=environment)
    os.close(theirs)
    said = b"" if more else read_until(ours, b"gap 75.0%")
    process.send_signal(signal.SIGINT)
    said += read_until(ours)
    os.close(ours)
    out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0
    assert ("incumbent 1  bound 4  gap 75.0%" in said.decode()) == (not more)
    assert "gap 25.0%" in out or "--json" in more


@posix
@pytest.mark.slow
def test_interrupted_while_the_timetable_is_built(tmp_path: Path) -> None:
    """A build of minutes is shown, and Ctrl-C ends it soon: a plan or a sentence, no traceback."""
    path = tmp_path / "large.json"
    instance = adr_opt.generate("nominal", 0, targets=150)
    path.write_text(instance.with_limits(duration_s=200 * 86400.0).to_json())
    ours, theirs = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", CHILD, "solve", str(path), "--time-limit", "900"],
        stdout=subprocess.PIPE,
        stderr=theirs,
        env={**os.environ, "TERM": "xterm"},
        text=True,
    )
    os.close(theirs)
    said = b""
    sent = math.inf
    for part in parts(ours):
        said += part
        if b"timetable" in said and sent == math.inf:
            process.send_signal(signal.SIGINT)
            sent = time.monotonic()
    os.close(ours)
    process.communicate(timeout=PATIENCE_S)
    assert time.monotonic() - sent < 60.0
    assert process.returncode in (0, 1)
    assert b"Traceback" not in said
    assert b"of 150 destinations" in said or b"no time to begin" in said


def on_terminal(code: str, arguments: list[str], folder: Path) -> tuple[subprocess.Popen[str], int]:
    """A verb as a process with a terminal for standard error; the end of it that is read."""
    ours, theirs = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", code + CHILD, *arguments],
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=theirs,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "80"},
    )
    os.close(theirs)
    return process, ours


SLEEP = "import time; slow = lambda *given, **named: time.sleep(600); "


@posix
@pytest.mark.parametrize(
    ("slowed", "call", "shown"),
    [
        (
            "import adr_opt.judge.verify as judge, adr_opt.plan.certificate as certificate; "
            "import adr_opt.judge.admit as gate, types; gate.admit = lambda *given: "
            "types.SimpleNamespace(plan=None); "
            "certificate.Certificate.load = lambda path: None; judge.verify = slow; ",
            "verify tiny.json certificate.json",
            b"verifying",
        ),
        (
            "from adr_opt.mission.mission import Mission; "
            "Mission.build = lambda self, pairs, enough: (enough(0.37), slow()); ",
            "matrix tiny.json --at 0 --out matrix.npz",
            b"37/100",
        ),
        (
            "import adr_opt.sources.catalogue as catalogue; catalogue.read = slow; ",
            "import objects.tle --out instance.json",
            b"reading objects",
        ),
    ],
    ids=["verify", "matrix", "import"],
)
def test_long_verbs_have_a_bar_and_end_at_once(
    tmp_path: Path, slowed: str, call: str, shown: bytes
) -> None:
    """On a terminal something moves; Ctrl-C ends it: exit 130, a word, and no file."""
    adr_opt.generate("tiny", 0).save(tmp_path / "tiny.json")
    process, ours = on_terminal(SLEEP + slowed, call.split(), tmp_path)
    said = read_until(ours, shown)
    assert shown in said, said
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=PATIENCE_S) == 130
    said += read_until(ours)
    os.close(ours)
    assert said.replace(b"\r", b"").endswith(b"adr-opt: aborted\n")
    assert b"Traceback" not in said
    assert [path.name for path in tmp_path.iterdir()] == ["tiny.json"]


@pytest.mark.slow
@posix
def test_a_tradeoff_counts_proven_points(tmp_path: Path) -> None:
    """The bar is on the terminal beside the lines on single points, and not in what is printed."""
    adr_opt.generate("tiny", 0).save(tmp_path / "tiny.json")
    call = ["tradeoff", "tiny.json", "--vary", "delta-v=2000,3000", "--time-limit", "5"]
    process, ours = on_terminal("", call, tmp_path)
    said = read_until(ours)
    os.close(ours)
    out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0
    assert b"proven points" in said
    assert b"2 of 2 points proven" in said
    assert "proven points" not in out
