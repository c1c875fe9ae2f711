"""``fly`` of plans whose nodes drift: what it measures, says and counts."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli
from drifting_plans import drifting_instance, drifting_plan, with_a_tight_tank
from plans import unjudged, with_legs, write

import adr_opt
from adr_opt.fly.flight import fly
from adr_opt.ui.cli.fly import FLOWN

pytest.importorskip("boinor.bodies")


@pytest.mark.parametrize("eccentricity", [0.0, 0.003])
def test_every_leg_meets_its_stand_off(eccentricity: float) -> None:
    """Short or drifting, a leg misses by less than a metre, and docks when its burns are over."""
    flight = fly(drifting_instance(eccentricity), drifting_plan(eccentricity))
    assert [leg.kind for leg in flight.legs] == ["short", "drift"]
    assert flight.worst_miss_m < 1.0
    for leg in flight.legs:
        assert leg.relative_speed_m_s < 1e-3
        assert leg.arrival_miss_m < 1.0
    assert flight.dynamics == "j2"
    assert all(leg.on_true_orbits == (eccentricity > 0.0) for leg in flight.legs)


def test_planned_and_burned() -> None:
    """Each leg has the ΔV of the plan and that of its impulses, which differ by one vector."""
    plan = drifting_plan()
    short, drift = fly(drifting_instance(), plan).legs
    for leg, flown in zip(plan.legs, (short, drift), strict=True):
        assert flown.planned_delta_v_m_s == leg.delta_v_m_s
        made = dict.fromkeys((burn.time_s for burn in leg.burns), 0.0)
        for burn in leg.burns:
            made[burn.time_s] = made[burn.time_s] + np.array(burn.delta_v_m_s)
        burned = sum(float(np.linalg.norm(vector)) for vector in made.values())
        assert flown.burns_delta_v_m_s == pytest.approx(burned, abs=1e-9)
        assert 0.01 < leg.at_once_m_s < 0.3
    whole = short.burns_delta_v_m_s + plan.legs[0].at_once_m_s
    assert whole == pytest.approx(short.planned_delta_v_m_s, abs=1e-5)
    assert 0.1 < abs(drift.burns_delta_v_m_s - drift.planned_delta_v_m_s) < 10.0


def test_a_shifted_burn_misses() -> None:
    """A little more burned before weeks of drift ends kilometres away, in that leg alone."""
    instance, plan = drifting_instance(), drifting_plan()
    short, drift = plan.legs
    vector = [1.0001 * part for part in drift.burns[0].delta_v_m_s]
    burns = (drift.burns[0].replace(delta_v_m_s=tuple(vector)), *drift.burns[1:])
    flight = fly(instance, unjudged(instance, with_legs(plan, (short, drift.replace(burns=burns)))))
    assert flight.legs[1].miss_m > 1e3
    assert flight.legs[0] == fly(instance, plan).legs[0]


def test_the_burns_of_a_drift_empty_the_tank(cli: Cli) -> None:
    """A tank that is enough for the closed form alone is told to break: exit status 1."""
    instance, plan = drifting_instance(), drifting_plan()
    short, drift = fly(instance, plan).legs
    assert drift.burns_delta_v_m_s > drift.planned_delta_v_m_s
    (tank,) = fly(instance, plan).tanks
    assert tank.planned_delta_v_m_s == pytest.approx(plan.delta_v_m_s)
    burned = short.burns_delta_v_m_s + drift.burns_delta_v_m_s
    assert tank.flown_delta_v_m_s == pytest.approx(burned)
    assert tank.holds
    write(*with_a_tight_tank())
    said = cli("fly", "my.json", "plan.json")
    assert said.status == 1
    assert "is over by" in said.out


def test_fly_says_in_what_it_flew(cli: Cli) -> None:
    """Text and JSON name the dynamics and tell of every leg that drifts; the note is renewed."""
    instance, plan = drifting_instance(0.003), drifting_plan(0.003)
    write(instance, plan)
    said = cli("fly", "my.json", "plan.json", "--out", "flown.json")
    assert said.status == 0
    text = " ".join(said.out.split())
    assert "over 2 legs in mean motion under J2" in text
    drift = plan.legs[1]
    planned, burned = drift.delta_v_m_s, drift.burns_delta_v_m_s
    assert f"1 leg that drifts, planned with {planned:.1f} m/s, burns {burned:.1f} m/s" in text
    flight = fly(instance, plan)
    assert flight.true_delta_v_m_s is not None
    true = f"2 legs planned with {plan.delta_v_m_s:.1f} m/s, and flown with "
    assert f"{true}{flight.true_delta_v_m_s:.1f} m/s by retargeted burns" in text
    assert cli("fly", "my.json", "flown.json", "--out", "again.json").status == 0
    notes = [note for note in adr_opt.load_plan("again.json").notes if "flown in" in note]
    (note,) = notes
    assert note.startswith(FLOWN["j2"])
    told = json.loads(cli("fly", "my.json", "plan.json", "--json").out)
    assert (told["dynamics"], told["between_circles"]) == ("j2", False)
    assert told["tanks"][0]["flown_delta_v_m_s"] == pytest.approx(told["true_delta_v_m_s"])
    assert [leg["kind"] for leg in told["legs"]] == ["short", "drift"]
    assert told["legs"][1]["burns_delta_v_m_s"] == pytest.approx(burned)
    assert told["legs"][1]["planned_delta_v_m_s"] == planned


def test_export_tells_dynamics_and_states(cli: Cli) -> None:
    """``export --json`` names the dynamics and counts states: five times fewer by default."""
    write(drifting_instance(), drifting_plan())
    counts = []
    for options in ((), ("--step", "60")):
        told = json.loads(
            cli("export", "my.json", "plan.json", "--out", "a.oem", *options, "--json").out
        )
        assert told["dynamics"] == "j2"
        lines = Path("a.oem").read_text(encoding="ascii").splitlines()
        assert told["states"] == sum(line.startswith("20") for line in lines)
        counts.append(told["states"])
    assert 3.5 < counts[1] / counts[0] < 5.0
