"""Uncertain worlds in the environment: those of rehearsals, seen and played as the page says."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from drawn_worlds import drawn_uncertainty
from random_rules import captured, drifting_field
from seeds import over_kinds
from small_fields import SMALL, tiny

from adr_opt.analysis.rehearse.flight import Halt, Situation, rehearsed
from adr_opt.analysis.rehearse.flying_chasers import DRY, LATE
from adr_opt.analysis.rehearse.mission_facts import Hop, MissionFacts
from adr_opt.common.constants import DAY_S, SLACK_M_S
from adr_opt.common.errors import InputError
from adr_opt.kernels.episodes import choices as columns
from adr_opt.learning.environment import (
    OBSERVATIONS,
    TROUBLED,
    TROUBLES,
    UNCERTAIN_ID,
    MissionEnv,
    MissionVecEnv,
)
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.problem.world import OUTCOMES, DrawnWorld

WORLDS = 8
"""Worlds of each mission."""


class Played:
    """A policy of rehearsals that makes the moves of an episode, at the costs of its timetable."""

    def __init__(self, env: MissionEnv, facts: MissionFacts) -> None:
        self._table, self._facts, self._left = env.mission.timetable, facts, list(env.sequence)

    def next_leg(self, now: Situation) -> Hop | Halt:
        """The next move."""
        if not self._left:
            return Halt("played")
        i, j, ready = now.craft.body, self._left.pop(0), now.craft.free_s
        delta_v, arrival = self._table.lookup(i, j, ready)
        rows = self._facts.rows(i, j, towed=False)
        same = np.flatnonzero((rows.arrival == arrival) & (rows.delta_v == delta_v))
        return Hop(j, ready, arrival, delta_v, int(rows.family[same[0]]) if same.size else 0, 0)

    def tries_again(self, now: Situation, target: int, tries: int) -> bool:
        """As often as it is allowed."""
        return True


def some_field(seed: int) -> Instance:
    """A small field: plain, with prizes, with windows, or with planes that drift."""
    rng = np.random.default_rng([5, seed])
    if seed % 4 == 3:
        field = drifting_field(rng, 200.0 * DAY_S)
        return field.with_limits(delta_v_m_s=float(rng.uniform(200, 900)))
    field = tiny(seed, delta_v_m_s=float(rng.uniform(200, 900)))
    targets = list(field.targets)
    if seed % 4 == 1:
        targets = [each.replace(prize=float(rng.integers(0, 9))) for each in targets]
    if seed % 4 == 2:
        return captured(field, seed // 4)
    return field.replace(targets=tuple(targets))


def play(env: MissionEnv, rng: np.random.Generator) -> list[dict[str, Any]]:
    """What is told of each of the legal moves at random that end an episode."""
    told, over = list[dict[str, Any]](), False
    while not over:
        action = int(rng.choice(np.flatnonzero(env.action_masks())))
        _, reward, over, _, info = env.step(action)
        told.append({**info, "reward": reward})
    return told


@over_kinds("seeds", fields=(range(40), 4))
def test_episodes_and_rehearsals_meet_the_same_world(seeds: range) -> None:
    """The moves of an episode come to the same in a rehearsal of the same world, bit for bit."""
    seen: Counter[str] = Counter()
    for seed in seeds:
        instance = some_field(seed)
        model = drawn_uncertainty(instance, seed)
        env, facts = MissionEnv(instance, uncertainty=model), MissionFacts(instance)
        rng = np.random.default_rng(seed)
        for world in range(WORLDS):
            try:
                env.reset(seed=seed, options={"world": world})
            except InputError:  # a tank of which little can be used
                continue
            told = play(env, rng)
            drawn = DrawnWorld(instance, model.of(instance), world)
            flown = rehearsed(facts, drawn, Played(env, facts), (0,))
            (craft,) = flown.chasers
            assert [each["outcome"] for each in told] == [made.outcome for made in craft.made]
            assert [each["tries"] for each in told] == [made.tries for made in craft.made]
            assert [each["time_s"] for each in told] == [made.free_s for made in craft.made]
            lefts = [max(made.left - SLACK_M_S, 0.0) for made in craft.made]
            assert [each["delta_v_left_m_s"] for each in told] == lefts
            assert env._episodes.delta_v[0] == sum(made.delta_v for made in craft.made)
            prizes = [prize for prize in facts.prizes.values() if prize > 0.0]
            mean = float(np.mean(prizes)) if prizes else 1.0
            assert sum(each["reward"] for each in told) * mean == pytest.approx(flown.prize)
            lost = {
                facts.names[made.hop.destination]: made.outcome
                for made in craft.made
                if made.outcome in OUTCOMES[2:]
            }
            assert told[-1]["losses"] == lost
            assert (craft.ended in (DRY, LATE)) == (told[-1]["outcome"] in (DRY, LATE))
            seen.update(each["outcome"] for each in told)
    assert set(seen) == set(OUTCOMES)


@pytest.mark.parametrize("observation", OBSERVATIONS)
def test_a_certain_world_is_the_mission_as_planned(observation: str) -> None:
    """Without anything uncertain, all that is seen, earned and told is that of `Mission-v0`."""
    envs = [
        MissionEnv(tiny(2), observation=observation, uncertainty=model)
        for model in (None, Uncertainty())
    ]
    rng = np.random.default_rng(0)
    for _ in range(4):
        seen = [env.reset() for env in envs]
        over = False
        while not over:
            np.testing.assert_equal(seen[0][0], seen[1][0])
            action = int(rng.choice(np.flatnonzero(envs[0].action_masks())))
            steps = [env.step(action) for env in envs]
            assert steps[0][1:4] == steps[1][1:4]
            for name in ("time_s", "delta_v_left_m_s", "collected", "serviced", "refuelled"):
                assert steps[0][4][name] == steps[1][4][name]
            seen, over = [(step[0], step[4]) for step in steps], steps[0][2]


def test_what_is_seen_of_worlds_is_what_they_do_on_average() -> None:
    """The spread of ΔV, chances, late services and worths are those of thousands of draws."""
    instance = tiny(1).with_limits(delta_v_m_s=900.0)
    targets = [each.replace(prize=1.0 + place % 3) for place, each in enumerate(instance.targets)]
    instance = instance.replace(targets=tuple(targets))
    model = Uncertainty(
        legs={"delta_v_factor": {"lognormal_sigma": 0.4}},
        service_s={"factor": {"lognormal_sigma": 0.3}, "added": {"chance": 0.3, "mean_s": 9000.0}},
        capture={"success": 0.7, "tries": 3},
        gone=0.2,
        targets={targets[0].name: {"success": 0.4, "service_s": {}}},
    )
    env = MissionEnv(instance, uncertainty=model)
    seen, info = env.reset(seed=0)
    worlds = [DrawnWorld(instance, model, seed) for seed in range(4000)]
    mean = float(np.mean([each.prize for each in targets]))
    left_m_s = info["delta_v_left_m_s"]
    assert isinstance(seen, dict)
    for body, target in enumerate(instance.targets, start=1):
        row, name = seen["moves"][body - 1], target.name
        planned_m_s, _ = env.mission.timetable.lookup(0, body, 0.0)
        service_s = float(env.mission.rules.service[body])
        costs = np.array([planned_m_s * each.leg_factor("short", name) for each in worlds])
        stays = np.array([each.service_s(name, service_s) for each in worlds])
        firsts = [0 if each.is_gone(name) else each.first_success(name) for each in worlds]
        tries = np.array([3 if first is None else first for first in firsts])
        for column, wanted, within in (
            (columns.WORTH, target.prize / mean * np.mean([bool(one) for one in firsts]), 0.06),
            (columns.IS_GONE, 0.2, 1e-6),
            (columns.SUCCEEDS, model.success_of(name), 1e-6),
            (columns.SPREAD_NEEDED, costs.std() / 1e3, 0.02 * planned_m_s / 1e3),
            (columns.HOLDS, np.mean(costs <= left_m_s) if row[0] else 0.0, 0.03),
            (columns.MEAN_TRY, stays.mean() / 36e3, 0.02),
            (columns.LATE_TRY, np.quantile(stays, 0.9) / 36e3, 0.03),
            (columns.MEAN_STAY, (tries * stays).mean() / 36e3, 0.04),
        ):
            assert row[column] == pytest.approx(min(wanted, 5.0), abs=within), (name, column)
    late = seen["moves"][:-1, columns.LATE_TRY]
    assert late.max() > 1.2 * late.min()


def test_the_id_plays_worlds_that_differ_from_reset_to_reset() -> None:
    """``gymnasium.make`` plays uncertain worlds: the same of a seed, others without one."""
    env = gymnasium.make(UNCERTAIN_ID, instance=tiny())
    worlds = [env.reset(seed=seed)[1]["world"] for seed in (1, 1, None, None)]
    assert worlds[0] == worlds[1]
    assert len(set(worlds)) == 3
    assert env.unwrapped.uncertainty == TROUBLED  # type: ignore[attr-defined]
    assert MissionEnv(tiny()).uncertainty is None
    many = MissionEnv(tiny(), uncertainty=TROUBLES)
    drawn = set()
    for _ in range(20):
        many.reset()
        assert many.uncertainty is not None
        drawn.add(many.uncertainty.to_json())
    assert len(drawn) > 5


def test_the_examples_of_the_page_run() -> None:
    """The examples of docs/environment.md run as they stand, but for their fields."""
    page = (Path(__file__).parents[2] / "docs/environment.md").read_text(encoding="utf-8")
    one, many = re.findall(r"```python\n(.*?)```", page, re.DOTALL)[3:]
    names: dict[str, Any] = {"SMALL": SMALL}
    exec(one.replace("fields=PUBLISHED", "fields=SMALL, pool=2"), names)
    assert names["terminated"]
    exec(many.replace("256, RANDOMISED", "4, SMALL").replace("slots=64", "slots=2"), names)
    names["env"].close()


UNKNOWN = Uncertainty(targets={"nobody": {"gone": 0.5}})

WRONG = {
    "much: no such file": lambda: MissionEnv(uncertainty="much"),
    "uncertainty of type int: give an Uncertainty": lambda: MissionEnv(uncertainty=[3]),
    "uncertainty = []: must be an Uncertainty": lambda: MissionVecEnv(uncertainty=[]),
    "uncertainty of type NoneType: give an": lambda: MissionEnv(uncertainty=(None,)),
    "world = -1: must be a whole number": lambda: MissionEnv(tiny(), uncertainty=TROUBLED).reset(
        options={"world": -1}
    ),
    "world = 0.5: must be a whole number": lambda: MissionEnv(tiny(), uncertainty=TROUBLED).reset(
        options={"world": 0.5}
    ),
    "option 'world' is unknown": lambda: MissionEnv(fields=SMALL).reset(options={"world": 1}),
    "'nobody' is not a target": lambda: MissionEnv(tiny(), uncertainty=UNKNOWN).reset(),
    "no move is legal at the start": lambda: MissionEnv(
        tiny(), uncertainty=Uncertainty(tanks={"least": 1e-6, "most": 1e-6})
    ).reset(),
}


@pytest.mark.parametrize("sentence", WRONG)
def test_wrong_input_is_refused_in_one_sentence(sentence: str) -> None:
    """What cannot be meant is refused by an InputError that names it."""
    with pytest.raises(InputError) as caught:
        WRONG[sentence]()
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
