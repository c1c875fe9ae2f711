"""The format 2 of instances and plans: what may be stated, and how bodies are numbered."""

from __future__ import annotations

import json
import pickle
from typing import Any

import jsonschema
import numpy as np
import pytest
from random_rules import DRAWS, drifting_mission, random_mission
from seeds import over_seeds

import adr_opt
from adr_opt import Instance, Plan
from adr_opt.common.errors import InputError
from adr_opt.kernels.orbits.ephemeris import ORBIT_COLUMNS
from adr_opt.plan.plan import cost_of
from adr_opt.problem.chasers import InOrbit, free_name
from adr_opt.problem.settings import MissionSettings, Objective

NOT_WRITTEN = (
    "frame object_id ephemerides fit decay_m_per_day prize_until disposal thrust_n "
    "initial_delta_v_m_s initial_propellant_kg expense duty_cycle max_refuellings time_m_s_per_day "
    "max_propellant_kg launch_separation_s mission_separation_s max_leg_s approach keep_out_m "
    "approach_revolutions inspection_revolutions burns disposal_altitude_m windows_s "
    "capture_s windows"
)
"""Fields that stand in no file which does not set them."""

KINDS = {kind: draw for kind, draw in DRAWS.items() if kind != "given"}
FAMILIES = ("tiny", "electric", "rocket-bodies", "sso")


@pytest.mark.parametrize("kind", [*KINDS, *FAMILIES])
def test_what_is_set_is_written_and_nothing_else(kind: str) -> None:
    """Instances of every kind are read as they were, digest included; tiny ones set nothing."""
    if kind in KINDS:
        instance = next(one for one in map(KINDS[kind], range(9)) if one.given is None)
    else:
        instance = adr_opt.generate(kind, 3, zones=2 if kind == "tiny" else 0)
    text = instance.to_json()
    again = Instance.from_json(text)
    assert (again, again.to_json(), again.sha256) == (instance, text, instance.sha256)
    assert pickle.loads(pickle.dumps(instance)) == instance
    jsonschema.validate(json.loads(text), Instance.json_schema())
    if kind == "tiny":
        assert not [field for field in NOT_WRITTEN.split() if f'"{field}"' in text]


@over_seeds(range(60), gate=20)
def test_bodies_are_stations_then_the_start_then_targets(*, seed: int) -> None:
    """Names, orbits, the first target, the start and parts follow one numbering."""
    instance = drifting_mission(seed)
    names = [station.name for station in instance.stations]
    names += [instance.chaser.name] if isinstance(instance.chaser.start, InOrbit) else []
    first = len(names)
    names += [target.name for target in instance.targets]
    assert list(instance.names) == names
    assert instance.first_target == first
    assert names[instance.start] == instance.chaser.start_name
    assert len(instance.body_orbits) == len(names)
    for number, target in enumerate(instance.targets, start=first):
        assert instance.body_orbits[number] == target.orbit
    assert instance.orbits().shape == (len(names), len(ORBIT_COLUMNS))
    assert instance.eccentricity_delta_v().shape == (len(names), len(names))
    part = instance.part([first + 2, first, 0])
    assert part.targets == (instance.targets[0], instance.targets[2])
    assert part.names[:first] == instance.names[:first]


@over_seeds(range(60), gate=20)
def test_nothing_drifts_in_two_body_motion(*, seed: int) -> None:
    """Long transfers are refused exactly where the dynamics are two-body."""
    instance = (random_mission, drifting_mission)[seed % 2](seed)
    longest_s = float(np.random.default_rng(seed).uniform(1e-3, 1e9))
    longer = instance.transfer.replace(max_drift_s=longest_s)
    if instance.dynamics == "j2":
        assert instance.replace(transfer=longer).transfer.max_drift_s == longest_s
        return
    with pytest.raises(adr_opt.InputError, match="no plane drifts in two-body motion"):
        instance.replace(transfer=longer)
    assert instance.replace(transfer=longer, dynamics="j2").transfer.max_drift_s == longest_s


def test_limits_are_changed_together() -> None:
    """A variant has the limits that are given, keeps the others, and is held to their ranges."""
    instance = adr_opt.generate("tiny", 1)
    both = instance.with_limits(1e5, 900.0)
    assert (both.mission.duration_s, both.chaser.tank.delta_v_m_s) == (1e5, 900.0)
    assert both.with_limits(duration_s=2e5).chaser.tank.delta_v_m_s == 900.0
    assert both.with_limits(delta_v_m_s=1.0).mission.duration_s == 1e5
    assert instance.with_limits() == instance
    for limits in ({"duration_s": -1.0}, {"delta_v_m_s": np.nan}):
        with pytest.raises(adr_opt.InputError, match=next(iter(limits))):
            instance.with_limits(**limits)


def test_service_is_stated_once() -> None:
    """Revolutions are the default, seconds take their place, and the file holds one of them."""
    one = MissionSettings(duration_s=1.0)
    assert (one.service_revolutions, one.service_s) == (1.0, None)
    other = MissionSettings(duration_s=1.0, service_s=60.0)
    assert (other.service_revolutions, other.service_s) == (None, 60.0)
    assert "service_s" not in one.model_dump(mode="json")
    assert "service_revolutions" not in other.model_dump(mode="json")
    assert other.replace(duration_s=2.0).service_s == 60.0
    with pytest.raises(adr_opt.InputError, match="exactly one"):
        one.replace(service_s=60.0)
    with pytest.raises(adr_opt.InputError, match="exactly one"):
        one.replace(service_revolutions=None)
    assert one.replace(service_s=60.0, service_revolutions=None) == other.replace()


def test_an_unnamed_chaser_gets_a_free_name() -> None:
    """It is the chaser, or numbered where bodies are called so."""
    assert free_name(["station"]) == "chaser"
    assert free_name(["chaser", "chaser-2"]) == "chaser-1"
    assert free_name(["chaser", "chaser-1"]) == "chaser-2"


@pytest.fixture(scope="module")
def planned() -> tuple[Instance, Plan]:
    instance = adr_opt.generate("tiny", 3)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    assert len(plan.legs) > 1
    return instance, plan


def rules(instance: Instance, plan: Plan) -> set[str]:
    """What is broken in a plan as a whole."""
    return {v.rule for v in adr_opt.check(instance, plan) if v.leg is None}


def test_legs_have_lines_of_their_own(planned: tuple[Instance, Plan]) -> None:
    """A written plan is read line by line: no line holds two legs."""
    lines = planned[1].to_json().splitlines()
    assert [line.count('"departure_s"') for line in lines].count(1) == len(planned[1].legs)
    assert max(line.count('"departure_s"') for line in lines) == 1


def test_the_cost_is_what_the_instance_counts(planned: tuple[Instance, Plan]) -> None:
    """ΔV of all legs and the price of time, or when the last service ends; nothing for no legs."""
    instance, plan = planned
    assert plan.delta_v_m_s == cost_of(Objective(), plan.legs)
    assert plan.cost == plan.delta_v_m_s + instance.time_m_s_per_s * plan.legs[-1].end_s
    assert cost_of(Objective(cost="duration"), plan.legs) == plan.legs[-1].end_s
    assert cost_of(Objective(), ()) == cost_of(Objective(cost="duration"), ()) == 0.0


@pytest.mark.parametrize(
    ("changes", "broken"),
    [
        ({}, set()),
        ({"cost": 1.001}, {"cost"}),
        ({"cost_bound": 0.5, "cost_gap": 0.5, "cost_status": "feasible"}, set()),
        ({"cost_bound": 1.0, "cost_gap": 0.0, "cost_status": "optimal"}, set()),
        ({"cost_bound": 1.0 - 1e-9, "cost_gap": 0.0, "cost_status": "optimal"}, set()),
        ({"cost_status": "feasible"}, set()),
        ({"cost_bound": 1.0, "cost_gap": 0.0, "cost_status": "feasible"}, {"cost-status"}),
        ({"cost_bound": 0.5, "cost_gap": 0.5, "cost_status": "optimal"}, {"cost-status"}),
        ({"cost_status": "optimal"}, {"cost-status"}),
        ({"cost_status": "unknown"}, {"cost-status"}),
        ({"cost_bound": 0.5, "cost_gap": 0.5}, {"cost-status"}),
        ({"cost_bound": 0.5, "cost_gap": 0.4, "cost_status": "feasible"}, {"cost-gap"}),
        ({"cost_bound": 0.5, "cost_status": "feasible"}, {"cost-gap"}),
        ({"cost_gap": 0.5}, {"cost-gap"}),
        ({"cost_bound": 1.1, "cost_gap": -0.1, "cost_status": "optimal"}, {"cost-bound"}),
    ],
)
def test_what_is_said_of_the_cost_must_hold(
    planned: tuple[Instance, Plan], changes: dict[str, Any], broken: set[str]
) -> None:
    """Cost, its bound, gap and status are worked out again (bounds here as shares of the cost)."""
    instance, plan = planned
    changes = {
        name: value * plan.cost if name in ("cost", "cost_bound") else value
        for name, value in changes.items()
    }
    assert rules(instance, plan.replace(**changes)) == broken


def test_routes_are_those_of_the_chasers(planned: tuple[Instance, Plan]) -> None:
    """A route without a chaser, and two of the same chaser, are reported."""
    instance, plan = planned
    (route,) = plan.routes
    assert rules(instance, plan.replace(routes=(route.replace(chaser="tug"),))) == {"chaser"}
    halves = (route.replace(legs=route.legs[:1]), route.replace(legs=route.legs[1:]))
    assert rules(instance, plan.replace(routes=halves)) == {"chaser"}


@pytest.mark.parametrize("price", ["per_kg", "per_kg_squared"])
def test_what_is_carried_is_priced_with_tanks_by_mass_alone(price: str) -> None:
    """Prices of kilograms need a tank that knows them, and so does what a station gives out."""
    instance = adr_opt.generate("tiny", 0)
    with pytest.raises(InputError, match="expense depends on the carried mass"):
        instance.chaser.replace(expense={price: 1.0})
    instance.chaser.replace(expense={"fixed": 1.0})
    with pytest.raises(InputError, match=r"stations\[0\].max_propellant_kg = 5.0: the tank of"):
        instance.replace(
            stations=tuple(each.replace(max_propellant_kg=5.0) for each in instance.stations)
        )
