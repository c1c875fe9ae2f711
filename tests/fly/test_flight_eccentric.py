"""Legs between eccentric orbits: what arriving there costs, tank by tank."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import adr_opt
from adr_opt.fly.flight import fly
from adr_opt.kernels.core.cache import used
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.plan.plan import Plan, load_plan
from adr_opt.problem.instance import Instance

pytest.importorskip("boinor.bodies")

from adr_opt.fly.flight.retargeted import Aim


def ellipses(e: float, seed: int = 4, delta_v_m_s: float = 4000.0) -> tuple[Instance, Plan]:
    """A tiny field with targets of eccentricity e, and a plan for it."""
    tiny = adr_opt.generate("tiny", seed)
    instance = tiny.replace(
        targets=tuple(
            target.replace(
                orbit=target.orbit.replace(eccentricity=e, argument_of_perigee_deg=80.0 * number)
            )
            for number, target in enumerate(tiny.targets)
        )
    ).with_limits(delta_v_m_s=delta_v_m_s)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    assert len(plan.legs) > 1
    return instance, plan


@pytest.mark.slow
def test_circles_tell_nothing_new() -> None:
    """Legs between circles have no further fields, alone or beside eccentric ones."""
    tiny = adr_opt.generate("tiny", 4)
    plan = adr_opt.solve(tiny, "greedy-guarded").plan
    assert plan is not None
    flight = fly(tiny, plan)
    assert set(flight.to_dict()) == {"dynamics", "worst_miss_m", "holds", "tanks", "legs"}
    assert flight.true_legs == ()
    # Two burns of one instant are flown as one vector.
    for tank in flight.tanks:
        assert 0.0 <= tank.planned_delta_v_m_s - tank.flown_delta_v_m_s < 0.3 * len(plan.legs)


def test_what_boinor_compiles_is_kept() -> None:
    """Functions of boinor that take seconds to compile are files in the cache of the kernels."""
    fly(*ellipses(0.01))
    kept = {file.name.partition("-")[0] for file in used()}
    assert kept >= {"boinor.core.elements.coe2rv", "boinor.core.propagation.vallado.vallado"}


def test_the_plan_carries_the_size_of_the_approximation(cli, tmp_path) -> None:
    """``fly --out`` writes the plan with one note of its flight; ``check`` still finds nothing."""
    instance, plan = ellipses(0.01)
    (tmp_path / "my.json").write_text(instance.to_json(), encoding="utf-8")
    plan.save(tmp_path / "plan.json")
    for source in ("plan.json", "flown.json"):  # the second time the note takes its own place
        done = cli("fly", "my.json", source, "--out", "flown.json")
        assert done.status == 0
        assert "on the true orbits: 5 legs planned with" in done.out
        flown = load_plan(tmp_path / "flown.json")
        assert flown.replace(notes=plan.notes) == plan
        assert len(flown.notes) == len(plan.notes) + 1
    flight = fly(instance, plan)
    assert f"{flight.true_delta_v_m_s:.1f} m/s by retargeted burns" in flown.notes[-1]
    assert cli("check", "my.json", "flown.json").status == 0
    assert cli("fly", "my.json", "plan.json", "--out", "my.json").status == 2


def on_budget(instance: Instance, plan: Plan, delta_v_m_s: float) -> tuple[Instance, Plan]:
    """The instance with another tank, and the same legs on it."""
    other = instance.with_limits(delta_v_m_s=delta_v_m_s)
    mission = Mission(other)
    again = certify(mission, "again", mission.numbers(plan.destinations), seed=0, runtime_s=0.0)
    assert again.plan is not None
    return other, again.plan


@pytest.fixture(scope="module")
def breaking() -> tuple[Instance, Plan, float]:
    """A plan that is legal in the model, whose second tank is too small in truth; by how much."""
    instance, plan = ellipses(0.01, seed=22, delta_v_m_s=600.0)
    first, second = fly(instance, plan).tanks
    assert first.flown_delta_v_m_s < second.planned_delta_v_m_s
    assert second.planned_delta_v_m_s + 10.0 < second.flown_delta_v_m_s
    budget = (second.planned_delta_v_m_s + second.flown_delta_v_m_s) / 2.0
    return *on_budget(instance, plan, budget), second.flown_delta_v_m_s - budget


def test_a_tank_gives_what_the_aimed_burns_take() -> None:
    """Tank by tank: the burns between circles, and those that are aimed at eccentric orbits."""
    instance, plan = ellipses(0.01, seed=5, delta_v_m_s=600.0)
    flight = fly(instance, plan)
    assert len(flight.tanks) == 1 + plan.destinations.count(instance.stations[0].name) > 1
    assert [tank.tank for tank in flight.tanks] == list(range(1, len(flight.tanks) + 1))
    seen = []
    for tank in flight.tanks:
        legs = range(tank.first_leg - 1, tank.last_leg)
        seen += legs
        taken = [
            leg.true_delta_v_m_s if leg.on_true_orbits else leg.burns_delta_v_m_s
            for leg in (flight.legs[at] for at in legs)
        ]
        assert tank.flown_delta_v_m_s == pytest.approx(sum(taken), abs=1e-6)
        assert plan.legs[tank.last_leg - 1].destination in instance.station_names or (
            tank.last_leg == len(plan.legs)
        )
    assert seen == list(range(len(plan.legs)))


def test_a_plan_that_breaks_a_tank_is_no_answer(breaking, cli, tmp_path: Path) -> None:
    """`check` finds nothing, and `fly` says which tank is over by how much and ends with 1."""
    instance, plan, over = breaking
    assert adr_opt.check(instance, plan) == ()
    (tmp_path / "my.json").write_text(instance.to_json(), encoding="utf-8")
    plan.save(tmp_path / "plan.json")
    said = cli("fly", "my.json", "plan.json", "--out", "flown.json", "--quiet")
    assert said.status == 1
    assert said.err == ""
    home = plan.destinations.index(instance.stations[0].name) + 1
    legs = f"legs {home + 1} to {len(plan.legs)}"
    sentence = f"tank 2 ({legs}) of {instance.chaser.tank.delta_v_m_s:g} m/s"
    assert f"{sentence} is over by {over:.1f} m/s" in said.out
    assert sentence in load_plan(tmp_path / "flown.json").notes[-1]
    told = cli("fly", "my.json", "plan.json", "--json")
    assert told.status == 1
    content = json.loads(told.out)
    assert content["holds"] is False
    assert [tank["holds"] for tank in content["tanks"]] == [True, False]
    assert content["tanks"][1]["over_m_s"] == pytest.approx(over, abs=1e-6)


def test_a_plan_within_its_tanks_is_one(breaking, cli, tmp_path: Path) -> None:
    """With a little more in the tank the same legs hold, and `fly` ends with 0."""
    instance, plan, over = breaking
    roomy, plan = on_budget(instance, plan, instance.chaser.tank.delta_v_m_s + over + 1.0)
    (tmp_path / "my.json").write_text(roomy.to_json(), encoding="utf-8")
    plan.save(tmp_path / "plan.json")
    said = cli("fly", "my.json", "plan.json", "--out", "flown.json")
    assert said.status == 0
    assert "every tank holds" in said.out
    assert "is left with 1.0 of" in said.out
    assert said.err == "adr-opt: wrote flown.json\n"


def test_a_tank_with_a_leg_that_does_not_arrive_does_not_hold(monkeypatch) -> None:
    """Where no burns lead to a target, the tank is not said to hold, and its cost is not known."""
    instance, plan = ellipses(0.01)

    def lost(*arguments: object) -> float:
        raise ArithmeticError

    monkeypatch.setattr(Aim, "delta_v_m_s", lost)
    flight = fly(instance, plan)
    assert flight.broken_tanks
    assert flight.broken_tanks[0].flown_delta_v_m_s is None
    assert "was not guided to its target" in str(flight.broken_tanks[0])
    assert flight.true_delta_v_m_s is None
    assert flight.to_dict()["holds"] is False
