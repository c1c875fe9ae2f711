"""The example that goes from the rocket bodies of a catalogue to a proven plan and its page."""

from __future__ import annotations

import re
import runpy
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from catalogue_files import SPELLINGS, as_tle, field

import adr_opt
from adr_opt.problem.transfer_sizes import transfers_for
from adr_opt.sources.catalogue import ElementSet

FOLDER = Path(__file__).parents[2] / "examples/rocket-bodies"
DAYS = 120.0


@pytest.fixture
def plan_a_year() -> Callable[..., int]:
    """The command, called with its arguments."""
    main: Any = runpy.run_path(str(FOLDER / "plan_a_year.py"))["main"]
    return lambda *arguments: main([str(argument) for argument in arguments])


def upper_stages(count: int) -> list[ElementSet]:
    """Objects as a catalogue has them, some of them upper stages near 71° and 840 km."""
    records = field(count + 6)
    return [
        replace(
            record,
            name="SL-16 R/B",
            inclination_deg=71.0 + 0.005 * (number % 7),
            raan_deg=round(23.7 * number, 4),
            mean_motion_rev_day=14.15 + 0.0004 * number,
        )
        if number < count
        else record
        for number, record in enumerate(records)
    ]


def short_of_time(*more: object) -> list[object]:
    """Options for a mission that takes seconds."""
    return ["--days", DAYS, "--delta-v", 700, "--time-limit", 5, *more]


@pytest.mark.parametrize("spelling", ["tle", "csv"])
@pytest.mark.slow
def test_one_command_from_a_catalogue_to_a_page(
    plan_a_year: Callable[..., int],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    spelling: str,
) -> None:
    """Upper stages of a catalogue in any spelling are planned, bounded, checked and shown."""
    pytest.importorskip("plotly")
    path = tmp_path / "catalogue.txt"
    path.write_text(SPELLINGS[spelling](upper_stages(5)), encoding="utf-8")
    assert plan_a_year(path, *short_of_time("--out", tmp_path / "made")) == 0
    instance = adr_opt.load(tmp_path / "made/mission.json")
    assert len(instance.targets) == 5
    assert instance.stations == ()
    assert instance.dynamics == "j2"
    orbits = [target.orbit for target in instance.targets]
    assert instance.transfer == transfers_for(DAYS * 86400.0, orbits=orbits)
    plan = adr_opt.load_plan(tmp_path / "made/plan.json")
    assert plan.upper_bound is not None
    assert 1.0 <= plan.objective <= plan.upper_bound < 5.0
    assert adr_opt.check(instance, plan) == ()
    assert "<html" in (tmp_path / "made/page.html").read_text(encoding="utf-8")
    said = re.fullmatch(
        r"(\d+) of 5 visits with \d+ m/s, at most (\d+) \(.*\), 0 violations: .*page.html\n",
        capsys.readouterr().out,
    )
    assert said is not None
    assert float(said[1]) == plan.objective
    assert float(said[2]) == plan.upper_bound


def test_what_is_wrong_is_said_in_one_sentence(
    plan_a_year: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No such file, no such object, and no length of the mission: 2, and nothing is made."""
    path = tmp_path / "catalogue.txt"
    path.write_text(as_tle(upper_stages(2)), encoding="utf-8")
    for arguments, named in (
        ([tmp_path / "none"], "no such file"),
        ([path, "--name", "SL-8"], "no object is left of 8"),
        ([path, "--days", -1], "duration_s"),
    ):
        assert plan_a_year(*arguments, "--out", tmp_path / "made") == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert named in said
    assert not (tmp_path / "made").exists()


@pytest.mark.slow
def test_the_made_up_catalogue_is_planned(
    plan_a_year: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All 18 objects of it become targets, and some of them are visited in a year."""
    pytest.importorskip("plotly")
    out = tmp_path / "made"
    call = [FOLDER / "bodies.tle", "--name", "SYNTHETIC R/B", "--time-limit", 5, "--out", out]
    assert plan_a_year(*call) == 0
    assert " of 18 visits with " in capsys.readouterr().out
    assert adr_opt.load_plan(out / "plan.json").objective >= 3.0
