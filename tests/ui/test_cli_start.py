"""`solve --start` and `--confidence`: plans to begin from, repaired or refused, and kept ones."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Cli
from plans import with_legs

import adr_opt
from adr_opt.mission.mission import Mission
from adr_opt.plan.plan import load_plan
from adr_opt.run import front


@pytest.mark.usefixtures("methods")
def test_jobs_and_start_are_refused_where_they_mean_nothing(cli: Cli, tiny_file: Path) -> None:
    """A method that cannot use --jobs or --start says so and names those that can."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    jobs = cli("solve", tiny_file, "--method", "starter", "--jobs", "2")
    assert jobs.status == 2
    assert "worker" in jobs.err.partition("or use one of: ")[2]
    start = cli("solve", tiny_file, "--method", "worker", "--start", "plan.json")
    assert start.status == 2
    assert "starter" in start.err.partition("or use one of: ")[2]
    assert cli("solve", tiny_file, "--method", "worker", "--jobs", "-1").status == 2
    twice = cli("solve", tiny_file, "--method", "worker", "--jobs", "2", "--option", "jobs=3")
    assert twice.status == 2
    assert "twice" in twice.err


@pytest.mark.usefixtures("methods")
def test_a_start_plan_is_handed_over_as_bodies(cli: Cli, tiny_file: Path) -> None:
    """--start gives the planner the plan's bodies."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    cli("solve", tiny_file, "--method", "starter", "--start", "plan.json", "--out", "again.json")
    assert load_plan("again.json").legs == load_plan("plan.json").legs != ()


@pytest.mark.usefixtures("methods")
def test_an_illegal_start_plan_is_refused_or_repaired(cli: Cli, tiny_file: Path) -> None:
    """An illegal start names its leg and why; --repair keeps what is legal and says how much."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    plan = load_plan("plan.json")
    assert len(plan.legs) >= 3
    first, second = plan.legs[:2]
    legs = (first, second.replace(destination=first.destination), *plan.legs[2:])
    with_legs(plan, legs).save("bad.json")
    call = ("solve", tiny_file, "--method", "starter", "--start", "bad.json")
    refused = cli(*call, "--out", "new.json")
    assert refused.status == 2
    assert "start plan: the plan is not legal: leg 2: order: goes from" in refused.err
    assert not Path("new.json").exists()
    repaired = cli(*call, "--out", "new.json", "--repair")
    assert repaired.status == 0
    note = f"only the first 1 of the start plan's {len(legs)} legs could be kept"
    assert note in repaired.err
    # What is left is flown at a schedule of its own.
    assert load_plan("new.json").destinations == (first.destination,)
    assert cli("check", tiny_file, "new.json").status == 0
    assert note in load_plan("new.json").notes


@pytest.mark.usefixtures("methods")
def test_repair_takes_a_plan_to_a_changed_instance(cli: Cli, tiny_file: Path) -> None:
    """A plan of another instance needs --repair, which times it anew and drops unknown bodies."""
    instance = adr_opt.load(tiny_file)
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    plan = load_plan("plan.json")
    gone = plan.legs[2].destination
    left = tuple(target for target in instance.targets if target.name != gone)
    Path("less.json").write_text(instance.replace(targets=left).to_json(), encoding="utf-8")
    call = ("solve", "less.json", "--method", "starter", "--start", "plan.json")
    refused = cli(*call)
    assert refused.status == 2
    assert "start plan: the plan belongs to the instance" in refused.err
    assert cli(*call, "--repair", "--out", "new.json").status == 0
    assert load_plan("new.json").destinations == plan.destinations[:2]
    assert cli("check", "less.json", "new.json").status == 0


def test_repair_without_start_is_refused(cli: Cli, tiny_file: Path) -> None:
    """--repair alone is a mistake, and is called one."""
    outcome = cli("solve", tiny_file, "--method", "greedy", "--repair")
    assert outcome.status == 2
    assert "--start" in outcome.err


@pytest.mark.usefixtures("methods")
@pytest.mark.parametrize(
    ("sequence", "named"),
    [
        ((0,), "leg 1 refuels, but no target was visited"),
        ((1, 1), "leg 2 goes from 'debris-001' to itself"),
        ((1, 2, 1), "leg 3 goes to 'debris-001', which was visited before"),
        ((1, 0, 0), "leg 3 refuels, but no target was visited"),
        ((99,), "bodies 0 to"),
    ],
)
def test_a_start_sequence_is_judged_by_the_rules(sequence: tuple[int, ...], named: str) -> None:
    """In Python a start may be a sequence of bodies; the first illegal move is named."""
    instance = adr_opt.generate("tiny", 0)
    mission = Mission(instance.with_limits(duration_s=1e6, delta_v_m_s=1e4))
    with pytest.raises(adr_opt.InputError, match=named):
        front.solve(mission, "starter", start=sequence)


@pytest.mark.usefixtures("methods")
def test_a_start_sequence_that_breaks_a_limit_says_which() -> None:
    """Too little ΔV and too little time are told apart."""
    instance = adr_opt.generate("tiny", 0)
    for limits, named in (
        ({"delta_v_m_s": 1.0}, r"needs .* m/s, but only 1 m/s are left"),
        ({"duration_s": 20000.0}, r"ends on day 0\.\d+ at the earliest, .* after the mission"),
        ({"duration_s": 10.0}, "but no transfer there leaves in time"),
    ):
        changed = instance.with_limits(**limits)
        with pytest.raises(adr_opt.InputError, match=named):
            front.solve(changed, "starter", start=(1,))
        assert front.solve(changed, "starter", start=(1,), repair=True).sequence == ()


UNCERTAIN = '{"legs": {"delta_v_factor": {"lognormal_sigma": 0.1}}}'


@pytest.fixture
def planned(cli: Cli, tiny_file: Path):
    """`solve` of a small field, with more options."""
    Path("u.json").write_text(UNCERTAIN, encoding="utf-8")
    return lambda *more: cli("solve", tiny_file, "--method", "beam", *more)


def test_a_plan_with_a_confidence_is_one_of_the_instance(planned, cli: Cli, tiny_file) -> None:
    """`check` and `rehearse` take the plan, and a note says how often it was kept."""
    made = planned(
        "--confidence", 0.9, "--uncertainty", "u.json", "--time-limit", 20, "--out", "p.json"
    )
    assert made.status == 0, made
    assert "kept with a confidence of 0.9" in made.err
    notes = json.loads(Path("p.json").read_text(encoding="utf-8"))["notes"]
    assert any("rehearsals were as planned" in note for note in notes)
    assert cli("check", tiny_file, "p.json").status == 0
    rehearsed = cli(
        "rehearse", tiny_file, "p.json", "--uncertainty", "u.json", "--samples", 300, "--json"
    )
    assert json.loads(rehearsed.out)["as_planned"]["share"] > 0.85


def test_a_plan_for_the_expected_prize_says_so(planned, cli: Cli, tiny_file) -> None:
    """Its file states what it collects on average, in a note and beside the objective."""
    made = planned("--expected", "--uncertainty", "u.json", "--time-limit", 10, "--out", "p.json")
    assert made.status == 0, made
    assert "made for its expected prize" in made.err
    content = json.loads(Path("p.json").read_text(encoding="utf-8"))
    assert 0.0 < content["expected"]["prize"] <= content["objective"]
    assert cli("check", tiny_file, "p.json").status == 0


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (("--confidence", 0.9), "--confidence needs --uncertainty"),
        (("--uncertainty", "u.json"), "--uncertainty needs --confidence or --expected"),
        (("--expected",), "--expected needs --uncertainty"),
        (
            ("--expected", "--confidence", 0.9, "--uncertainty", "u.json"),
            "--expected excludes --confidence",
        ),
        (
            ("--expected", "--uncertainty", "u.json", "--bound", "exact"),
            "--bound excludes --expected",
        ),
        (("--confidence", 1.0, "--uncertainty", "u.json"), "confidence = 1.0"),
        (("--confidence", 0.9, "--uncertainty", "none.json"), "none.json"),
        (
            ("--confidence", 0.9, "--uncertainty", "u.json", "--margin", 0.1),
            "--margin excludes --confidence",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(planned, more: tuple[object, ...], sentence) -> None:
    """Exit status 2 and one sentence, before anything is planned."""
    refused = planned(*more)
    assert refused.status == 2
    assert sentence in refused.err
    assert refused.err.count("\n") <= 2
