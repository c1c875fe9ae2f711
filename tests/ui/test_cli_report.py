"""`report`: the page is written, or one sentence says why not."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from conftest import Cli, refused
from plans import solved

import adr_opt
import adr_opt.fly.flight
from adr_opt.fly.flight.tanks import tanks_of
from adr_opt.plan.refined_plan import Missing
from adr_opt.ui.report.text import fixed

pytest.importorskip("plotly.graph_objects")


def test_verb(cli: Cli, tiny_file: Path) -> None:
    """`report` writes the page; with --json standard output is one object that describes it."""
    assert cli("solve", tiny_file, "--method", "greedy-guarded", "--out", "plan.json").status == 0
    outcome = cli("report", tiny_file, "plan.json", "--out", "mission.html", "--json")
    assert outcome.status == 0
    said = json.loads(outcome.out)
    written = Path("mission.html")
    assert said["path"] == "mission.html"
    assert said["bytes"] == written.stat().st_size
    assert said["violations"] == []
    assert written.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    outcome = cli("report", tiny_file, "plan.json", "--out", "mission.html", "--quiet")
    assert (outcome.status, outcome.out, outcome.err) == (0, "", "")


def test_verb_counts_violations(cli: Cli, tiny_file: Path) -> None:
    """A plan with violations is reported, and the program says how many there are."""
    plan = solved(adr_opt.load(tiny_file))
    plan.replace(objective=plan.objective + 1.0).save("wrong.json")
    outcome = cli("report", tiny_file, "wrong.json", "--out", "mission.html", "--json")
    assert outcome.status == 0
    assert json.loads(outcome.out)["violations"][0]["rule"] == "objective"
    assert "wrong.json: the plan has 1 violation; the page begins with it" in outcome.err


@pytest.mark.parametrize(
    ("out", "named"),
    [
        ("nowhere/mission.html", "nowhere/mission.html: the folder nowhere does not exist"),
        (".", ".: this is a folder"),
        ("tiny.json", "tiny.json: this is the input"),
        ("plan.json", "plan.json: this is the input"),
    ],
)
def test_a_place_that_cannot_be_written(cli: Cli, tiny_file: Path, out: str, named: str) -> None:
    """A bad place for the page is one sentence that names it."""
    solved(adr_opt.load(tiny_file)).save("plan.json")
    outcome = cli("report", tiny_file, "plan.json", "--out", out)
    assert outcome.status == 2
    assert outcome.err.startswith(f"adr-opt: {named}")
    assert outcome.err.count("\n") == 1


def test_a_plan_of_another_instance(cli: Cli, tiny_file: Path) -> None:
    """The plan of another instance is refused by name, and nothing is written."""
    solved(adr_opt.generate("tiny", 1)).save("plan.json")
    outcome = cli("report", tiny_file, "plan.json", "--out", "mission.html")
    assert outcome.status == 2
    assert outcome.err.startswith("adr-opt: plan.json: the plan belongs to the instance 'tiny-001'")
    assert not Path("mission.html").exists()


def test_without_plotly(cli: Cli, tiny_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A missing plotly is named together with the extra that installs it."""
    solved(adr_opt.load(tiny_file)).save("plan.json")
    for name in [name for name in sys.modules if name.split(".")[0] == "plotly"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "plotly", None)
    outcome = cli("report", tiny_file, "plan.json", "--out", "mission.html")
    assert outcome.status == 2
    assert "plotly" in outcome.err
    assert "pip install 'adr-opt[viz]'" in outcome.err
    assert not Path("mission.html").exists()


def test_what_refined_legs_take_is_told(cli: Cli, tiny_file: Path) -> None:
    """With --refined each leg has its ΔV in true dynamics, and another plan's is refused."""
    instance = adr_opt.load(tiny_file)
    plan = solved(instance)
    plan.save("plan.json")
    refined = adr_opt.refine(instance, plan)
    refined.save("refined.json")
    told = cli("report", tiny_file, "plan.json", "--refined", "refined.json", "--out", "m.html")
    assert told.status == 0, told.err
    text = Path("m.html").read_text(encoding="utf-8")
    assert text.count(">refined m/s<") == 1
    assert f"flown with {fixed(refined.flown_delta_v_m_s, 1)} m/s" in text
    for leg in refined.legs:
        assert f"<td class=n>{fixed(leg.flown_delta_v_m_s, 1)}</td>" in text
    other = refined.replace(plan=refined.plan.replace(sha256="0" * 64))
    other.save("other.json")
    call = ("report", tiny_file, "plan.json", "--refined", "other.json", "--out", "n.html")
    refused(cli(*call), "it was made of a plan by", "not of this one")
    assert not Path("n.html").exists()


def test_flights_are_told_where_they_are_asked_for(cli: Cli, tiny_file: Path) -> None:
    """With --fly each leg has its miss, of the plan and refined; what a refined plan lacks heads.

    Exit status 1 where a leg is missing, and the program says which.
    """
    pytest.importorskip("boinor.bodies")
    instance = adr_opt.load(tiny_file)
    plan = solved(instance)
    plan.save("plan.json")
    refined = adr_opt.refine(instance, plan)
    refined.save("refined.json")
    asked = ("report", tiny_file, "plan.json", "--refined", "refined.json", "--fly")
    told = cli(*asked, "--out", "m.html", "--json")
    assert told.status == 0, told.err
    assert json.loads(told.out)["refined"] == []
    text = Path("m.html").read_text(encoding="utf-8")
    flight, again = (
        adr_opt.fly.flight.fly(instance, plan),
        adr_opt.fly.flight.fly_refined(instance, refined),
    )
    part = text.partition("<h2>Refined and flown</h2>")[2].partition("</section>")[0]
    first, _, second = part.partition("<h3>The plan, refined</h3>")
    for leg in flight.legs:
        assert f"<td class=n>{leg.miss_m:.2g}</td>" in first
    for one, leg in zip(again.legs, refined.legs, strict=True):
        assert f"<td class=n>{max(one.standoff_miss_m, one.arrival_miss_m):.2g}</td>" in second
        assert f"<td class=n>{fixed(leg.retargeted_delta_v_m_s, 1)}</td>" in second
    # Tanks are judged by the refined legs alone, of which one page does not say two things.
    (tank,) = tanks_of(instance, refined)
    assert "Its tanks" not in first
    assert f"<td class=n>{fixed(-tank.over_m_s, 1)}</td><td>holds</td>" in second
    last = Missing(leg=len(plan.legs), reason="interrupted")
    short = refined.replace(status="incomplete", legs=refined.legs[:-1], missing=(last,))
    short.save("refined.json")
    told = cli(*asked, "--out", "m.html", "--json")
    assert told.status == 1
    said = f"leg {last.leg} is missing: interrupted"
    assert json.loads(told.out)["refined"] == [said]
    assert f"refined.json: {said}" in told.err
    text = Path("m.html").read_text(encoding="utf-8")
    alert = text.partition('role="alert"')[2].partition("</section>")[0]
    assert f"<li>{said}</li>" in alert
