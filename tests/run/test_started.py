"""Chasers that start with a tank that is not full, against plain enumeration."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from brute_force import brute_force, brute_force_campaign
from conftest import Cli, refused
from hand_made import hand_made
from random_rules import drifting_mission, random_campaign, random_mission, with_given_costs
from seeds import over_kinds

import adr_opt
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.plan.cargo import tank_worths
from adr_opt.problem.chasers import InOrbit, Tank, TankByMass
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import Objective
from solvers.walks.walks import WalkBound


def begun(instance: Instance, seed: int) -> Instance:
    """The same with chasers that start in orbits with some of their ΔV; some tanks by mass."""
    rng = np.random.default_rng([12, seed])
    chasers = []
    for chaser in instance.chasers:
        orbit = instance.targets[int(rng.integers(len(instance.targets)))].orbit
        start = InOrbit(orbit=orbit.replace(true_anomaly_deg=float(rng.uniform(0.0, 360.0))))
        full, share = chaser.tank.delta_v_m_s, float(rng.choice([0.0, 0.2, 0.5, 0.8, 1.0]))
        tank: Tank | TankByMass = Tank(delta_v_m_s=full, initial_delta_v_m_s=share * full)
        if rng.random() < 0.3:
            propellant = 500.0 * math.expm1(full / (9.80665 * 250.0))
            tank = TankByMass(
                dry_mass_kg=500.0,
                propellant_kg=propellant,
                isp_s=250.0,
                initial_propellant_kg=share * propellant,
            )
        chasers.append(chaser.replace(start=start, tank=tank))
    return instance.replace(chasers=tuple(chasers))


def of_two_bodies(seed: int) -> Instance:
    return begun(random_mission(seed), seed)


def of_drift(seed: int) -> Instance:
    return begun(drifting_mission(seed), seed)


def of_given(seed: int) -> Instance:
    plain = random_mission(seed).replace(keep_out_zones=())
    return with_given_costs(begun(plain, seed), np.random.default_rng([13, seed]))


either = over_kinds(
    "draw, seeds",
    two_body=(of_two_bodies, range(40), 20),
    j2=(of_drift, range(24), 3),
    given=(of_given, range(24), 5),
)


@either
def test_optima_are_those_of_enumeration(draw, seeds: range) -> None:
    """`exact` proves the best prizes and the least ΔV, `check` agrees, and bounds hold."""
    flown = 0
    for seed in seeds:
        instance = draw(seed).replace(objective=Objective(cost="delta-v"))
        mission = Mission(instance, threads=1)
        prizes, cost, order = brute_force(mission)
        bound, _ = WalkBound(mission, 20.0).evaluate(np.zeros(mission.rules.prize.size))
        assert mission.shown(bound) >= prizes - 1e-9, seed
        result = adr_opt.solve(mission, "exact", time_limit=60.0, cost=True)
        if not math.isfinite(prizes):
            assert result.status == "infeasible", seed
            continue
        assert result.status == "optimal", seed
        plan = result.plan
        assert plan.objective == pytest.approx(prizes, abs=1e-9), seed
        assert adr_opt.check(instance, plan) == (), seed
        assert plan.cost == pytest.approx(cost, abs=2e-3), seed
        assert plan.cost_status == "optimal", seed
        assert plan.cost_bound <= cost * (1.0 + 1e-9) + 1e-9, seed
        since_s = instance.available_s[0][0]
        flown_s = plan.legs[-1].done_s - since_s if plan.legs else 0.0
        paid = instance.time_m_s_per_s * flown_s
        assert plan.cost == pytest.approx(sum(leg.delta_v_m_s for leg in plan.legs) + paid)
        flown += len(order)
    assert flown >= len(seeds) // 4


def test_what_is_impossible_is_known_at_once() -> None:
    """A proof ends where its bound says that a required target is left out, whatever else pays."""
    instance = of_two_bodies(12)
    assert any(target.required for target in instance.targets)
    result = adr_opt.solve(instance, "exact", time_limit=60.0)
    assert result.status == "infeasible"
    assert result.counters["searches"] < 20


@pytest.mark.parametrize("method", ["greedy-guarded", "beam", "mcts", "local-search", "auto"])
@over_kinds(
    "draw, seeds",
    two_body=(of_two_bodies, range(100, 113), 3),
    j2=(of_drift, range(100, 108), 2),
    given=(of_given, range(100, 108), 2),
)
def test_planners_keep_to_the_tank(method: str, draw, seeds: range) -> None:
    """What a planner returns passes `check`, and is worth no more than the optimum."""
    for seed in seeds:
        mission = Mission(draw(seed), threads=1)
        prizes, _, _ = brute_force(mission)
        result = adr_opt.solve(mission, method, time_limit=20.0, iterations=2)
        if result.plan is not None:
            assert adr_opt.check(mission.instance, result.plan) == (), seed
            assert result.objective <= prizes + 1e-9, seed


def test_campaigns_of_such_chasers_are_proven() -> None:
    """Prizes of several chasers are those of enumeration, and no cost is below the bound."""
    flown = 0
    for seed in range(14):
        instance = begun(random_campaign(seed), seed)
        campaign = Problem(instance, threads=1)
        prizes, cost = brute_force_campaign(campaign)
        result = adr_opt.solve(campaign, "exact", time_limit=60.0, cost=True)
        if not math.isfinite(prizes):
            assert result.plan is None, seed
            continue
        assert result.objective == pytest.approx(prizes), seed
        assert adr_opt.check(instance, result.plan) == (), seed
        if result.plan.cost_bound is not None:
            assert result.plan.cost_bound <= cost + 1e-6, seed
        flown += len(result.plan.legs)
    assert flown >= 3


def test_a_tank_that_is_said_to_be_full_is_a_full_one() -> None:
    """The same plan comes out as without saying it."""
    plain = adr_opt.generate("tiny", 0)
    start = InOrbit(orbit=plain.targets[0].orbit)
    full = plain.chaser.tank.delta_v_m_s
    silent = plain.replace(chasers=(plain.chaser.replace(start=start),))
    tank = Tank(delta_v_m_s=full, initial_delta_v_m_s=full)
    said = plain.replace(chasers=(plain.chaser.replace(start=start, tank=tank),))
    one, two = (adr_opt.solve(each, "exact", time_limit=20.0).plan for each in (silent, said))
    assert [leg.model_dump() for leg in one.legs] == [leg.model_dump() for leg in two.legs]


def test_the_first_tank_is_worth_what_it_holds() -> None:
    """Budgets tank by tank begin with what there is, and go on with full tanks."""
    instance = of_two_bodies(2)
    chaser = instance.chaser.replace(tank=Tank(delta_v_m_s=500.0, initial_delta_v_m_s=120.0))
    legs = [("debris-001", 50.0), (instance.station_names[0], 60.0), ("debris-002", 10.0)]
    assert tank_worths(instance, chaser, legs) == (120.0, 500.0)


def test_connections_are_told_as_they_are() -> None:
    """ΔV spent before the start is no part of the cost of a transfer, in any query."""
    plain = of_two_bodies(4)
    chaser = plain.chaser
    less = Tank(delta_v_m_s=chaser.tank.delta_v_m_s, initial_delta_v_m_s=10.0)
    tables = [
        adr_opt.Timetable(plain.replace(chasers=(chaser.replace(tank=tank),)), threads=1)
        for tank in (Tank(delta_v_m_s=less.delta_v_m_s), less)
    ]
    j = tables[0].names[-1]
    pairs = [table.connections(chaser.name, j) for table in tables]
    np.testing.assert_allclose(pairs[0].delta_v, pairs[1].delta_v, atol=1e-9)
    costs = [table.matrices([0.0, 4000.0], choose="cheapest").delta_v for table in tables]
    np.testing.assert_allclose(costs[0], costs[1], atol=1e-9)
    costs = [table.matrices([0.0, 4000.0]).delta_v for table in tables]
    np.testing.assert_allclose(costs[0], costs[1], atol=1e-9)
    assert tables[0].lookup(chaser.name, j, 0.0) == pytest.approx(
        tables[1].lookup(chaser.name, j, 0.0)
    )


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"tank": {"delta_v_m_s": 300.0, "initial_delta_v_m_s": 301.0}}, "a full tank holds 300"),
        ({"tank": {"delta_v_m_s": 300.0, "initial_delta_v_m_s": -1.0}}, "initial_delta_v_m_s"),
        ({"tank": {"delta_v_m_s": 300.0, "initial_delta_v_m_s": 5.0}}, "but the station where"),
    ],
)
def test_what_makes_no_sense_is_refused(cli: Cli, changes, named: str) -> None:
    """More than a tank holds, less than nothing, or a start where tanks are filled."""
    content = json.loads(hand_made().to_json())
    content["chasers"][0] |= changes
    with open("x.json", "w", encoding="utf-8") as file:
        json.dump(content, file)
    refused(cli("solve", "x.json"), named)
