"""The command that prints what is known of each benchmark of the outside world."""

from __future__ import annotations

import pytest
from from_outside import BENCH, DATA, external
from outside import run as script

from adr_opt.common.errors import InputError


@pytest.mark.parametrize(
    ("name", "folder", "files", "figures"),
    [
        pytest.param(
            "gtoc9",
            "gtoc9",
            "*",
            ("731.28", "731.49", "728.37", "618.95", "620.46"),
            marks=external("gtoc9"),
        ),
        pytest.param(
            "odrc",
            "mcrdv",
            "*",
            ("44830.8 | 44830.8 | 44278.7 | 44278.7",),
            marks=[*external("mcrdv"), pytest.mark.slow],
        ),
        pytest.param(
            "optw",
            "optw",
            "*tt?0.TXT 20.4.2.TXT 50.4.1.TXT optima.csv",
            (
                "| 20.4.2 | 299 | 299 | 299 |",
                "| 50.4.1 | 498 | 498 | 498 |",
                "Of the 2 that CPLEX proved, 2 have the same score",
                "2 of 2 proven",
            ),
            marks=[*external("optw"), pytest.mark.slow],
        ),
    ],
)
def test_what_is_known_is_printed(capsys, tmp_path, name, folder, files, figures):
    """From the folder of all data, which may be that of the benchmark, the figures are printed."""
    (tmp_path / folder).mkdir()
    for pattern in files.split():
        for path in (DATA / folder).glob(pattern):
            (tmp_path / folder / path.name).symlink_to(path.resolve())
    assert script.folder_of(folder, tmp_path) == tmp_path / folder
    assert script.folder_of(folder, tmp_path / folder) == tmp_path / folder
    getattr(script, name)(data=tmp_path)
    said = capsys.readouterr().out
    for figure in figures:
        assert figure in said


def test_data_that_are_not_there_are_told(tmp_path, monkeypatch):
    """Without a folder, and with one that is not there, one sentence asks for it."""
    monkeypatch.delenv("ADR_OPT_EXTERNAL_DATA", raising=False)
    for data in (None, tmp_path / "nowhere"):
        with pytest.raises(InputError, match="no such folder"):
            script.odrc(data=data)


def test_what_judges_shares_nothing_with_planners():
    """Scorers import no planner."""
    judges = list(BENCH.glob("outside/*/scoring.py"))
    assert len(judges) == 4
    for path in judges:
        text = path.read_text(encoding="utf-8")
        assert "solvers" not in text
        assert "import adr_opt" not in text
