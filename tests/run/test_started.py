"""Chasers that start with a tank that is not full, against plain enumeration."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import Cli, refused
from hand_made import hand_made
from random_rules import random_mission, started

import adr_opt
from adr_opt.plan.cargo import tank_worths
from adr_opt.problem.chasers import InOrbit, Tank
from adr_opt.problem.instance import Instance


def of_two_bodies(seed: int) -> Instance:
    return started(random_mission(seed), seed)


def test_what_is_impossible_is_known_at_once() -> None:
    """A proof ends where its bound says that a required target is left out, whatever else pays."""
    instance = of_two_bodies(12)
    assert any(target.required for target in instance.targets)
    result = adr_opt.solve(instance, "exact", time_limit=60.0)
    assert result.status == "infeasible"
    assert result.counters["searches"] < 20


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
