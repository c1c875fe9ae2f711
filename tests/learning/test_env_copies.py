"""Environments in other hands: copied, pickled, written as JSON, vectorised, found by Gymnasium."""

from __future__ import annotations

import copy
import json
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cloudpickle
import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode
from random_rules import drifting_field
from small_fields import SMALL, tiny

from adr_opt.common.errors import InputError
from adr_opt.learning.environment import ID, TROUBLED, MissionEnv, MissionVecEnv

IDS = sorted(each for each in gymnasium.registry if each.startswith("adr_opt/"))

MADE: dict[str, Callable[[], dict[str, Any]]] = {
    "instance": lambda: {"instance": tiny()},
    "dictionary": lambda: {"instance": json.loads(tiny().to_json())},
    "drifting": lambda: {"instance": drifting_field(np.random.default_rng(4), 120 * 86400.0)},
    "fields": lambda: {"fields": SMALL, "pool": 3},
    "no pool": lambda: {"fields": SMALL, "pool": 0},
    "family": lambda: {"fields": "tiny", "pool": 1, "observation": "published"},
    "fields by name": lambda: {"fields": {"family": "tiny", "targets": [3, 5]}, "pool": 2},
    "one model": lambda: {"instance": tiny(), "uncertainty": TROUBLED},
    "models": lambda: {"fields": SMALL, "pool": 2, "uncertainty": [TROUBLED, {"gone": 0.5}]},
}
"""Ways of making an environment."""

COPIED: dict[str, Callable[[Any], Any]] = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
    "cloudpickle": lambda env: cloudpickle.loads(cloudpickle.dumps(env)),
}


def step(env: Any, info: dict[str, Any]) -> tuple[Any, ...]:
    """The first legal move; a new episode after the last one."""
    said = env.step(int(np.flatnonzero(info["action_mask"])[0]))
    return (*env.reset(), *said[1:]) if said[2] else (said[0], said[4], *said[1:])


def same(one: Any, two: Any) -> None:
    np.testing.assert_equal(two, one)


def future(env: Any, info: dict[str, Any], count: int = 12) -> list[Any]:
    told = []
    for _ in range(count):
        told.append(step(env, info))
        info = told[-1][1]
    return told


@pytest.mark.parametrize("made", MADE)
@pytest.mark.parametrize("known_as", IDS)
def test_copies_in_mid_episode_go_their_own_way(known_as: str, made: str) -> None:
    """However it is made and copied, a copy has the same future, and neither changes the other."""
    env = gymnasium.make(known_as, **MADE[made]())
    _, info = env.reset(seed=3)
    _, info, *_ = step(env, info)
    copies = {how: copied(env) for how, copied in COPIED.items()}
    untouched = copy.deepcopy(env)
    futures = {how: future(each, info) for how, each in copies.items()}
    before = list(env.unwrapped.sequence), env.unwrapped.action_masks()
    expected = future(env, info)
    for how, told in futures.items():
        same(expected, told)
        same(expected[-1][1]["action_mask"], copies[how].unwrapped.action_masks())
    same(before, (list(untouched.unwrapped.sequence), untouched.unwrapped.action_masks()))
    assert untouched.unwrapped.mission.instance.same(
        copy.deepcopy(untouched).unwrapped.mission.instance
    )


def test_copies_share_timetables() -> None:
    """A deep copy costs no timetable, whether the field is drawn or given."""
    for made in ("instance", "fields"):
        env = MissionEnv(**MADE[made]())
        env.reset(seed=1)
        assert copy.deepcopy(env)._played is env._played


@pytest.mark.parametrize("uncertainty", [None, TROUBLED])
@pytest.mark.parametrize("how", COPIED)
def test_many_missions_are_copied_with_a_field_on_its_way(how: str, uncertainty: Any) -> None:
    """A copied MissionVecEnv has the same future, its coming field included."""
    env = MissionVecEnv(5, SMALL, slots=3, refresh_every=10, uncertainty=uncertainty)
    env.reset()
    for _ in range(30):
        env.step(env.action_masks().argmax(axis=1))
        if env._coming is not None:
            break
    assert env._coming is not None
    other = COPIED[how](env)
    for _ in range(20):
        told = [each.step(each.action_masks().argmax(axis=1)) for each in (env, other)]
        same(*told)
    env.close()
    other.close()


@pytest.mark.parametrize("made", MADE)
@pytest.mark.parametrize("known_as", IDS)
def test_a_specification_goes_through_json(known_as: str, made: str) -> None:
    """The environment of a specification read from JSON plays the same episodes."""
    env = gymnasium.make(known_as, **MADE[made]())
    again = gymnasium.make(EnvSpec.from_json(env.spec.to_json()))
    starts = [each.reset(seed=5) for each in (env, again)]
    same(*starts)
    same(*(future(each, starts[0][1]) for each in (env, again)))


@pytest.mark.parametrize("known_as", IDS)
def test_the_registered_specification_goes_through_json(known_as: str) -> None:
    """What is registered can be written and read, and a vector of it as well."""
    spec = EnvSpec.from_json(gymnasium.spec(known_as).to_json())
    assert spec == gymnasium.spec(known_as)
    env = gymnasium.make_vec(spec, num_envs=2, fields=SMALL, pool=1)
    assert json.loads(env.unwrapped.spec.to_json())["kwargs"]["fields"]["family"] == "tiny"


def test_an_instance_with_more_than_its_file_stays_out_of_json(tmp_path: Path) -> None:
    """JSON refuses an instance whose file does not say all, and takes the path of a file."""
    env = gymnasium.make(ID, instance=tiny().with_time_value(7.0))
    with pytest.raises(TypeError, match="Instance is not JSON serializable"):
        env.spec.to_json()
    tiny().save(tmp_path / "tiny.json")
    env = gymnasium.make(ID, instance=tmp_path / "tiny.json")
    again = gymnasium.make(EnvSpec.from_json(env.spec.to_json()))
    same(env.reset(seed=1), again.reset(seed=1))


@pytest.mark.parametrize("known_as", IDS)
@pytest.mark.parametrize("mode", ["sync", "async"])
def test_a_categorical_draws_through_the_end_of_episodes(known_as: str, mode: str) -> None:
    """Where Gymnasium resets at the next step, every mask has an action to draw."""
    torch = pytest.importorskip("torch")
    env = gymnasium.make_vec(
        known_as, 2, mode, {"autoreset_mode": AutoresetMode.NEXT_STEP}, fields=SMALL, pool=2
    )
    _, info = env.reset(seed=1)
    ends = 0
    for _ in range(30):
        legal = torch.as_tensor(info["action_mask"], dtype=torch.float64)
        drawn = torch.distributions.Categorical(probs=legal).sample()
        _, rewards, terminated, _, info = env.step(drawn.numpy())
        assert (rewards >= 0.0).all()
        ends += int(terminated.sum())
    assert ends > 2
    env.close()


@pytest.mark.parametrize("made", [each for each in MADE if each != "no pool"])
@pytest.mark.parametrize("known_as", IDS)
def test_gymnasium_makes_many_at_once(known_as: str, made: str) -> None:
    """What `make_vec` makes keeps its spaces, repeats by seed, and plays missions by the rules."""
    runs = []
    for _ in range(2):
        env = gymnasium.wrappers.vector.RecordEpisodeStatistics(
            gymnasium.make_vec(known_as, num_envs=3, **MADE[made]())
        )
        told = [env.reset(seed=4)]
        for _ in range(15):
            info = told[-1][-1]
            told.append(env.step(info["action_mask"].argmax(axis=1)))
        env.close()
        runs.append(told)
        for observation, *_, info in told:
            assert env.observation_space.contains(observation)
            assert info["action_mask"].any(axis=1).all()
        ended = [said for said in told[1:] if said[2].any()]
        assert ended
        for _, rewards, terminated, truncated, info in ended:
            assert not truncated.any()
            assert (rewards >= 0.0).all()
            same(info["_final_obs"], terminated)
            same(info["final_info"]["_serviced"], terminated)
            for index in np.flatnonzero(terminated):
                assert env.single_observation_space.contains(info["final_obs"][index])
    for one, two in zip(*runs, strict=True):
        same(one[0], two[0])


def test_seeds_choose_among_the_fields_of_a_pool() -> None:
    """A seed of `make_vec` chooses among the fields of a pool; what cannot be done is refused."""
    env = gymnasium.make_vec(ID, num_envs=8, fields=SMALL, pool=4)
    starts = [env.reset(seed=seed)[1]["delta_v_left_m_s"] for seed in (1, 2, 1)]
    pool = env.unwrapped.missions.pool
    same(starts[0], starts[2])
    assert (starts[0] != starts[1]).any()
    assert env.unwrapped.missions.pool is pool
    with pytest.raises(InputError, match="take no options"):
        env.reset(options={"targets": (3, 3)})
    with pytest.raises(InputError, match="have no pictures"):
        gymnasium.make_vec(ID, num_envs=2, fields=SMALL, render_mode="ansi")
    with pytest.raises(InputError, match="slots = 0"):
        gymnasium.make_vec(ID, num_envs=2, fields=SMALL, pool=0)


def test_one_mission_and_many_play_alike() -> None:
    """Of one instance, `make` and `make_vec` give the same rewards, observations and figures."""
    one, many = gymnasium.make(ID, instance=tiny()), gymnasium.make_vec(ID, 2, instance=tiny())
    (seen, info), (all_seen, all_info) = one.reset(seed=0), many.reset(seed=0)
    terminated = False
    while not terminated:
        same(seen, {name: part[1] for name, part in all_seen.items()})
        same(info, {name: all_info[name][1] for name in info})
        action = int(np.flatnonzero(info["action_mask"])[0])
        seen, reward, terminated, _, info = one.step(action)
        all_seen, rewards, ended, _, all_info = many.step(np.full(2, action))
        assert rewards.tolist() == [reward] * 2
        assert ended.tolist() == [terminated] * 2
    same(seen, all_info["final_obs"][1])
    assert all_info["final_info"]["collected"][1] == info["collected"]
    many.close()


def test_gymnasium_finds_it_by_its_module() -> None:
    """In a process that imports Gymnasium alone, the id after the module makes the environment."""
    wanted = [f"adr_opt.learning.environment:{known_as}" for known_as in IDS]
    code = (
        "import gymnasium, sys; assert not any(m.startswith('adr_opt') for m in sys.modules); "
        f"print(*(gymnasium.make(each).unwrapped for each in {wanted}))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.count("MissionEnv") == len(IDS)
