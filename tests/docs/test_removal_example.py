"""The examples that remove the upper stages of a catalogue: a campaign, and drives compared."""

from __future__ import annotations

import os
import re
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import adr_opt
from adr_opt.plan.refined_plan import load_refined
from adr_opt.sources.catalogue import read

pytest.importorskip("sgp4.io")
pytest.importorskip("plotly")

FOLDER = Path(__file__).parents[2] / "examples/removal"
DATA = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", "../shared/data"))
DAY_S = 86400.0
SHORT = ["--days", 60, "--launch-every", 15, "--deadline", 30, "--kits", 2, "--time-limit", 15]
"""Options for a campaign whose legs are refined in seconds."""


@pytest.fixture
def plan_removal() -> Callable[..., int]:
    """The command, called with its arguments."""
    main: Any = runpy.run_path(str(FOLDER / "plan_removal.py"))["main"]
    return lambda *arguments: main([str(argument) for argument in arguments])


@pytest.mark.parametrize("example", ["removal", "rocket-bodies"])
def test_made_up_catalogues_are_what_their_scripts_print(
    example: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """bodies.tle is the output of the script beside it."""
    folder = FOLDER.parent / example
    runpy.run_path(str(folder / "make_bodies.py"), run_name="__main__")
    assert capsys.readouterr().out == (folder / "bodies.tle").read_text(encoding="utf-8")


def hold(out: Path, said: str, deadline_days: float) -> None:
    """The campaign in a folder is planned, bounded, checked, refined and shown."""
    instance, plan = adr_opt.load(out / "mission.json"), adr_opt.load_plan(out / "plan.json")
    assert [chaser.is_launched for chaser in instance.chasers] == [True] * 3
    assert {target.removal for target in instance.targets} == {"kit"}
    heavy = {target.mass_kg for target in instance.targets if target.required}
    assert heavy == {9000.0}
    ends = {leg.destination: leg.end_s for leg in plan.legs}
    wanted = [target.name for target in instance.targets if target.required]
    assert len(wanted) == 2
    assert all(ends[name] <= deadline_days * DAY_S for name in wanted)
    most = re.search(rf"^{plan.objective:g} of \d+ removed, at most (\d+) with 10 % of", said, re.M)
    assert most is not None
    assert plan.objective <= float(most[1]) <= len(instance.targets)
    assert adr_opt.check(instance, plan) == ()
    refined = load_refined(out / "refined.json")
    assert refined.missing == ()
    assert len(refined.legs) == sum(leg.kind != "launch" for leg in plan.legs)
    assert all(f"{name}: 9000 kg, " in said for name in wanted)
    assert len(re.findall(r"^chaser-\d: at launch ", said, re.MULTILINE)) == 3
    assert ", 0 missing, 0 tanks broken\n" in said
    assert f"{plan.objective:g} of {len(instance.targets)} removed, at most" in said
    page = (out / "page.html").read_text(encoding="utf-8")
    assert "mass at the start kg" in page
    assert "mass kg" in page


@pytest.mark.slow
def test_the_made_up_catalogue_becomes_a_campaign(
    plan_removal: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its stages are removed by three launches, the dangerous ones in time, and legs hold."""
    assert plan_removal(FOLDER / "bodies.tle", *SHORT, "--out", tmp_path / "made") == 0
    hold(tmp_path / "made", capsys.readouterr().out, 30.0)


def test_what_is_wrong_is_said_in_one_sentence(
    plan_removal: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No such file, no such object, no time for the launches: 2, and nothing is made."""
    for arguments, named in (
        ([tmp_path / "none"], "no such file"),
        ([FOLDER.parent / "catalogue/cloud.tle"], "no object is left"),
        ([FOLDER / "bodies.tle", "--days", 10], "launch 3 is on day 730"),
    ):
        assert plan_removal(*arguments, "--out", tmp_path / "made") == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert named in said
    assert not (tmp_path / "made").exists()


COMPARED = re.compile(
    r"^(chemical|electric)[^:]*: removes (\d+) of (\d+) \(\d+ SL-16 R/B, \d+ SL-8 R/B\), "
    r"at most (\d+); (\d+) kg of propellant, [\d.]+ removals per 100 kg; on days [\d, ]+, "
    r"[\d.]+ a year; 0 violations$",
    re.MULTILINE,
)


@pytest.fixture
def compare() -> Callable[..., int]:
    """The comparison of drives, called with its arguments."""
    main: Any = runpy.run_path(str(FOLDER / "chemical_or_electric.py"))["main"]
    return lambda *arguments: main([str(argument) for argument in arguments])


@pytest.mark.slow
def test_drives_are_compared_on_the_same_stages(
    compare: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of four drives each has a checked plan below its bound, and thrust removes the most."""
    options = ("--days", 730, "--time-limit", 20, "--out", tmp_path / "drives")
    assert compare(FOLDER / "bodies.tle", *options) == 0
    found = COMPARED.findall(capsys.readouterr().out)
    assert [kind for kind, *_ in found] == ["chemical", "chemical", "electric", "electric"]
    removed = [int(each[1]) for each in found]
    for at, (_, count, targets, most, used_kg) in enumerate(found):
        instance = adr_opt.load(tmp_path / f"drives/mission-{at}.json")
        plan = adr_opt.load_plan(tmp_path / f"drives/plan-{at}.json")
        assert adr_opt.check(instance, plan) == ()
        assert plan.objective == int(count) <= int(most) <= int(targets) == len(instance.targets)
        assert {target.removal for target in instance.targets} == {"tow"}
        assert int(used_kg) <= instance.chasers[0].tank.propellant_kg
        assert (instance.chasers[0].thrust_n is None) == (at < 2)
    assert max(removed[2:]) > removed[0]


def test_a_comparison_of_nothing_is_refused(
    compare: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No such file, or no such object: one sentence, exit status 2, and nothing is made."""
    for file, named in (
        (tmp_path / "none", "no such file"),
        (FOLDER.parent / "catalogue/cloud.tle", "no object is left"),
    ):
        assert compare(file, "--out", tmp_path / "drives") == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert named in said
    assert not (tmp_path / "drives").exists()


def catalogues() -> list[Path]:
    """Files under tle/ that have some SL-16 stages."""
    return [
        path
        for path in sorted((DATA / "tle").glob("*"))
        if sum("SL-16 R/B" in record.name for record in read(path, skip_bad=True)) >= 5
    ]


@pytest.mark.external
@pytest.mark.skipif(not catalogues(), reason=f"no file with SL-16 R/B in {DATA / 'tle'}")
def test_drives_are_compared_on_a_real_catalogue(
    compare: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With as much propellant electric chasers remove at least twice as many real stages."""
    assert compare(catalogues()[0], "--out", tmp_path / "drives") == 0
    removed = [int(each[1]) for each in COMPARED.findall(capsys.readouterr().out)]
    assert len(removed) == 4
    assert min(removed[2:]) >= 2 * removed[0]


@pytest.mark.external
def test_a_real_catalogue_becomes_a_campaign(
    plan_removal: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Stages of a catalogue under tle/, if one of the files there has them, are removed too."""
    files = catalogues()
    if not files:
        pytest.skip(f"no file with SL-16 R/B in {DATA / 'tle'} (ADR_OPT_EXTERNAL_DATA)")
    options = [*SHORT, "--propellant", 150]
    assert plan_removal(files[0], *options, "--out", tmp_path / "real") == 0
    hold(tmp_path / "real", capsys.readouterr().out, 30.0)
