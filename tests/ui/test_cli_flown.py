"""What `solve` and `check` say of the flight of a plan, and what its file keeps of it."""

from __future__ import annotations

import json
import os
import re
import signal
from pathlib import Path

import pytest
from conftest import Cli
from drifting_plans import drifting_instance, drifting_plan, with_a_tight_tank
from plans import with_legs, write
from toy_roads import as_rows, roads

import adr_opt
from adr_opt.fly.flight import mean_flight
from adr_opt.fly.flight.mean_flight import fly_mean
from adr_opt.plan.plan import load_plan
from adr_opt.problem.instance import load

LEFT = re.compile(r"left in (?:the tank|each tank): (-?[\d.]+)")


@pytest.fixture
def drawn(cli: Cli) -> Path:  # cli has chosen the folder
    """A tiny field with nodes that drift."""
    Path("my.json").write_text(
        adr_opt.generate("tiny", 0).replace(dynamics="j2").to_json(), encoding="utf-8"
    )
    return Path("my.json")


SOLVE = ("solve", "my.json", "--method", "greedy-guarded", "--out", "plan.json")


@pytest.mark.usefixtures("drawn")
def test_solve_says_in_its_last_line_what_is_left(cli: Cli) -> None:
    """The last line has the families, planned against flown, and what the flight leaves."""
    said = cli(*SOLVE)
    assert said.status == 0
    last = said.out.splitlines()[-1]
    plan = load_plan("plan.json")
    flight = fly_mean(load("my.json"), plan)
    assert flight is not None
    assert last.startswith("flown in mean motion under J2: ")
    assert f"{len(plan.legs)} short legs planned with {plan.delta_v_m_s:.1f} and flown with" in last
    found = LEFT.search(last)
    assert found is not None
    assert float(found[1]) == pytest.approx(-flight.tanks[0].over_m_s, abs=0.051)
    assert "--refine" not in last


@pytest.mark.usefixtures("drawn")
def test_the_file_keeps_the_flight_of_just_these_legs(cli: Cli) -> None:
    """`flown` stands in the file and in the JSON; of a plan with other legs it says nothing."""
    told = json.loads(cli(*SOLVE, "--json").out)
    plan = load_plan("plan.json")
    assert plan.own_flight is not None
    assert told["flown"] == plan.own_flight.to_dict()
    assert told["flown"]["how"] == "mean"
    assert told["flown"]["holds"] is True
    assert told["flown"]["tanks"][0]["left_m_s"] > 0.0
    shorter = with_legs(plan, plan.legs[:-1])
    assert shorter.flown is not None
    assert shorter.own_flight is None


@pytest.mark.usefixtures("drawn")
def test_who_asks_for_no_flight_gets_none(cli: Cli) -> None:
    """With --no-fly nothing is flown, and the file is as it was before there were flights."""
    said = cli(*SOLVE, "--no-fly")
    assert said.out.splitlines()[-1].startswith("visits ")
    assert "flown" not in json.loads(Path("plan.json").read_text(encoding="utf-8"))
    text = cli("check", "my.json", "plan.json", "--no-fly").out
    assert "neither flown nor refined: not requested" in text
    told = json.loads(cli("check", "my.json", "plan.json", "--no-fly", "--json").out)
    assert told["flown"] is None
    assert told["not_flown"] == "not requested"


def test_a_tank_that_breaks_is_said_with_what_helps(cli: Cli) -> None:
    """`check` finds no violation, ends with 0, and says which tank is over and what helps."""
    write(*with_a_tight_tank())
    said = cli("check", "my.json", "plan.json")
    assert said.status == 0
    assert "no violations" in said.out
    assert "is over by" in said.out
    assert "'solve --refine' plans until the plan holds" in said.out
    assert "--margin" not in said.out
    told = json.loads(cli("check", "my.json", "plan.json", "--json").out)
    assert told["violations"] == []
    assert told["flown"]["holds"] is False
    assert told["flown"]["tanks"][0]["left_m_s"] < 0.0


def test_check_flies_by_itself(cli: Cli) -> None:
    """What `check` says of a flight is its own finding, whatever the plan claims."""
    instance, plan = drifting_instance(0.003), drifting_plan(0.003)
    flight = fly_mean(instance, plan)
    assert flight is not None
    boast = flight.record.replace(
        tanks=tuple(tank.replace(left_m_s=599.0) for tank in flight.record.tanks)
    )
    write(instance, plan.replace(flown=boast))
    said = cli("check", "my.json", "plan.json")
    found = LEFT.search(said.out)
    assert found is not None
    assert float(found[1]) == pytest.approx(-flight.tanks[0].over_m_s, abs=0.051)
    assert "it was not refined" in said.out
    assert "1 short leg planned with" in said.out
    assert "1 drift planned with" in said.out
    write(instance, plan.replace(flown=boast.replace(legs_sha256="0" * 64)))
    assert "the flight that it records has other legs" in cli("check", "my.json", "plan.json").out


@pytest.mark.usefixtures("drawn")
def test_a_refined_plan_says_so(cli: Cli) -> None:
    """After `solve --refine` the plan says what refining came to, and `check` repeats that."""
    said = cli(*SOLVE, "--refine", "--refined-out", "refined.json")
    assert said.status == 0
    plan = load_plan("plan.json")
    assert plan.own_flight is not None
    assert plan.own_flight.how == "refined"
    text = cli("check", "my.json", "plan.json").out
    assert "according to the plan, refined in the field j2" in text
    assert "not refined" not in text
    # The refined plan names this very plan.
    assert cli("fly", "my.json", "refined.json").status == 0
    from adr_opt.plan.refined_plan import load_refined, reference

    assert load_refined("refined.json").plan == reference(plan)


def test_a_plan_with_violations_is_not_flown(cli: Cli) -> None:
    """Where `check` finds something, nothing is said of a flight."""
    instance, plan = drifting_instance(), drifting_plan()
    write(instance, plan.replace(objective=99.0))
    assert "flown" not in cli("check", "my.json", "plan.json").out
    told = json.loads(cli("check", "my.json", "plan.json", "--json").out)
    assert (told["flown"], told["not_flown"]) == (None, "it has violations")


@pytest.mark.usefixtures("drawn")
def test_a_signal_ends_the_flight_and_nothing_else(
    cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C while the plan is flown: it is written and printed, exit 0, and not called flown."""
    whole = mean_flight.true_delta_v_m_s

    def interrupted(*arguments: object) -> float:
        assert load_plan("plan.json").legs  # by then the plan is there
        os.kill(os.getpid(), signal.SIGINT)
        return whole(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(mean_flight, "true_delta_v_m_s", interrupted)
    # Children of a script in the background inherit an ignored SIGINT.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        said = cli(*SOLVE)
    finally:
        signal.signal(signal.SIGINT, before)
    assert said.status == 0
    assert said.out.splitlines()[-1] == "not flown: interrupted"
    assert load_plan("plan.json").flown is None


def test_given_connections_are_not_flown(cli: Cli) -> None:
    """Where connections are given there is no trajectory, and the line says that."""
    pytest.importorskip("pyarrow")
    adr_opt.Timetable.from_connections(roads(), as_rows()).instance.save("my.json")
    said = cli("solve", "my.json", "--method", "greedy", "--out", "plan.json")
    assert said.out.splitlines()[-1].startswith(
        "not flown: flying does not follow given connections"
    )
    text = cli("check", "my.json", "plan.json").out
    assert "neither flown nor refined: flying does not follow given connections" in text


@pytest.mark.usefixtures("drawn")
def test_a_certificate_names_the_plan_with_its_flight(cli: Cli) -> None:
    """The digest of the plan in a certificate is that of the file as it stands in the end."""
    call = ("solve", "my.json", "--method", "exact", "--time-limit", "20", "--out", "plan.json")
    assert cli(*call, "--certificate", "proof.json").status == 0
    assert load_plan("plan.json").own_flight is not None
    assert cli("verify", "my.json", "plan.json", "proof.json").status == 0
