"""Launches, kits and masses as people see them: every verb on a plan that has them."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import browser
import pytest
from conftest import Cli
from launched import DRY_KG, KIT_KG, PROPELLANT_KG, campaign, planned

import adr_opt
from adr_opt.plan.cargo import followed
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import load_refined
from adr_opt.plan.routes import routes_of
from adr_opt.problem.chasers import Tank
from adr_opt.problem.instance import Instance
from adr_opt.ui.cli.timeline import by_chaser

DAY_S = 86400.0


@pytest.fixture(params=["two-body", pytest.param("j2", marks=pytest.mark.slow)])
def files(request: pytest.FixtureRequest, cli: Cli) -> tuple[Instance, Plan]:
    """A campaign and a plan of it, in files a.json and p.json."""
    instance, plan = campaign(request.param), planned(request.param)
    Path("a.json").write_text(instance.to_json(), encoding="utf-8")
    plan.save("p.json")
    return instance, plan


def done(cli: Cli, line: str) -> str:
    """What a command prints that must work."""
    outcome = cli(*line.split())
    assert outcome.status == 0, (line, outcome)
    return outcome.out


def test_solve_says_what_each_chaser_carries(files: tuple[Instance, Plan], cli: Cli) -> None:
    """Masses add up: with what is burned and left behind, launch and end differ by nothing else."""
    instance, plan = files
    said = done(cli, "solve a.json --time-limit 5")
    pattern = (
        r"(chaser-\d): at launch ([\d.]+) kg with 80 kg of propellant and (\d) kits of 20 kg, "
        r"uses ([\d.]+) kg, ends with ([\d.]+) kg and ([\d.]+) kg of propellant"
    )
    found = re.findall(pattern, said)
    assert [name for name, *_ in found] == ["chaser-1", "chaser-2"]
    for _, *numbers in found:
        start, kits, used, end, left = map(float, numbers)
        assert start == DRY_KG + PROPELLANT_KG + KIT_KG * kits
        assert left == pytest.approx(PROPELLANT_KG - used, abs=0.11)
        assert end == pytest.approx(DRY_KG + left, abs=0.11)
    for flown in routes_of(instance, plan):
        load = flown.carried(instance)
        assert load.end_mass_kg == flown.legs[-1][1].mass_kg
        burned, kits = 0.0, 0
        masses = [load.mass_kg, *(leg.mass_kg for _, leg in flown.legs)]
        for before, after, (_, leg) in zip(masses, masses[1:], flown.legs, strict=False):
            assert before is not None
            assert after is not None
            burned += before - after - KIT_KG
            kits += 1
            ratio = (after + KIT_KG) / before
            assert ratio == pytest.approx(math.exp(-leg.delta_v_m_s / (300.0 * 9.80665)), rel=1e-9)
        assert load.used_kg == pytest.approx(burned, rel=1e-9)
        assert load.kits == kits


def test_kits_that_are_used_up_are_the_reason() -> None:
    """With no kit left a target near by is left out for that, and not for a lack of ΔV."""
    instance = campaign(chasers=1, kits=1)
    plan = adr_opt.solve(instance, time_limit=60.0).plan
    assert plan is not None
    assert {left.reason for left in plan.unvisited} <= {"kits", "several", "no-transfer"}
    assert "kits" in {left.reason for left in plan.unvisited}
    said = list(by_chaser(instance, plan))
    assert any(line.startswith("left out, kits (one more leg would reach it") for line in said)
    assert any(line.startswith("chaser-1: at launch 300.0 kg with 80 kg") for line in said)
    enough = adr_opt.solve(
        instance.replace(chasers=tuple(c.replace(max_targets=1) for c in instance.chasers)),
        time_limit=60.0,
    ).plan
    assert enough is not None
    assert "capacity" in {left.reason for left in enough.unvisited}


def test_kits_without_masses_are_told(cli: Cli) -> None:
    """A tank in ΔV has no masses to tell, but kits."""
    drawn = campaign("two-body")
    instance = drawn.replace(
        chasers=tuple(
            chaser.replace(tank=Tank(delta_v_m_s=900.0), kit_mass_kg=0.0)
            for chaser in drawn.chasers
        )
    )
    plan = adr_opt.solve(instance, time_limit=60.0).plan
    assert plan is not None
    said = list(by_chaser(instance, plan))
    assert "chaser-1: carries 3 kits" in said
    assert not any(" kg" in line for line in said)


@pytest.mark.slow
def test_every_verb_takes_a_launch(files: tuple[Instance, Plan], cli: Cli) -> None:
    """The plan is flown, refined, flown with errors, reported, exported, and a start of another."""
    pytest.importorskip("boinor")
    pytest.importorskip("plotly")
    instance, plan = files
    assert "no violations" in done(cli, "check a.json p.json")
    assert "every tank holds" in done(cli, "fly a.json p.json")
    done(cli, "refine a.json p.json --out r.json")
    refined = load_refined("r.json")
    assert refined.missing == ()
    launches = [n for n, leg in enumerate(plan.legs, start=1) if leg.kind == "launch"]
    assert len(launches) == 2
    assert {leg.leg for leg in refined.legs} == {*range(1, len(plan.legs) + 1)} - {*launches}
    assert "every tank holds" in done(cli, "fly a.json r.json")
    assert "holds; it breaks in 0 %" in done(cli, "fly a.json r.json --samples 10")
    done(cli, "report a.json p.json --refined r.json --out page.html")
    done(cli, "export a.json p.json --out all.czml")
    assert {"chaser-1", "chaser-2"} <= {
        packet.get("name") for packet in json.loads(Path("all.czml").read_text("utf-8"))
    }
    for chaser, flown in zip(instance.chasers, routes_of(instance, plan), strict=True):
        for suffix in ("oem", "opm", "script"):
            done(cli, f"export a.json p.json --chaser {chaser.name} --out {chaser.name}.{suffix}")
        done(cli, f"export a.json r.json --chaser {chaser.name} --out {chaser.name}-refined.oem")
        first = flown.legs[0][0]
        done(cli, f"export a.json p.json --leg {first} --out launch.oem")
        outcome = cli("export", "a.json", "r.json", "--leg", f"{first}", "--out", "none.oem")
        assert outcome.status == 2
        assert outcome.err.count("\n") == 1
    done(cli, "solve a.json --start p.json --time-limit 5 --out again.json")
    again = adr_opt.load_plan("again.json")
    assert again.objective >= plan.objective
    done(cli, "solve a.json --refine --rounds 2 --time-limit 5 --out held.json")
    assert adr_opt.check(instance, adr_opt.load_plan("held.json")) == ()


def test_the_page_has_masses(files: tuple[Instance, Plan]) -> None:
    """The tables of chasers and legs state mass, kits and propellant, where there are any."""
    pytest.importorskip("plotly")
    from adr_opt.ui.report import tables

    instance, plan = files
    loads = tables.loads(instance, plan)
    for title in ("mass at the start kg", "kits", "propellant kg", "used kg", "left kg"):
        assert f">{title}</th>" in loads
    for flown in routes_of(instance, plan):
        load = flown.carried(instance)
        cells = [f"{load.mass_kg:.1f}", f"{load.kits}", f"{load.propellant_kg:.1f}"]
        cells += [f"{load.used_kg:.1f}", f"{load.left_kg:.1f}", f"{load.end_mass_kg:.1f}"]
        assert "".join(f"<td class=n>{cell}</td>" for cell in cells) in loads
    legs = tables.legs(instance, plan)
    assert ">mass kg</th>" in legs
    assert all(f"<td class=n>{leg.mass_kg:.1f}</td>" in legs for leg in plan.legs)
    bare = adr_opt.generate("tiny", 0)
    other = adr_opt.solve(bare, "greedy").plan
    assert other is not None
    assert tables.loads(bare, other) == ""
    assert " kg</th>" not in tables.legs(bare, other)


@pytest.mark.slow
def test_the_page_of_one_chaser_says_what_it_carries() -> None:
    """One chaser has no lanes, but a table of what it carries."""
    pytest.importorskip("plotly")
    from adr_opt.ui.report import page

    text = page(campaign(chasers=1), planned(chasers=1))
    assert "What the chaser carries" in text
    assert 'id="lanes"' not in text


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.slow
def test_the_page_looks_right_in_a_browser(tmp_path: Path, width: int) -> None:
    """It opens without complaints, is no wider than the window, and its tables scroll."""
    pytest.importorskip("plotly")
    from adr_opt.ui.report import write_report

    write_report(campaign(), planned(), tmp_path / "page.html")
    with browser.Browser(tmp_path / "profile", width=width) as tab:
        tab.open_report(tmp_path / "page.html")
        assert tab.evaluate("document.querySelectorAll('.chart.js-plotly-plot').length") == 11


def test_masses_after_launches_are_of_the_kits_of_the_route() -> None:
    """A launch leaves a kit behind at once, so less than at launch goes on, with a full tank."""
    instance, plan = campaign(), planned()
    for flown in routes_of(instance, plan):
        start, first, *_ = followed(instance, flown.chaser, flown.spent)
        assert start.mass_kg is not None
        assert first.mass_kg == pytest.approx(start.mass_kg - KIT_KG)
        assert first.left_m_s > start.left_m_s
