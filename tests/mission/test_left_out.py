"""Reasons for targets left out: doing what a reason asks makes the visit possible."""

from __future__ import annotations

from collections import Counter
from typing import get_args

import numpy as np
import pytest
from random_rules import (
    carrying,
    drifting_mission,
    given_mission,
    random_mission,
    towing_mission,
    visiting_mission,
)

from adr_opt.mission.left_out import unvisited
from adr_opt.mission.mission import Mission
from adr_opt.mission.relaxed import LARGEST, LONGEST, with_tank
from adr_opt.plan.plan import Reason
from adr_opt.problem.instance import Instance

DRAWS = {
    "random": random_mission,
    "carrying": lambda seed: carrying(random_mission(seed), seed),
    "drifting": drifting_mission,
    "given": given_mission,
    "towing": towing_mission,
    "visiting": visiting_mission,
}

ASKED = {
    "not-worth-it": "",
    "kits": "counts",
    "capacity": "counts",
    "delta-v": "tank",
    "duration": "time",
    "several": "counts tank time",
}
"""What each reason asks for."""

HEARD = {
    "random": {"not-worth-it", "delta-v", "duration", "several", "no-transfer"},
    "carrying": {"kits"},
    "visiting": {"capacity"},
}
"""Reasons that a draw has to give: all that there are but one, of what was not searched for."""


def relaxed(instance: Instance, asked: str) -> Instance:
    """The instance with more of what is asked for."""
    chaser = instance.chaser
    if "counts" in asked:
        chaser = chaser.replace(kits=None, max_targets=None, max_visits_between_refuels=None)
    if "tank" in asked:
        chaser = with_tank(chaser, LARGEST)
    if "time" in asked:
        chaser = chaser.replace(available_s=(chaser.available_s[0], None))
        targets = [each.replace(window_s=(each.window_s[0], None)) for each in instance.targets]
        duration_s = LONGEST * instance.mission.duration_s
        mission = instance.mission.replace(duration_s=duration_s)
        instance = instance.replace(targets=tuple(targets), mission=mission)
    return instance.replace(chasers=(chaser,))


def legal(mission: Mission, seed: int, length: int) -> list[int]:
    """The legal beginning of a random order of targets, of so many moves at most."""
    first = mission.rules.first_target
    order = first + np.random.default_rng(seed).permutation(len(mission.names) - first)
    moves = [int(j) for j in order[:length]]
    return moves[: mission.time(moves).made]


@pytest.mark.parametrize("draw", DRAWS)
def test_what_a_reason_asks_makes_the_visit_possible(draw: str) -> None:
    """The limit that is named stands in the way alone; a plan of no leg has reasons as well."""
    heard = Counter[str]()
    for seed in range(500, 512):
        instance = DRAWS[draw](seed)
        mission = Mission(instance)
        others = {asked: Mission(relaxed(instance, asked)) for asked in set(ASKED.values())}
        for length in (0, 2):
            moves = legal(mission, seed, length)
            for left in unvisited([(mission, moves)]):
                more = [*moves, mission.names.index(left.target)]
                flies = {
                    asked: other.time_by_class(more).made == len(more)
                    for asked, other in others.items()
                }
                heard[left.reason] += 1
                where = seed, moves, left, flies
                if left.reason == "no-transfer":
                    assert not any(flies.values()), where
                    continue
                assert flies[ASKED[left.reason]], where
                assert left.reason == "not-worth-it" or not flies[""], where
                if left.reason == "several":
                    assert not any(flies[each] for each in ("tank", "time", "counts")), where
    assert HEARD.get(draw, {"no-transfer", "duration"}) <= heard.keys()


def test_every_reason_is_tried() -> None:
    """What is asked for is known of each reason, and drawn missions give each of them."""
    tried = set(get_args(Reason)) - {"not-considered"}
    assert set().union(*HEARD.values()) == tried == {*ASKED, "no-transfer"}


def test_kits_and_limits_are_told_apart() -> None:
    """Where targets take kits, it is these that run out first, or the targets that are allowed."""
    instance = carrying(random_mission(500), 500)
    roomy = with_tank(instance.chaser, LARGEST)
    taking = {each.name for each in instance.targets if each.service.takes_kit}
    for reason, changes in (
        ("kits", {"kits": 0, "max_targets": None}),
        ("capacity", {"kits": None, "max_targets": 0}),
    ):
        mission = Mission(instance.replace(chasers=(roomy.replace(**changes),)))
        heard = {left.reason for left in unvisited([(mission, ())]) if left.target in taking}
        assert reason in heard
        assert heard <= {reason, "several", "no-transfer"}
