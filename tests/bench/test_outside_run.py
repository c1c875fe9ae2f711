"""The command that prints what is known of each benchmark of the outside world."""

from __future__ import annotations

import importlib.util
import sys

import pytest
from from_outside import BENCH, DATA, external


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
            "gtoc9 --bound-time-limit 0", "gtoc9", "*", ("731.28", "728.37", "717.", "618.95"),
            marks=external("gtoc9"),
        ),
        pytest.param(
            "odrc", "mcrdv", "*", ("44830.8 | 44830.8", "44278.7"), marks=external("mcrdv")
        ),
        pytest.param(
            "kttsp --time-limit 0", "kttsp", "*",
            ("49 targets", "| small | 111.9600 | – | 111.7560"),
            marks=external("kttsp"),
        ),
        pytest.param(
            "optw", "optw", "*tt?0.TXT 20.4.2.TXT 50.4.1.TXT optima.csv",
            ("| 20.4.2 | 299 | 299 | 299 | 299 |", "| 50.4.1 | 498 | – | 498 | 498 |",
             "Of the 2 that CPLEX proved, 2 have the same score", "2 of 2 proven"),
            marks=external("optw"),
        ),
    ],
)  # fmt: skip
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
        (["kttsp", "--data", str(tmp_path)], "no such file"),
        (["optw", "--data", str(tmp_path), "--solution", "it"], "only solutions of kttsp"),
        (["odrc", "--data", str(tmp_path), "--time-limit", "9"], "only gtoc9 and kttsp take one"),
        (["kttsp", "--data", str(tmp_path), "--time-limit", "-1"], "of 0 or more"),
    )
    for arguments, sentence in calls:
        assert script.main(arguments) == 2
        said = capsys.readouterr()
        assert said.out == ""
        assert said.err.count("\n") == 1
        assert sentence in said.err


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
