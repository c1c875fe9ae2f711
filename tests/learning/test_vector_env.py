"""Many missions at once: in step with single ones, and true to Stable-Baselines3's protocol."""

from __future__ import annotations

import copy
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from conftest import Cli, refused
from sb3_contrib.common.maskable.utils import get_action_masks, is_masking_supported
from small_fields import SMALL as VARIED
from stable_baselines3.common.vec_env import VecMonitor

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.learning.environment import (
    OBSERVATIONS,
    TROUBLED,
    TROUBLES,
    Fields,
    MissionEnv,
    MissionVecEnv,
)
from adr_opt.learning.episodes import FieldPool, pool
from adr_opt.problem.uncertainty import Uncertainty

SMALL = Fields("tiny", targets=(3, 9), zones=(0, 3), delta_v_m_s=(300.0, 1500.0))
"""All missions last as long as the field's timetable does."""

ALIKE = replace(VARIED, duration_s=None, limits=(), share_of_limits=0.0)
"""The same of other sizes."""

MODELS = (Uncertainty(), TROUBLED, TROUBLES[-1])

DRIFTING = Fields("tiny", targets=(3, 7), dynamics="j2")
"""With one budget: where planes drift, a larger one has connections that others lack."""


def vector(**options: Any) -> MissionVecEnv:
    return MissionVecEnv(
        **{"count": 12, "fields": SMALL, "slots": 5, "seed": 3} | options  # type: ignore[arg-type]
    )


def choose(env: MissionVecEnv, rng: np.random.Generator) -> Any:
    """Legal actions at random."""
    mask = env.action_masks()
    assert mask.any(axis=1).all()
    return (mask * rng.random(mask.shape)).argmax(axis=1)


def rows_of(observation: Any, index: int) -> Any:
    if isinstance(observation, dict):
        return {name: part[index].copy() for name, part in observation.items()}
    return observation[index].copy()


@pytest.mark.parametrize(
    ("fields", "observation", "uncertainty"),
    [
        (SMALL, "choices", None),
        (ALIKE, "choices", MODELS),
        *(
            pytest.param(*each, marks=pytest.mark.slow)
            for each in (
                (SMALL, "published", None),
                (DRIFTING, "choices", None),
                (DRIFTING, "published", None),
                (ALIKE, "published", MODELS),
            )
        ),
    ],
)
def test_single_missions_keep_in_lock_step(
    fields: Fields, observation: str, uncertainty: Any
) -> None:
    """A single environment in the same world sees, may do and earns the same at every step."""
    env = vector(
        count=12 if uncertainty is None else 8,
        fields=fields,
        observation=observation,
        refresh_every=60,
        threads=2,
        uncertainty=uncertainty,
    )
    rng, ended, lost = np.random.default_rng(0), 0, Counter[str]()

    def alone(index: int) -> tuple[MissionEnv, Any]:
        instance = env.pool.instances[env.episodes.slot[index]]
        assert instance is not None
        limited = instance.with_limits(delta_v_m_s=float(env.episodes.budget[index]))
        options, model = {"instance": limited}, None
        if env.worlds is not None:
            model = MODELS[env.worlds.states.model[index]]
            options["world"] = int(env.worlds.states.seed[index])
        single = MissionEnv(fields=fields, observation=observation, uncertainty=model)
        return single, single.reset(options=options)[0]

    seen = env.reset()
    singles = [alone(index) for index in range(env.num_envs)]
    for _ in range(40 if uncertainty is None else 25):
        masks = env.action_masks()
        for index, (single, sight) in enumerate(singles):
            np.testing.assert_array_equal(masks[index], single.action_masks())
            np.testing.assert_equal(rows_of(seen, index), sight)
        actions = choose(env, rng)
        seen, rewards, dones, infos = env.step(actions)
        for index, (single, _) in enumerate(singles):
            sight, reward, terminated, truncated, info = single.step(actions[index])
            assert (reward, terminated, truncated) == (rewards[index], dones[index], False)
            singles[index] = single, sight
            if not terminated:
                assert infos[index] == {}
                continue
            ended += 1
            told = infos[index]
            np.testing.assert_equal(told["terminal_observation"], sight)
            assert told["serviced"] == info["serviced"]
            assert told["episode"]["l"] == len(single.sequence)
            assert told["TimeLimit.truncated"] is False
            if uncertainty is None:
                assert told["episode"]["r"] == info["serviced"]
            else:
                assert told["losses"] == Counter(info["losses"].values())
                assert (told["world"], told["collected"]) == (info["world"], info["collected"])
                lost.update(told["losses"])
            singles[index] = alone(index)
    env.close()
    assert ended > env.num_envs
    assert uncertainty is None or len(lost) > 2


@pytest.mark.parametrize(("threads", "uncertainty"), [(1, None), (3, None), (3, MODELS)])
def test_a_seed_determines_everything(threads: int, uncertainty: Any) -> None:
    """Two of one seed keep in lock-step while fields are renewed, whatever their threads.

    Fields are those of one without uncertainty.
    """
    one, two = (
        vector(fields=VARIED, refresh_every=30, threads=each, uncertainty=uncertainty)
        for each in (1, threads)
    )
    first_fields = list(one.pool.instances)
    assert vector(fields=VARIED, refresh_every=30).pool.instances == first_fields
    rng = np.random.default_rng(1)
    seen = [env.reset() for env in (one, two)]
    for _ in range(60):
        np.testing.assert_equal(seen[0], seen[1])
        np.testing.assert_array_equal(one.action_masks(), two.action_masks())
        actions = choose(one, rng)
        steps = [env.step(actions) for env in (one, two)]
        np.testing.assert_array_equal(steps[0][1], steps[1][1])
        np.testing.assert_array_equal(steps[0][2], steps[1][2])
        seen = [step[0] for step in steps]
        assert one.pool.instances == two.pool.instances
    replaced = sum(a != b for a, b in zip(first_fields, one.pool.instances, strict=True))
    assert replaced == len(first_fields)
    one.close()
    two.close()


def test_a_field_is_replaced_only_when_nobody_is_on_it() -> None:
    """While the pool is refreshed, the field under a running mission stays the same."""
    env = vector(fields=VARIED, refresh_every=20)
    rng = np.random.default_rng(2)
    env.reset()
    fields: list[Any] = [None] * env.num_envs
    fresh = np.ones(env.num_envs, dtype=bool)
    for _ in range(60):
        for index, slot in enumerate(env.episodes.slot):
            if fresh[index]:
                fields[index] = env.pool.instances[slot]
            assert env.pool.instances[slot] is fields[index]
        users = np.bincount(env.episodes.slot, minlength=5)
        np.testing.assert_array_equal(users, env._users)
        fresh = env.step(choose(env, rng))[2]
    env.close()


CAMPAIGN = Fields("campaign", targets=(6, 9), delta_v_m_s=(150.0, 600.0))
CLOUD = Fields("cloud", targets=(4, 7), duration_s=(86400.0, 172800.0))


def test_several_distributions_have_slots_in_turn() -> None:
    """Fields and budgets of a slot are those of its distribution, and stay so when replaced."""
    kinds = (SMALL, CAMPAIGN, CLOUD)
    env = vector(fields=kinds, slots=6, refresh_every=20)
    rng = np.random.default_rng(4)
    env.reset()
    for _ in range(40):
        for slot, field in enumerate(env.pool.instances):
            assert field is not None
            assert field.name.startswith(kinds[slot % 3].family)
        for slot, budget in zip(env.episodes.slot, env.episodes.budget, strict=True):
            low, high = kinds[slot % 3].delta_v_m_s or (4000.0, 4000.0)
            assert low <= budget <= high
        env.step(choose(env, rng))
    env.close()


def test_one_distribution_in_a_sequence_is_that_one() -> None:
    """Alone or as the only one of several, a distribution gives the same missions by a seed."""
    one, other = vector(refresh_every=20), vector(fields=(SMALL,), refresh_every=20)
    for env in (one, other):
        env.reset()
    rng = np.random.default_rng(5)
    for _ in range(30):
        actions = choose(one, rng)
        np.testing.assert_equal(one.step(actions)[0], other.step(actions)[0])
    one.close()
    other.close()


@pytest.mark.parametrize("uncertainty", [None, {"capture": {"success": 0.5}, "gone": 0.1}])
def test_a_campaign_is_played_chaser_by_chaser(uncertainty: Any) -> None:
    """The next chaser begins with a full tank at the start, and with the targets that are left."""
    env, rng = vector(count=6, fields=CAMPAIGN, uncertainty=uncertainty), np.random.default_rng(6)
    env.reset()
    handed = 0
    for _ in range(200):
        left, slots = env._next_chasers.copy(), env.episodes.slot.copy()
        before = env.episodes.visited.copy()
        ended = env.step(choose(env, rng))[2]
        now, bodies = env.episodes, env.pool.arrays.counts[env.episodes.slot, 0]
        for index in np.flatnonzero(ended):
            assert now.time[index] == 0.0
            assert now.left[index] >= now.budget[index]
            if not now.visited[index, : bodies[index]].any():
                assert env._next_chasers[index] == 2  # another mission
                continue
            assert env._next_chasers[index] == left[index] - 1
            assert now.slot[index] == slots[index]
            assert now.visited[index][before[index]].all()
            handed += 1
    assert handed > 12
    env.close()


def test_seeding_again_begins_again() -> None:
    """A reset after ``seed`` starts from that seed alone; without it, the draws go on."""
    env = vector()
    begun = env.reset()
    before = copy.deepcopy(begun)
    later = env.reset()
    assert (later["moves"] != before["moves"]).any()
    env.step(choose(env, np.random.default_rng(0)))
    env.seed(3)
    again = env.reset()
    other = vector(seed=4)
    other.seed(3)
    same = other.reset()
    np.testing.assert_equal(again, before)
    np.testing.assert_equal(same, before)
    other.seed(9)
    assert (other.reset()["moves"] != before["moves"]).any()
    env.close()
    other.close()


def test_seeding_a_new_one_with_its_own_seed_keeps_its_pool() -> None:
    """Training seeds the environment once more before it begins; the pool is not drawn twice."""
    env = vector()
    pool = env.pool
    env.seed(3)
    env.reset()
    assert env.pool is pool
    env.close()


def test_observations_lie_in_the_space_and_stay_for_a_step() -> None:
    """Every row lies in the space; what a step returned is not touched by the next step."""
    for observation in OBSERVATIONS:
        env = vector(fields=VARIED, observation=observation, refresh_every=50)
        rng = np.random.default_rng(4)
        seen = env.reset()
        for _ in range(25):
            for index in range(env.num_envs):
                assert env.observation_space.contains(rows_of(seen, index))
            kept = copy.deepcopy(seen)
            later, rewards, _, infos = env.step(choose(env, rng))
            np.testing.assert_equal(seen, kept)
            for info in infos:
                if info:
                    assert env.observation_space.contains(info["terminal_observation"])
            assert rewards.dtype == np.float32
            assert (rewards >= 0.0).all()
            seen = later
        env.close()


def test_illegal_actions_end_their_mission_alone() -> None:
    """An illegal action earns −1 and a new mission; the others go on."""
    env = vector(reward_scale=0.5)
    env.reset()
    rng = np.random.default_rng(5)
    actions = choose(env, rng)
    actions[2] = env.action_space.n - 1  # there is nothing to refuel for
    actions[7] = 10**9
    time = env.episodes.time.copy()
    _, rewards, dones, infos = env.step(actions)
    wrong = np.isin(np.arange(env.num_envs), (2, 7))
    np.testing.assert_array_equal(rewards[wrong], -0.5)
    np.testing.assert_array_equal(rewards[~wrong], 0.5)
    assert dones[wrong].all()
    assert infos[7]["episode"]["r"] == -1.0
    assert infos[7]["episode"]["l"] == 1
    assert (env.episodes.time[~wrong & ~dones] > time[~wrong & ~dones]).all()
    assert (env.episodes.time[dones] == 0.0).all()
    env.close()


def test_missions_without_a_first_move_are_drawn_again() -> None:
    """Budgets that often allow nothing still give missions with a legal move."""
    env = vector(fields=Fields("tiny", delta_v_m_s=(1.0, 400.0)), count=40)
    env.reset()
    rng = np.random.default_rng(6)
    for _ in range(15):
        env.step(choose(env, rng))
    assert env.episodes.budget.min() > 1.0
    env.close()


def test_the_protocol_of_stable_baselines() -> None:
    """Masks by ``env_method``, attributes, wrappers and ``close`` work as its callers expect."""
    env = vector()
    env.reset()
    assert is_masking_supported(env)
    masks = get_action_masks(env)
    np.testing.assert_array_equal(masks, env.action_masks())
    assert masks.shape == (12, 10)
    assert len(env.env_method("action_masks", indices=[0, 5])) == 2
    np.testing.assert_array_equal(env.env_method("action_masks", indices=3)[0], masks[3])
    with pytest.raises(AttributeError, match="no method 'fly'"):
        env.env_method("fly")
    assert env.get_attr("render_mode", indices=[1, 2]) == [None, None]
    assert not env.has_attr("wings")
    env.set_attr("mood", "good")
    assert env.get_attr("mood") == ["good"] * 12
    assert env.env_is_wrapped(VecMonitor) == [False] * 12
    assert env.unwrapped is env
    assert list(env.get_images()) == [None] * 12
    monitored = VecMonitor(env)
    monitored.reset()
    rng = np.random.default_rng(7)
    lengths = []
    for _ in range(20):
        _, _, dones, infos = monitored.step(choose(env, rng))
        lengths += [info["episode"]["l"] for info, done in zip(infos, dones, strict=True) if done]
    assert min(lengths) >= 1
    env.close()
    env.close()


WRONG: dict[str, Callable[[], Any]] = {
    "count = 0": lambda: vector(count=0),
    "slots = 1: must be a whole number from 2 on": lambda: vector(slots=1, refresh_every=100),
    "refresh_every = -1": lambda: vector(refresh_every=-1),
    "threads = 0": lambda: vector(threads=0),
    "seed = -1": lambda: vector(seed=-1),
    "reward_scale = nan": lambda: vector(reward_scale=float("nan")),
    "observation 'x' is unknown": lambda: vector(observation="x"),
    "call reset before the first step": lambda: vector().step(np.zeros(12, dtype=int)),
    r"actions of shape \(3,\)": lambda: _begun().step(np.zeros(3, dtype=int)),
    "type float64: give one whole number": lambda: _begun().step(np.zeros(12)),
    "call step_async first": lambda: _begun().step_wait(),
    "takes no options": lambda: _with_options().reset(),
    "set it without indices": lambda: vector().set_attr("mood", "bad", indices=[0]),
    "6 distributions do not fit a pool of 5 slots": lambda: vector(fields=(SMALL,) * 6),
    "all have the same dynamics": lambda: vector(fields=(SMALL, DRIFTING)),
    "allow no move at all": lambda: vector(fields=Fields("tiny", delta_v_m_s=(0.1, 0.2))).reset(),
}


def _begun() -> MissionVecEnv:
    env = vector()
    env.reset()
    return env


def _with_options() -> MissionVecEnv:
    env = vector()
    env.set_options({"zones": (0, 1)})
    return env


@pytest.mark.parametrize("sentence", WRONG)
def test_wrong_input_is_refused_in_one_sentence(sentence: str) -> None:
    """What cannot be meant is refused by an InputError that names it."""
    with pytest.raises(InputError, match=sentence) as caught:
        WRONG[sentence]()
    assert "\n" not in str(caught.value)


def test_a_pool_beyond_the_memory_is_refused() -> None:
    """Thousands of targets with all their connections are refused before anything is taken."""
    with pytest.raises(adr_opt.InputError, match=r"500001 bodies with 206 departures each take"):
        FieldPool(1, 500_001, 206)


def test_ppo_says_so(cli: Cli, tiny_file: object, monkeypatch: pytest.MonkeyPatch) -> None:
    """The planner ends with a sentence and status 2 where the memory does not suffice."""
    monkeypatch.setattr(pool, "available_bytes", lambda: 1000.0)
    refused(cli("solve", tiny_file, "--method", "ppo"), "8 bodies", "use another method")
