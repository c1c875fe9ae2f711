"""`solve` and `bound`: what they print, and how options reach a method."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from conftest import Cli

import adr_opt
from adr_opt.common.wording import shortened
from adr_opt.plan.plan import Plan, load_plan
from adr_opt.problem.instance import Instance
from adr_opt.run import front
from adr_opt.ui.cli.timeline import clock, span


def test_json_is_the_plan_file_and_nothing_else(cli: Cli, tiny_file: Path) -> None:
    """`solve --json` prints exactly the plan that --out writes; --quiet silences the rest."""
    call = ("solve", tiny_file, "--method", "greedy-guarded", "--json")
    outcome = cli(*call, "--out", "plan.json", "--quiet")
    assert outcome.status == 0
    assert outcome.out == Path("plan.json").read_text(encoding="utf-8")
    assert outcome.err == ""
    assert json.loads(outcome.out)["format"] == "adr-opt-plan/2"


def test_solve_without_out_writes_no_file(cli: Cli, tiny_file: Path) -> None:
    """Without --out nothing appears in the working folder."""
    cli("solve", tiny_file, "--method", "greedy")
    cli("solve", tiny_file, "--method", "greedy", "--json")
    assert list(tiny_file.parent.iterdir()) == [tiny_file]


def test_timeline_shows_every_leg_and_the_summary(cli: Cli) -> None:
    """The table has a row per leg, refuelling marked, and the summary adds up."""
    cli("generate", "nominal", "--targets", "12", "--out", "my.json")
    outcome = cli("solve", "my.json", "--method", "greedy-guarded", "--out", "plan.json")
    plan = load_plan("plan.json")
    refuellings = plan.destinations.count("station")
    rows = [line for line in outcome.out.splitlines() if line.startswith("│")]
    assert len(rows) == len(plan.legs) > 0
    assert sum("refuels" in row for row in rows) == refuellings > 0
    for row, leg in zip(rows, plan.legs, strict=True):
        for text in (
            f"{leg.origin} → {leg.destination}",
            clock(leg.departure_s),
            clock(leg.arrival_s),
            span(leg.departure_s - leg.ready_s),
            f"{leg.delta_v_m_s:.1f}",
            f"{leg.delta_v_left_m_s:.1f}",
            f" {leg.phasing_revolutions} ",
        ):
            assert text in row
    last = outcome.out.splitlines()[-2]  # what the flight comes to follows
    assert f"visits {len(plan.legs) - refuellings} of 12" in last
    assert f"ΔV {plan.delta_v_m_s:.1f} m/s" in last
    assert f"refuellings {refuellings}" in last


@pytest.fixture(scope="module")
def of_a_cloud() -> tuple[Instance, Plan]:
    """A plan over objects that share one long name but for the number at its end."""
    tiny = adr_opt.generate("nominal", 0, targets=12)
    instance = tiny.replace(
        targets=tuple(
            target.replace(name=f"COSMOS 2251 DEB {34020 + at}")
            for at, target in enumerate(tiny.targets)
        )
    )
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    assert "station" in plan.destinations
    return instance, plan


@pytest.mark.parametrize("verb", ["solve", "fly"])
@pytest.mark.parametrize("columns", [40, 60, 80, 100, 200, None])
def test_numbers_are_never_cut_and_names_can_be_told_apart(
    cli: Cli,
    monkeypatch: pytest.MonkeyPatch,
    of_a_cloud: tuple[Instance, Plan],
    verb: str,
    columns: int | None,
) -> None:
    """At any width rows keep their numbers and differ in their names; a pipe has whole names."""
    instance, plan = of_a_cloud
    Path("my.json").write_text(instance.to_json(), encoding="utf-8")
    plan.save("plan.json")
    monkeypatch.setenv("COLUMNS", "80" if columns is None else str(columns))
    if columns is not None:
        monkeypatch.setenv("FORCE_COLOR", "1")  # rich takes standard output for a terminal
        monkeypatch.setenv("TERM", "dumb" if columns == 80 else "xterm")
    if verb == "fly":
        pytest.importorskip("boinor")
        flight = json.loads(cli("fly", "my.json", "plan.json", "--json").out)
        numbers = [
            [f"{leg[key]:.2g}" for key in ("miss_m", "relative_speed_m_s", "arrival_miss_m")]
            for leg in flight["legs"]
        ]
        out = cli("fly", "my.json", "plan.json").out
    else:
        numbers = [
            [
                clock(leg.departure_s),
                span(leg.departure_s - leg.ready_s),
                f"{leg.delta_v_m_s:.1f}",
                f"{leg.delta_v_left_m_s:.1f}",
                str(leg.phasing_revolutions),
                clock(leg.arrival_s),
            ]
            for leg in plan.legs
        ]
        out = cli("solve", "my.json", "--method", "greedy-guarded").out
    plain = re.sub(r"\x1b\[[0-9;]*m", "", out)
    rows = [line for line in plain.splitlines() if re.match(r"[│ ]* \d+ .*→", line)]
    assert len(rows) == len(plan.legs) > 3
    if columns is None or columns >= 60:
        assert max(map(len, rows)) <= (columns or 200)
    seen = set()
    for row, texts, leg in zip(rows, numbers, plan.legs, strict=True):
        cells = " ".join(row.replace("│", " ").split())
        assert cells.endswith(" ".join(texts))
        assert "…" not in cells.partition(texts[0])[2]
        number = leg.destination.rpartition(" ")[2]
        assert number in cells or "(refuels)" in cells or leg.destination == "station"
        if columns is None or columns >= 200:
            assert f"{leg.origin} → {leg.destination}" in cells
        if leg.destination != "station":
            seen.add(cells.partition("→")[2].partition(texts[0])[0])
    assert len(seen) == len(set(plan.destinations) - {"station"})


def test_names_are_cut_to_different_ones() -> None:
    """Short names stay; of long ones the middle goes, or else what they begin with in common."""
    cloud = [f"COSMOS 2251 DEB {number}" for number in (34021, 34022)]
    short = shortened(["station", *cloud], 12)
    assert list(short.values()) == ["station", "COSM…B 34021", "COSM…B 34022"]
    for width in range(6, 22):
        assert len(set(shortened(cloud, width).values())) == 2
    for width in range(7, 22):
        assert all(text.endswith(name[-5:]) for name, text in shortened(cloud, width).items())
    (twin,) = shortened(["SL-16 ROCKET BODY 22285 (2)"], 12).values()
    assert twin == "SL…22285 (2)"
    front = [f"{letter} of the long long cloud" for letter in "ab"]
    inside = [f"object {letter}{number} of the cloud" for letter in "ab" for number in (1, 2, 10)]
    for names in (front, inside, [*front, *inside, *cloud]):
        for width in (6, 10, 16):
            short = shortened(names, width)
            assert len(set(short.values())) == len(names)
            assert all(len(text) <= width for text in short.values())


def test_a_margin_is_left_in_every_tank(cli: Cli, tiny_file: Path) -> None:
    """`--margin` keeps a share of each tank; the plan is legal and says what it was made with."""
    call = ("--margin", "0.2", "--time-limit", "20")
    solved = cli(
        "solve", tiny_file, "--method", "beam", "--bound", "exact", *call, "--out", "plan.json"
    )
    assert solved.status == 0
    assert "prize" in solved.out
    assert "bound" not in solved.out
    assert "gap" not in solved.out
    instance, plan = adr_opt.load(tiny_file), load_plan("plan.json")
    assert plan.upper_bound is None
    budget = instance.chaser.tank.delta_v_m_s
    assert min(leg.delta_v_left_m_s for leg in plan.legs) >= 0.2 * budget
    assert cli("check", tiny_file, "plan.json").status == 0
    said = f"no plan that keeps back 20 % of each tank ({0.2 * budget:g} m/s) collects more than"
    assert said in solved.err
    assert any(said in note for note in plan.notes)
    bound = cli("bound", tiny_file, "--method", "exact", *call, "--json")
    assert said in bound.err
    assert json.loads(bound.out)["margin"] == 0.2
    assert cli("solve", tiny_file, "--margin", "1").status == 2


def test_a_bound_has_a_default_method(cli: Cli, tiny_file: str) -> None:
    """Without `--method` a bound is that of `exact`, in the shell, in Python and in the list."""
    said = cli("bound", tiny_file, "--json")
    assert said.status == 0
    assert json.loads(said.out)["method"] == "exact"
    bounds = json.loads(cli("methods", "--json").out)["bounds"]
    assert [each["name"] for each in bounds if each["default"]] == ["exact"]
    proven = adr_opt.bound(tiny_file)
    assert (proven.method, proven.upper_bound) == ("exact", json.loads(said.out)["upper_bound"])


def test_times_are_written_as_clocks() -> None:
    """Days count from 0, minutes are rounded and carry into hours and days."""
    assert clock(0.0) == "0d 00:00"
    assert clock(86400.0 + 3 * 3600.0 + 25 * 60.0 + 29.0) == "1d 03:25"
    assert clock(2 * 86400.0 - 1.0) == "2d 00:00"
    assert span(25 * 3600.0 + 61.0) == "25:01"


@pytest.mark.usefixtures("methods")
def test_options_are_converted_by_their_defaults(cli: Cli, tiny_file: Path) -> None:
    """--option, --jobs and --iterations reach the planner with their types."""
    outcome = cli(
        f"solve {tiny_file} --method worker --jobs 2 --iterations 7 --option depth=5 --option "
        "fast=true --option word=b=c --option limit=inf"
    )
    assert outcome.status == 0
    assert "note: jobs 2 depth 5 fast True word b=c asked 7" in outcome.err


def test_help_states_the_time_limits(cli: Cli) -> None:
    """The default time limits in the help are those of the front door."""
    for verb, limit_s in (
        ("solve", front.DEFAULT_TIME_LIMIT_S),
        ("bound", front.DEFAULT_BOUND_TIME_LIMIT_S),
    ):
        assert f"included; default {limit_s:g} s." in " ".join(cli(verb, "--help").out.split())


@pytest.mark.usefixtures("methods")
def test_no_plan_is_exit_one(cli: Cli, tiny_file: Path) -> None:
    """A planner that finds nothing ends with 1 and writes nothing, but still speaks JSON."""
    outcome = cli("solve", tiny_file, "--method", "hopeless", "--json", "--out", "plan.json")
    assert outcome.status == 1
    assert json.loads(outcome.out)["status"] == "unknown"
    assert "no plan" in outcome.err
    assert not Path("plan.json").exists()


@pytest.mark.usefixtures("methods")
def test_a_method_that_cannot_be_imported_says_so(cli: Cli, tiny_file: Path) -> None:
    """A declared method without its code is one sentence, and does not spoil the list."""
    outcome = cli("solve", tiny_file, "--method", "absent")
    assert outcome.status == 2
    assert "'absent' is declared, but cannot be imported" in outcome.err
    listed = {
        entry["name"]: entry for entry in json.loads(cli("methods", "--json").out)["planners"]
    }
    assert "cannot be imported" in listed["absent"]["summary"]
    assert listed["starter"] == {
        "name": "starter",
        "summary": "Return the start plan.",
        "default": False,
        "takes_start": True,
        "options": [],
    }
    assert listed["worker"]["options"][-1] == {
        "name": "limit",
        "type": "float",
        "default": "inf",
        "unit": "",
        "allowed": "",
        "meaning": "",
    }


@pytest.mark.usefixtures("methods")
def test_bound_prints_its_certificate(cli: Cli, tiny_file: Path) -> None:
    """`bound --json` gives bound, status, runtime and counters; a start plan reaches the bound."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    call = ("bound", tiny_file, "--method", "lid", "--start", "plan.json")
    content = json.loads(cli(*call, "--json").out)
    assert content["upper_bound"] == len(adr_opt.load(tiny_file).targets)
    assert content["status"] == "unknown"
    assert content["runtime_s"] == 0.5
    assert content["counters"] == {"start": len(load_plan("plan.json").legs)}
    assert cli(*call).out.startswith(f"upper bound {content['upper_bound']:g}, unknown")


@pytest.mark.usefixtures("methods")
def test_a_bound_that_proves_nothing_is_null(cli: Cli) -> None:
    """An infinite bound is null in JSON and said in words in text."""
    cli("generate", "tiny", "--targets", "3", "--out", "three.json")
    call = ("bound", "three.json", "--method", "lid")
    assert json.loads(cli(*call, "--json").out)["upper_bound"] is None
    assert "none proven" in cli(*call).out


def test_front_bound_is_the_python_call(methods: Path) -> None:
    """`front.bound` finds bounds in their own group and knows no planners."""
    instance = adr_opt.generate("tiny", 0)
    assert front.bound(instance, "lid", start=(1,)).counters == {"start": 1}
    with pytest.raises(adr_opt.InputError, match=r"'greedy' is unknown; use one of: .*lid"):
        front.bound(instance, "greedy")
