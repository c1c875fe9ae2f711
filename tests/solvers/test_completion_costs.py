"""What completing a plan costs at least, against the cheapest plans of all."""

from __future__ import annotations

from contextlib import closing

import numpy as np
from brute_force import brute_force
from random_rules import random_mission

from adr_opt.kernels.rules.resources import Resources
from adr_opt.mission.mission import Mission
from solvers.proof.cost import CostProof
from solvers.walks.completion_costs import CostGuide, least_cost


def guide_of(mission: Mission, prizes: float, cost: float) -> CostGuide:
    """What a proof tells of a mission whose known plan is twice as dear as it need be."""
    proof = CostProof(
        mission,
        prizes,
        lambda plan: None,
        lambda: 2.0 * cost + 1.0,
        lambda: False,
        jobs=1,
        delta_v_slot_m_s=25.0,
        most_labels=10**5,
    )
    with closing(proof):
        proof.advance()
    assert proof.guide is not None
    return proof.guide


def test_no_part_of_the_cheapest_plan_is_said_to_cost_more() -> None:
    """A search that leaves out what costs too much keeps every beginning of the cheapest plan."""
    held = priced = dropped = 0
    for seed in range(500, 600):
        mission = Mission(random_mission(seed))
        rules = mission.rules
        prizes, cost, order = brute_force(mission)
        if rules.loads is not None or rules.falls is not None or len(order) < 2:
            continue
        schedule = mission.time(order)
        before = mission.connecting.spent_m_s(rules.start)
        guide = guide_of(mission, mission.worth(prizes), cost)
        spent, worth = np.cumsum(schedule.delta_vs), np.cumsum(rules.prize[list(order)])
        for at, body in enumerate(order):
            has = Resources(schedule.ends[at], schedule.lefts[at], 0, 0, 0)
            rest = least_cost(guide, body, has, worth[at])
            assert spent[at] + rest <= cost + before + 1e-3, (seed, at)
            priced += rest > 0.0
            # With nothing collected by then, what is left of the mission is mostly too short.
            dropped += least_cost(guide, body, has, 0.0) == np.inf
            held += 1
    assert held > 20
    assert priced > 10
    assert dropped > 10
