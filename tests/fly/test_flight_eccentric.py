"""Legs between eccentric orbits: the true miss, and what arriving after all costs."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import adr_opt
from adr_opt.common.constants import MU_M3_S2
from adr_opt.fly.flight import fly
from adr_opt.fly.trajectory import body_states, propagate
from adr_opt.kernels.core.cache import used
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.plan.plan import Plan, load_plan
from adr_opt.problem.instance import Instance

pytest.importorskip("boinor.bodies")

from adr_opt.fly.flight.retargeted import Aim
from adr_opt.fly.flight.two_body import TwoBody, fly_eccentric

NEW_FIELDS = {
    "true_miss_m",
    "true_relative_speed_m_s",
    "last_arc_delta_v_m_s",
    "lambert_delta_v_m_s",
    "correction_delta_v_m_s",
    "correction_time_s",
    "eccentricity_delta_v_m_s",
}


PAGE = Path(__file__).parents[2] / "docs/true-orbits.md"


@pytest.fixture(scope="module")
def two_body() -> TwoBody:
    return TwoBody()


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
    assert all(leg.eccentric is None for leg in flight.legs)
    assert all(tank.flown_delta_v_m_s == tank.planned_delta_v_m_s for tank in flight.tanks)
    assert flight.worst_true_miss_m == flight.worst_miss_m
    assert flight.correction_delta_v_m_s == 0.0


@pytest.mark.slow
def test_the_true_miss_is_what_the_target_is_off_its_circle() -> None:
    """From the circular station the chaser flies as planned, so the target alone is elsewhere."""
    instance, plan = ellipses(0.01)
    leg, flown = plan.legs[0], fly(instance, plan).legs[0]
    assert leg.origin in instance.station_names
    time = next(burn.time_s for burn in leg.burns if burn.phase == "approach")
    speed = np.linalg.norm(body_states(instance, leg.destination, time, true_orbits=True)[1])
    lag = instance.transfer.standoff_m / speed
    true = body_states(instance, leg.destination, time - lag, true_orbits=True)[0][0]
    planned, ahead = (state[0] for state in body_states(instance, leg.destination, time))
    planned = planned - instance.transfer.standoff_m * ahead / np.linalg.norm(ahead)
    assert flown.eccentric is not None
    assert flown.eccentric.true_miss_m == pytest.approx(np.linalg.norm(true - planned), abs=1.0)
    # An ellipse leaves its circle by up to 2ae along the track.
    assert 1e3 < flown.eccentric.true_miss_m < 2.2 * 0.01 * 7.2e6
    assert flown.miss_m < 1e-3


@pytest.mark.slow
def test_miss_and_correction_vanish_with_the_eccentricity() -> None:
    """A hundredth of the eccentricity: a hundredth of the miss, and of the correction at most."""
    large, small = (fly(*ellipses(e)) for e in (1e-4, 1e-6))
    assert [leg.destination for leg in large.legs] == [leg.destination for leg in small.legs]
    for before, after in zip(large.legs, small.legs, strict=True):
        if before.eccentric is None or after.eccentric is None:
            continue
        ratio = after.eccentric.true_miss_m / before.eccentric.true_miss_m
        assert ratio == pytest.approx(0.01, rel=0.05)
        # At right angles to a burn a correction is even of second order.
        shrunk = after.eccentric.correction_delta_v_m_s
        assert abs(shrunk) < 0.016 * abs(before.eccentric.correction_delta_v_m_s)
    assert small.worst_true_miss_m is not None
    assert small.worst_true_miss_m < 50.0
    assert small.correction_delta_v_m_s is not None
    assert small.correction_delta_v_m_s < 0.05


def test_what_boinor_compiles_is_kept() -> None:
    """Functions of boinor that take seconds to compile are files in the cache of the kernels."""
    fly(*ellipses(0.01))
    kept = {file.name.partition("-")[0] for file in used()}
    assert kept >= {
        "boinor.core.elements.coe2rv",
        "boinor.core.iod.izzo",
        "boinor.core.propagation.vallado.vallado",
    }


def test_the_flight_of_a_plan_adds_up() -> None:
    """The totals are those of the legs, and the best correction is no dearer than the whole arc."""
    instance, plan = ellipses(0.01)
    flight = fly(instance, plan)
    told = flight.to_dict()
    assert len(flight.eccentric) >= 1
    for entry in told["legs"]:
        if instance.stations[0].name == entry["origin"] == entry["destination"]:
            continue
        assert set(entry) >= NEW_FIELDS
        assert entry["correction_delta_v_m_s"] <= (
            entry["lambert_delta_v_m_s"] - entry["last_arc_delta_v_m_s"] + 1e-9
        )
    assert told["worst_true_miss_m"] == max(entry["true_miss_m"] for entry in told["legs"])
    assert told["correction_delta_v_m_s"] == pytest.approx(
        sum(entry["correction_delta_v_m_s"] for entry in told["legs"])
    )
    assert told["eccentricity_delta_v_m_s"] == pytest.approx(
        sum(leg.eccentricity_delta_v_m_s for leg in plan.legs)
    )


def test_the_correction_is_what_an_arc_that_arrives_costs(two_body: TwoBody) -> None:
    """Flown again by other means, the corrected arc costs what is told and arrives."""
    instance, plan = ellipses(0.01)
    leg, flown = plan.legs[0], fly(instance, plan).legs[0].eccentric
    assert flown is not None
    approach = next(i for i, burn in enumerate(leg.burns) if burn.phase == "approach")
    end = leg.burns[approach].time_s
    r, v = (s[0] for s in body_states(instance, leg.origin, leg.departure_s, true_orbits=True))
    now, spent = leg.departure_s, 0.0
    for burn in leg.burns[: approach - 1]:
        r, v = (s[0] for s in propagate(r, v, [burn.time_s - now]))
        now = burn.time_s
        if burn.phase == "terminal":
            if flown.correction_time_s == now:
                break  # the Lambert arc replaces the whole of the last arc
            spent = math.hypot(*burn.delta_v_m_s)
        v = v + np.array(burn.delta_v_m_s)
    r, v = (s[0] for s in propagate(r, v, [flown.correction_time_s - now]))
    speed = np.linalg.norm(body_states(instance, leg.destination, end, true_orbits=True)[1])
    lag = instance.transfer.standoff_m / speed
    goal, pace = (s[0] for s in body_states(instance, leg.destination, end - lag, true_orbits=True))
    rest = end - flown.correction_time_s
    leaving, arriving = two_body.lambert(r, goal, rest, np.cross(goal, pace))
    reached = propagate(r, leaving, [rest])[0][0]
    assert np.linalg.norm(reached - goal) < 0.01
    spent += np.linalg.norm(leaving - v) + np.linalg.norm(pace - arriving)
    assert flown.correction_delta_v_m_s + flown.last_arc_delta_v_m_s == pytest.approx(
        spent, abs=1e-6
    )


def test_lambert_finds_the_orbit_that_is_there(two_body: TwoBody) -> None:
    """Two points of an orbit and the time between them give its velocities, in every plane."""
    rng = np.random.default_rng(7)
    for _ in range(200):
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        if np.linalg.det(axes) < 0.0:
            axes = -axes
        e, radius = rng.uniform(0.0, 0.5), rng.uniform(6.8e6, 9e6)
        speed = math.sqrt(MU_M3_S2 * (1.0 + e) / radius)
        r, v = axes @ [radius, 0.0, 0.0], axes @ [0.0, speed, 0.0]
        period = 2.0 * math.pi * math.sqrt((radius / (1.0 - e)) ** 3 / MU_M3_S2)
        time = period * rng.choice([rng.uniform(0.05, 0.45), rng.uniform(0.55, 0.95)])
        ends, paces = propagate(r, v, [time])
        leaving, arriving = two_body.lambert(r, ends[0], time, np.cross(r, v))
        assert np.linalg.norm(leaving - v) < 1e-4
        assert np.linalg.norm(arriving - paces[0]) < 1e-4


def test_lambert_without_an_answer_is_an_error(two_body: TwoBody) -> None:
    """Points on one line through the Earth have no plane, and nothing is made up for them."""
    r = np.array([7e6, 0.0, 0.0])
    for end in (-r, 2.0 * r):
        with pytest.raises(ArithmeticError, match="Lambert"):
            two_body.lambert(r, end, 3000.0, np.array([0.0, 0.0, 1.0]))


def test_what_cannot_be_flown_is_unknown(two_body: TwoBody) -> None:
    """A true flight that leaves the Earth has no miss and no correction, and is no error."""
    _, plan = ellipses(0.01)
    r = np.array([7e6, 0.0, 0.0])
    escape, circle = (r, np.array([0.0, 12e3, 0.0])), (r, np.array([0.0, 7.5e3, 0.0]))
    flown = fly_eccentric(two_body, escape, circle, plan.legs[0], 1000.0)
    assert flown.true_miss_m is None
    assert flown.lambert_delta_v_m_s is None
    assert flown.correction_delta_v_m_s is None
    assert flown.last_arc_delta_v_m_s > 0.0


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
    assert f"{flight.worst_true_miss_m:.4g} m" in flown.notes[-1]
    assert f"{flight.correction_delta_v_m_s:.2f} m/s" in flown.notes[-1]
    assert cli("check", "my.json", "flown.json").status == 0
    assert cli("fly", "my.json", "plan.json", "--out", "my.json").status == 2


def test_the_table_of_the_page_is_what_comes_out() -> None:
    """docs/true-orbits.md shows misses and corrections of the tiny field as the code gives them."""
    page = PAGE.read_text(encoding="utf-8")
    rows = re.findall(r"^\| (0\.\d+) \| (.*) \|$", page, re.MULTILINE)
    assert len(rows) == 3
    for e, cells in rows:
        instance, plan = ellipses(float(e), seed=0, delta_v_m_s=1000.0)
        flight = fly(instance, plan)
        whole = sum(leg.lambert_delta_v_m_s - leg.last_arc_delta_v_m_s for leg in flight.eccentric)
        assert [float(cell) for cell in cells.split(" | ")] == pytest.approx(
            [
                len(flight.eccentric),
                flight.worst_true_miss_m / 1e3,
                flight.eccentricity_delta_v_m_s,
                flight.correction_delta_v_m_s,
                whole,
            ],
            rel=0.02,
        )
    assert all(f"`{field}`" in page for field in NEW_FIELDS)


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
    assert "was not led to its target" in str(flight.broken_tanks[0])
    assert flight.true_delta_v_m_s is None
    assert flight.to_dict()["holds"] is False
