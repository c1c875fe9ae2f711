"""The command that prints what is known of each benchmark of the outside world."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from from_outside import BENCH, DATA, external
from outside import run as script
from outside.gtoc9 import campaign, debris
from outside.odrc import reading as odrc
from outside.optw import reading as optw
from outside.tdtsptw import reading as tdtsptw

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


READERS = {
    "gtoc9/debris_data.txt": debris.read_debris,
    "gtoc9/jpl_solution.json": campaign.read_campaign,
    "mcrdv/odrc.csv": odrc.read_debris,
    "optw/20.1.1.TXT": optw.read_places,
    "optw/titt20.TXT": lambda path: optw.read_static(path, 20),
    "tdtsptw/15_70_A_25_B6.json": tdtsptw.read_roads,
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=external(name.partition("/")[0])) for name in READERS]
)
def test_files_that_are_not_as_published_are_refused(tmp_path, name):
    """An empty file, one with a word for a number and none at all are one sentence each."""
    text, path = (DATA / name).read_text(encoding="utf-8"), tmp_path / Path(name).name
    with pytest.raises(InputError, match="no such file"):
        READERS[name](path)
    for spoilt in ("", re.sub(r"(?m)(?<=[\s,;:])\d+(?=\D)|^\d+", "far", text, count=9)):
        path.write_text(spoilt, encoding="utf-8")
        with pytest.raises(InputError, match=f"{re.escape(path.name)}: not as published"):
            READERS[name](path)


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
