"""The command that prints what is known of each benchmark of the outside world."""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys

import pytest
from from_outside import BENCH, DATA, external
from terminals import read_until


@pytest.fixture(scope="module")
def script():
    """The script, which is no module of the package when it is run."""
    before = list(sys.path)
    sys.path.insert(0, str(BENCH))
    spec = importlib.util.spec_from_file_location("outside_run", BENCH / "outside" / "run.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        yield module
    finally:
        sys.path[:] = before


@pytest.mark.parametrize(
    ("name", "folder", "files", "figures"),
    [
        pytest.param(
            "gtoc9", "gtoc9", "*", ("731.28", "728.37", "717.", "618.95"), marks=external("gtoc9")
        ),
        pytest.param(
            "odrc",
            "mcrdv",
            "*",
            ("44830.8 | 44830.8", "44278.7"),
            marks=[*external("mcrdv"), pytest.mark.slow],
        ),
        pytest.param(
            "optw",
            "optw",
            "*tt?0.TXT 20.4.2.TXT 50.4.1.TXT optima.csv",
            (
                "| 20.4.2 | 299 | 299 | 299 | 299 |",
                "| 50.4.1 | 498 | – | 498 | 498 |",
                "Of the 2 that CPLEX proved, 2 have the same score",
                "2 of 2 proven",
            ),
            marks=[*external("optw"), pytest.mark.slow],
        ),
    ],
)
def test_what_is_known_is_printed(script, capsys, tmp_path, name, folder, files, figures):
    """From the folder of all data, which may be that of the benchmark, the figures are printed."""
    (tmp_path / folder).mkdir()
    for pattern in files.split():
        for path in (DATA / folder).glob(pattern):
            (tmp_path / folder / path.name).symlink_to(path.resolve())
    command, *more = name.split()
    assert script.folder_of(command, tmp_path) == tmp_path / folder
    assert script.folder_of(command, tmp_path / folder) == tmp_path / folder
    assert script.main([command, *more, "--data", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    for figure in figures:
        assert figure in said


def test_wrong_calls_are_refused(script, capsys, tmp_path, monkeypatch):
    """Without a folder, with one that is not there or that is empty: one sentence, status 2."""
    monkeypatch.delenv("ADR_OPT_EXTERNAL_DATA", raising=False)
    calls = (
        (["gtoc9"], "no folder given"),
        (["odrc", "--data", str(tmp_path / "nowhere")], "no such folder"),
        (["odrc", "--data", str(tmp_path), "--time-limit", "9"], "only tdtsptw takes one"),
        (["tdtsptw", "--data", str(tmp_path), "--time-limit", "-1"], "of 0 or more"),
        (["optw", "--data", str(tmp_path), "--draw", "3"], "only instances of tdtsptw are drawn"),
        (["tdtsptw", "--data", str(tmp_path), "--draw", "0"], "one or more"),
    )
    for arguments, sentence in calls:
        assert script.main(arguments) == 2
        said = capsys.readouterr()
        assert said.out == ""
        assert said.err.count("\n") == 1
        assert sentence in said.err


@pytest.mark.parametrize("folder", [pytest.param("optw", marks=external("optw"))])
def test_a_missing_file_is_said_before_any_row(script, capsys, tmp_path, folder):
    """Travel times that the last instances need are missed before the first one is planned."""
    for path in (DATA / folder).iterdir():
        if path.name != "tt50.TXT":
            (tmp_path / path.name).symlink_to(path.resolve())
    assert script.main([folder, "--data", str(tmp_path)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "tt50.TXT: no such file" in said.err


def test_a_place_that_cannot_be_written_is_said_before_any_row(script, capsys, tmp_path):
    """A folder that is not there is no place for rows that take an hour."""
    assert script.main(["odrc", "--data", str(tmp_path), "--out", str(tmp_path / "no" / "it")]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert f"{tmp_path / 'no' / 'it'}: " in said.err


SLOW = """
import signal, sys, time
sys.path.insert(0, sys.argv[1])
signal.signal(signal.SIGINT, signal.default_int_handler)
from outside import run

def report(folder, doing):
    yield "| one |"
    doing("the second", 1, 2)
    yield "| two |"
    doing("the third", 2, 2)
    time.sleep(100)

run.of_odrc.report = report
sys.exit(run.main(sys.argv[2:]))
"""


@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
def test_rows_are_printed_and_kept_as_they_are_done(tmp_path):
    """Interrupted while the third row takes long: two are printed and in the file, status 130.

    On a terminal a bar says what is being done, and leaves what is printed alone.
    """
    ours, theirs = os.openpty()
    out = tmp_path / "kept.md"
    process = subprocess.Popen(
        [
            sys.executable,
            "-c",
            SLOW,
            str(BENCH),
            "odrc",
            "--data",
            str(tmp_path),
            "--out",
            str(out),
        ],
        text=True,
        stdout=subprocess.PIPE,
        stderr=theirs,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "80"},
    )
    os.close(theirs)
    assert process.stdout is not None
    printed = []
    while not printed or "| two |" not in printed[-1]:
        printed.append(process.stdout.readline())
        assert printed[-1], process.poll()
    said = read_until(ours, b"the third")
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=30.0) == 130
    said += read_until(ours)
    os.close(ours)
    printed.append(process.stdout.read())
    assert f"interrupted: what was done is printed and kept in {out}" in said.decode()
    assert b"Traceback" not in said
    assert "".join(printed) == out.read_text(encoding="utf-8")
    assert out.read_text(encoding="utf-8").endswith("| one |\n| two |\n")


def test_what_judges_shares_nothing_with_planners():
    """Scorers, and the enumerations that planners are held against, import no planner."""
    judges = [
        path for name in ("scoring", "subsets") for path in BENCH.glob(f"outside/*/{name}.py")
    ]
    assert len(judges) == 6
    for path in judges:
        text = path.read_text(encoding="utf-8")
        assert "solvers" not in text
        assert "import adr_opt" not in text
