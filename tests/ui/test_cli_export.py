"""``export`` on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from plans import with_legs

import adr_opt


@pytest.fixture
def plan_file(tiny_file: Path, tmp_path: Path) -> Path:
    plan = adr_opt.solve(adr_opt.load(tiny_file), "greedy-guarded").plan
    assert plan is not None
    path = tmp_path / "plan.json"
    plan.save(path)
    return path


@pytest.mark.parametrize("format", ["oem", "opm", "czml", "script"])
def test_export_writes_what_the_suffix_says(cli, tiny_file, plan_file, tmp_path, format) -> None:
    """One object on standard output, the file where it was asked for, a word on standard error."""
    out = tmp_path / f"mission.{format}"
    done = cli("export", tiny_file, plan_file, "--out", out, "--json")
    assert done.status == 0
    told = json.loads(done.out)
    legs = adr_opt.load_plan(plan_file).legs
    assert told["format"] == format
    assert told["legs"] == len(legs)
    assert told["burns"] == sum(len(leg.impulses) for leg in legs)
    assert told["end_s"] == legs[-1].end_s
    assert f"wrote {out}" in done.err
    assert out.stat().st_size > 1000


def test_the_format_may_be_named(cli, tiny_file, plan_file, tmp_path) -> None:
    """``--format`` decides whatever the suffix, and ``--quiet`` says nothing."""
    out = tmp_path / "mission.txt"
    done = cli("export", tiny_file, plan_file, "--out", out, "--format", "opm", "--quiet")
    assert (done.status, done.out, done.err) == (0, "", "")
    assert out.read_text().startswith("CCSDS_OPM_VERS")


def test_frame_step_and_leg(cli, tiny_file, plan_file, tmp_path) -> None:
    """The frame stands in the file, a shorter step makes it longer, a leg makes it shorter."""
    size = {}
    for name, options in (
        ("whole", ()),
        ("fine", ("--step", 20, "--frame", "TEME")),
        ("leg", ("--leg", 2)),
    ):
        out = tmp_path / f"{name}.oem"
        assert cli("export", tiny_file, plan_file, "--out", out, *options).status == 0
        size[name] = out.stat().st_size
    assert size["leg"] < size["whole"] < size["fine"]
    assert "REF_FRAME = TEME" in (tmp_path / "fine.oem").read_text()


def test_wrong_calls_end_in_one_sentence(cli, tiny_file, plan_file, tmp_path) -> None:
    """Exit 2, a sentence that names what is wrong, nothing on standard output, no file."""
    other = tmp_path / "other.json"
    other.write_text(adr_opt.generate("tiny", 1).to_json(), encoding="utf-8")
    empty = tmp_path / "empty.json"
    with_legs(adr_opt.load_plan(plan_file), ()).save(empty)
    legs = adr_opt.load_plan(plan_file).legs
    swapped, early = tmp_path / "swapped.json", tmp_path / "early.json"
    with_legs(adr_opt.load_plan(plan_file), (legs[1], legs[0], *legs[2:])).save(swapped)
    hasty = legs[1].replace(ready_s=legs[0].ready_s)
    with_legs(adr_opt.load_plan(plan_file), (legs[0], hasty, *legs[2:])).save(early)
    before = sorted(tmp_path.iterdir())
    for arguments, said in (
        ((other, plan_file, "--out", "a.oem"), "plan.json: the plan belongs to the instance"),
        ((tiny_file, empty, "--out", "a.oem"), "empty.json: the plan is not legal"),
        ((tiny_file, swapped, "--out", "a.oem"), "leg 1: chain"),
        ((tiny_file, early, "--out", "a.script"), "leg 2: ready"),
        ((tiny_file, plan_file, "--out", "a.xyz"), "a.xyz: suffix '.xyz' is unknown"),
        ((tiny_file, plan_file, "--out", "nowhere/a.oem"), "does not exist"),
        ((tiny_file, plan_file, "--out", plan_file, "--format", "oem"), "this is the input"),
        ((tiny_file, plan_file, "--out", "a.oem", "--leg", 99), "leg = 99"),
        ((tiny_file, plan_file, "--out", "a.oem", "--step", "nan"), "--step"),
        ((tiny_file, plan_file, "--out", "a.oem", "--step", 0), "--step"),
        ((tiny_file, plan_file, "--out", "a.script", "--frame", "TEME"), "frame = 'TEME'"),
        ((tiny_file, plan_file, "--out", "a.oem", "--frame", "ITRF"), "ITRF"),
        ((tiny_file, plan_file), "--out"),
        ((tiny_file, tmp_path / "none.json", "--out", "a.oem"), "no such file"),
    ):
        done = cli("export", *arguments)
        assert done.status == 2, arguments
        assert done.out == ""
        assert done.err.count("\n") == 1
        assert said in done.err
    assert sorted(tmp_path.iterdir()) == before
