"""Rehearsals hold a leg for legal where the rules of planners do, in any state of a chaser."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from random_rules import (
    captured,
    carrying,
    drifting_mission,
    given_mission,
    random_mission,
    towing_mission,
)

from adr_opt.analysis.rehearse.flying_chasers import FlyingChaser, refused
from adr_opt.analysis.rehearse.mission_facts import Hop, MissionFacts
from adr_opt.analysis.rehearse.visible_legs import VisibleLegs
from adr_opt.kernels.rules.loads import most_kits
from adr_opt.kernels.rules.resources import Resources
from adr_opt.kernels.rules.rules import State, step
from adr_opt.kernels.tables.timetable import lookup
from adr_opt.mission.mission import Mission
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty

DRAWS: tuple[Callable[[int], Instance], ...] = (
    random_mission,
    drifting_mission,
    given_mission,
    towing_mission,
    lambda seed: carrying(random_mission(seed), seed),
    lambda seed: captured(random_mission(seed), seed),
)
STATES = 40


def drawn_state(mission: Mission, rng: np.random.Generator) -> State:
    """A chaser somewhere, some time, with something in its tank; it may have come from anywhere."""
    rules = mission.rules
    body = int(rng.integers(rules.service.size))
    if rules.first_target > body >= rules.stations:
        body = rules.start
    has = Resources(
        # Mostly early and rich, so that many moves are legal.
        float(rules.ready + (rules.duration - rules.ready) * rng.random() ** 4),
        float(rules.budget * rng.random() ** 0.25),
        int(rng.integers(0, 3)),
        int(rng.integers(0, min(5, rules.service.size - rules.first_target))),
        int(rng.integers(0, most_kits(rules.loads) + 1)),
    )
    return State(np.int64(body), has)


@pytest.mark.parametrize("draw", DRAWS)
def test_a_leg_is_refused_where_a_move_is_illegal(draw: Callable[[int], Instance]) -> None:
    """Of the same connection from the same state rehearsals and planners say the same."""
    legal = illegal = 0
    for seed in range(8):
        instance = draw(seed)
        # Whether an end can still be reached is asked by planners alone.
        chasers = [chaser.replace(end="anywhere") for chaser in instance.chasers]
        instance = instance.replace(chasers=tuple(chasers))
        mission, facts = Mission(instance), MissionFacts(instance)
        rules, rng = mission.rules, np.random.default_rng(seed)
        visible = None if instance.given is not None else VisibleLegs(facts, Uncertainty())
        for _ in range(STATES):
            state = drawn_state(mission, rng)
            time, left, since, serviced, kits = state.resources
            body = int(state.body)
            craft = FlyingChaser(0, body, body in facts.tow_s, time, left, kits, since, serviced)
            for j in (*range(rules.stations), *range(rules.first_target, rules.service.size)):
                if j == body:
                    continue
                delta_v, arrival = lookup(rules.table, body, j, time)
                said = refused(facts, craft, Hop(j, time, arrival, delta_v, 0, 0))
                may = bool(step(rules, state, j)[0])
                assert may == (said == ""), (seed, state, j, said)
                legal, illegal = legal + may, illegal + (not may)
            if visible is not None:
                seen = visible.seen(craft, set(), [], None)
                for at, j in enumerate(seen.bodies.tolist()):
                    hop = Hop(j, time, float(seen.arrival[at]), float(seen.delta_v[at]), 0, 0)
                    assert seen.legal[at] == (refused(facts, craft, hop) == ""), (seed, j)
    assert min(legal, illegal) > 50
