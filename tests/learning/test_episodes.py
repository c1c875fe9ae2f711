"""Episodes: one step for rules, masks, rewards; prizes, windows, what is refused."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from seeds import over_kinds

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.kernels.episodes import episodes as kernels
from adr_opt.kernels.episodes.choices import PRIZE
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.learning.environment import MissionEnv
from adr_opt.learning.episodes import Board, FieldPool, in_mean_prizes, new_episodes, start
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.problem.chasers import Chaser
from adr_opt.problem.instance import Instance


def varied(seed: int) -> Instance:
    """A small field with zones, windows, prizes, and ΔV and time that run out now and then."""
    rng = np.random.default_rng(seed)
    instance = adr_opt.generate("tiny", seed, targets=9, zones=seed % 3)
    duration = instance.mission.duration_s
    targets = []
    for number, target in enumerate(instance.targets):
        opens = float(rng.uniform(0.0, 0.4) * duration) if number % 3 == 0 else 0.0
        closes = float(rng.uniform(0.5, 1.0) * duration) if number % 2 == 0 else None
        prize = float(rng.choice([0.0, 0.5, 1.0, 3.0]))
        targets.append(target.replace(window_s=(opens, closes), prize=prize))
    return instance.replace(targets=tuple(targets)).with_limits(
        delta_v_m_s=float(rng.uniform(400.0, 1200.0))
    )


@over_kinds("seeds", fields=(range(40), 4))
def test_rules_steps_masks_and_check_agree(seeds: range) -> None:
    """On thousands of states step, legal_moves, masks and timing say the same; plans pass check."""
    states = ends_in_windows = refuelled = 0
    for seed in seeds:
        rng = np.random.default_rng([5, seed])
        instance = varied(seed)
        mission = Mission(instance, threads=1)
        rules, size = mission.rules, len(mission.names)
        pool = FieldPool.of(mission)
        budget, duration = instance.chaser.tank.delta_v_m_s, instance.mission.duration_s
        boards = [Board(name, 1, size - 1) for name in ("choices", "published")]
        for _ in range(30):
            episodes = new_episodes(1, size)
            start(pool, episodes, 0, 0, budget, duration)
            state = rule_kernels.beginning(rules)
            visited = np.zeros(size, dtype=np.bool_)
            sequence: list[int] = []
            while True:
                legal = np.zeros(size, dtype=np.bool_)
                rule_kernels.legal_moves(rules, state, visited, legal)
                by_action = np.append(legal[1:], legal[0])
                for board in boards:
                    board.observe(pool.arrays, episodes, 0, 1)
                    np.testing.assert_array_equal(board.mask[0], by_action)
                illegal = rng.choice(np.flatnonzero(~legal))
                before = [part.copy() for part in episodes]
                assert not kernels.move(pool.arrays, episodes, 0, illegal)
                for now, then in zip(episodes, before, strict=True):
                    np.testing.assert_array_equal(now, then)
                states += 1
                if not legal.any():
                    break
                j = int(rng.choice(np.flatnonzero(legal)))
                allowed, _, state = rule_kernels.step(rules, state, j)
                assert allowed
                rewards = np.zeros(1, dtype=np.float32)
                action = np.array([kernels.action_of(j, size - 1)])
                kernels.act(pool.arrays, episodes, 0, 1, action, rewards)
                assert rewards[0] == np.float32(in_mean_prizes(mission)[j])
                has = state.resources
                assert episodes.body[0] == state.body
                assert (episodes.time[0], episodes.left[0]) == (has.time, has.left)
                assert (episodes.since[0], episodes.serviced[0]) == (has.since, has.serviced)
                visited[j] = not rules.is_station[j]
                refuelled += bool(rules.is_station[j])
                begun, windows = has.time - rules.service[j], rules.windows
                ends_in_windows += bool(windows.closing[j] < rules.duration - rules.service[j])
                assert windows.opening[j] - 1e-9 <= begun <= windows.closing[j] + 1e-9
                sequence.append(j)
            timing = mission.time(sequence)
            assert timing.made == len(sequence)
            plan = certify(mission, "episode", sequence, seed=0, runtime_s=0.0).plan
            assert plan is not None
            assert adr_opt.check(instance, plan) == ()
            mean = rules.prize[rules.prize > 0.0].mean()
            assert plan.objective == pytest.approx(episodes.collected[0] * mean)
    assert states > 50 * len(seeds)
    assert ends_in_windows > 2 * len(seeds)
    assert refuelled > len(seeds)


def test_rewards_are_prizes_in_mean_prizes() -> None:
    """A return times the mean prize is the objective; equal prizes are rewards of exactly 1."""
    rng = np.random.default_rng(0)
    equal = adr_opt.generate("tiny", 2)
    equal = equal.replace(targets=tuple(target.replace(prize=0.1) for target in equal.targets))
    for instance in (equal, varied(4)):
        env = MissionEnv(instance)
        seen, _ = env.reset()
        prize = np.array([target.prize for target in instance.targets])
        scaled = prize / prize[prize > 0.0].mean()
        assert isinstance(seen, dict)
        shown = seen["moves"][:-1, PRIZE]
        np.testing.assert_allclose(shown, np.minimum(scaled, 5.0), rtol=1e-6)
        assert seen["moves"][-1, PRIZE] == 0.0
        total, over = 0.0, False
        while not over:
            action = int(rng.choice(np.flatnonzero(env.action_masks())))
            _, reward, over, _, info = env.step(np.int64(action))
            if instance is equal:
                assert reward == float(action < len(prize))
            total += reward
            assert info["collected"] == pytest.approx(total)
        plan = certify(env.mission, "episode", env.sequence, seed=0, runtime_s=0.0).plan
        assert plan is not None
        assert plan.objective == pytest.approx(total * prize[prize > 0.0].mean())


def _changed(instance: Instance, **chaser: Any) -> Instance:
    return instance.replace(chasers=(instance.chaser.replace(**chaser),))


def _odd() -> dict[str, Instance]:
    instance = adr_opt.generate("tiny", 1)
    assert isinstance(instance.chaser, Chaser)
    station = instance.stations[0]
    orbit = station.orbit
    return {
        "number of stations (field stations)": instance.replace(
            stations=(station, station.replace(name="second", orbit=instance.targets[0].orbit))
        ),
        "start orbits": _changed(instance, start={"orbit": orbit}),
        "number of stations": _changed(instance, start={"orbit": orbit}).replace(stations=()),
        "late availability": _changed(instance, available_s=(3600.0, None)),
        "most targets": _changed(instance, max_targets=2),
        "ends": _changed(instance, end={"station": station.name}),
        "kits": _changed(
            instance,
            tank={"dry_mass_kg": 500.0, "propellant_kg": 90.0, "isp_s": 300.0},
            kit_mass_kg=40.0,
        ).replace(targets=tuple(each.replace(removal="kit") for each in instance.targets)),
    }


@pytest.mark.parametrize("what", _odd())
def test_missions_that_cannot_be_played_are_refused(what: str) -> None:
    """The environment and the learned planner say in one sentence what they do not know."""
    instance = _odd()[what]
    with pytest.raises(
        InputError, match=f"environment .* does not follow {re.escape(what)}.*; use one of: auto, "
    ):
        MissionEnv(instance).reset()
    with pytest.raises(InputError, match=f"method 'ppo' does not follow {re.escape(what)}"):
        adr_opt.solve(instance, "ppo")


def test_an_episode_ends_with_the_chaser() -> None:
    """A chaser that is available for part of the mission plays for that part."""
    instance = adr_opt.generate("tiny", 1)
    half = 0.5 * instance.mission.duration_s
    env = MissionEnv(_changed(instance, available_s=(0.0, half)))
    env.reset()
    over = False
    while not over:
        action = np.flatnonzero(env.action_masks())[0]
        _, _, over, _, info = env.step(action)
        assert info["time_s"] <= half + 1.0
