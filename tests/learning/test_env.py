"""The Gymnasium environment: the protocol, the rules, and what a user may get wrong."""

from __future__ import annotations

import dataclasses
import importlib
import re
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from random_rules import drifting_field
from sb3_contrib.common.maskable.utils import get_action_masks, is_masking_supported
from seeds import first_of
from small_fields import SMALL, tiny

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.kernels.episodes.choices import (
    CHOICE_FIELDS,
    LIMIT,
    LOOKED_AHEAD,
    MISSION_FIELDS,
    NEAREST,
    ONWARD,
)
from adr_opt.kernels.episodes.published import PUBLISHED_ELEMENTS
from adr_opt.learning.environment import (
    ID,
    OBSERVATIONS,
    PUBLISHED,
    VARIED,
    Fields,
    Limits,
    MissionEnv,
    space,
)
from adr_opt.learning.environment.drawn import ready
from adr_opt.learning.environment.fields import FIRST_SEED
from adr_opt.mission.certified import certify
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance


def play(env: MissionEnv, rng: np.random.Generator) -> tuple[float, list[Any]]:
    """The return of a masked random episode that has begun, and all that was observed."""
    total, seen = 0.0, []
    while True:
        mask = env.action_masks()
        assert mask.any()
        action = rng.choice(np.flatnonzero(mask))
        observation, reward, terminated, truncated, info = env.step(action)
        assert not truncated
        assert reward == (0.0 if action == env.action_space.n - 1 else 1.0)
        np.testing.assert_array_equal(info["action_mask"], env.action_masks())
        total += reward
        seen.append(observation)
        if terminated:
            assert np.flatnonzero(env.action_masks()).tolist() == [env.action_space.n - 1]
            return total, seen


def counted(env: MissionEnv, total: float) -> Plan:
    """The plan of an episode, which passes ``check`` and is worth what the episode returned."""
    plan = certify(env.mission, "episode", env.sequence, seed=0, runtime_s=0.0).plan
    assert plan is not None
    assert plan.objective == total
    assert adr_opt.check(env.mission.instance, plan) == ()
    return plan


@pytest.mark.parametrize("observation", OBSERVATIONS)
def test_two_environments_of_one_seed_keep_in_lock_step(observation: str) -> None:
    """The same seed and actions give the same fields, observations, masks and rewards."""
    envs = [MissionEnv(fields=SMALL, observation=observation) for _ in range(2)]
    rng = np.random.default_rng(0)
    for episode in range(8):
        seen = [env.reset(seed=7 if episode == 0 else None) for env in envs]
        assert envs[0].mission.instance == envs[1].mission.instance
        over = False
        while True:
            np.testing.assert_equal(seen[0][0], seen[1][0])
            masks = [env.action_masks() for env in envs]
            np.testing.assert_array_equal(*masks)
            if over:
                break
            action = rng.choice(np.flatnonzero(masks[0]))
            seen = [env.step(action) for env in envs]
            assert seen[0][1:4] == seen[1][1:4]
            over = seen[0][2]
    other = MissionEnv(fields=SMALL)
    other.reset(seed=8)
    first = MissionEnv(fields=SMALL)
    first.reset(seed=7)
    assert other.mission.instance != first.mission.instance


@pytest.mark.parametrize("episodes", first_of([20, 40], gate=1))
@pytest.mark.parametrize("observation", OBSERVATIONS)
def test_random_episodes_stay_in_their_space_and_count_what_check_counts(
    observation: str, episodes: int
) -> None:
    """Every observation of masked random episodes lies in its space, and returns are objectives."""
    env = MissionEnv(fields=SMALL, observation=observation)
    rng = np.random.default_rng(1)
    sizes, returns = set(), []
    for episode in range(episodes):
        first, info = env.reset(seed=100 + episode)
        assert info["action_mask"].dtype == np.int8
        sizes.add(len(env.mission.instance.targets))
        total, seen = play(env, rng)
        for each in (first, *seen):
            assert env.observation_space.contains(each)
        counted(env, total)
        returns.append(total)
    assert len(sizes) > 3
    assert len(set(returns)) > 3


@pytest.mark.parametrize("observation", OBSERVATIONS)
def test_missions_whose_planes_drift(observation: str) -> None:
    """Days and months under J2 are played in their space, and returns are what `check` counts."""
    rng = np.random.default_rng(4)
    short = adr_opt.generate("tiny", 3, targets=6).replace(dynamics="j2")
    visits, kinds = 0, set[str]()
    for instance in (short, drifting_field(rng, 120 * 86400.0), short.with_limits(delta_v_m_s=1e4)):
        env = MissionEnv(instance, observation=observation, render_mode="rgb_array")
        for _ in range(4):
            first, _ = env.reset()
            before = env.render()
            total, seen = play(env, rng)
            assert (env.render() != before).any()
            for each in (first, *seen):
                assert env.observation_space.contains(each)
            plan = counted(env, total)
            visits += len(env.sequence)
            kinds |= {leg.kind for leg in plan.legs}
    assert visits > 20
    assert kinds == {"short", "drift"}


@pytest.mark.parametrize("delta_v", [1e-9, 0.5, 20.0, 140.0])
def test_tiny_budgets_give_no_nan(delta_v: float) -> None:
    """However small the budget, an observation is finite, or there is one sentence about it."""
    for observation in OBSERVATIONS:
        env = MissionEnv(tiny(delta_v_m_s=delta_v), observation=observation)
        try:
            seen, _ = env.reset()
        except InputError as error:
            assert "no move is legal at the start" in str(error)  # noqa: PT017
            with pytest.raises(InputError, match="over"):
                env.step(np.int64(0))
            continue
        assert env.observation_space.contains(seen)
        _, later = play(env, np.random.default_rng(0))
        assert all(env.observation_space.contains(each) for each in later)


def test_illegal_actions_end_the_episode() -> None:
    """An illegal action costs 1 and ends the episode; a step after the end is refused."""
    env = MissionEnv(tiny())
    targets = len(tiny().targets)
    for action in (targets, targets + 1, -1, 10**6):  # no refuelling at the start; no such action
        env.reset()
        assert not (0 <= action <= targets and env.action_masks()[action])
        before = env.sequence.copy()
        _, reward, terminated, truncated, _ = env.step(np.int64(action))
        assert (reward, terminated, truncated) == (-1.0, True, False)
        assert env.sequence == before
        with pytest.raises(InputError, match="the episode is over"):
            env.step(np.int64(0))
    env.reset()
    action = int(np.flatnonzero(env.action_masks())[0])
    env.step(np.int64(action))
    _, reward, terminated, *_ = env.step(np.int64(action))  # serviced already
    assert (reward, terminated) == (-1.0, True)


def test_a_given_instance_is_played() -> None:
    """``instance`` is played at every reset, in its own order; ``options`` may give another."""
    env = gymnasium.make(ID, instance=tiny(4)).unwrapped
    assert isinstance(env, MissionEnv)
    for _ in range(2):
        env.reset()
        assert env.mission.instance == tiny(4)
    action = np.flatnonzero(env.action_masks())[-1]
    env.step(action)
    assert env.sequence == [action + 1]
    smaller = adr_opt.generate("tiny", 9, targets=4)
    _, info = env.reset(options={"instance": smaller})
    assert env.mission.instance == smaller
    assert not info["action_mask"][4:-1].any()
    env.reset()
    assert env.mission.instance == tiny(4)


def test_options_change_the_fields_of_one_reset() -> None:
    """``options`` hold for one reset; every field of ``Fields`` is one."""
    env = MissionEnv(fields=SMALL)
    env.reset(seed=0, options={"targets": (5, 5), "share_of_family": 0.0, "zones": (2, 2)})
    assert len(env.mission.instance.targets) == 5
    assert len(env.mission.instance.keep_out_zones) == 2
    limits = {"delta_v_m_s": (900.0, 900.0), "duration_s": (90e3, 90e3), "share_of_limits": 0.0}
    env.reset(options=limits)
    assert env.mission.instance.chaser.tank.delta_v_m_s == 900.0
    assert env.mission.instance.mission.duration_s == 90e3
    env.reset(options={"share_of_limits": 1.0})
    assert env.mission.instance.chaser.tank.delta_v_m_s == 2000.0


WRONG: dict[str, Callable[[], Any]] = {
    "observation 'pictures' is unknown": lambda: MissionEnv(observation="pictures"),
    "render_mode 'human' is unknown": lambda: MissionEnv(render_mode="human"),
    "option 'target' is unknown": lambda: MissionEnv(fields=SMALL).reset(options={"target": 3}),
    "family 'huge' is unknown": lambda: Fields("huge"),
    "give a pair of whole numbers": lambda: Fields(targets=(3.5, 9)),  # type: ignore[arg-type]
    r"targets = \(9, 3\)": lambda: Fields(targets=(9, 3)),
    "zones = 4": lambda: Fields(zones=4),  # type: ignore[arg-type]
    "delta_v_m_s = .*: give a pair of numbers": lambda: Fields(delta_v_m_s=(1.0, float("nan"))),
    "duration_s = -1.0: must be": lambda: Limits(100.0, -1.0),
    "share_of_family = 2.0": lambda: Fields(share_of_family=2.0),
    "dynamics = 'j3': must be": lambda: Fields(dynamics="j3"),  # type: ignore[arg-type]
    "no limits to draw from": lambda: Fields(share_of_limits=0.5),
    "more than the 6 of the action space": lambda: MissionEnv(
        adr_opt.generate("tiny", 0, targets=6)
    ).reset(options={"instance": adr_opt.generate("tiny", 0, targets=7)}),
    "x.json: no such file": lambda: MissionEnv(instance="x.json"),
    "y.json: no such file": lambda: MissionEnv(tiny()).reset(options={"instance": "y.json"}),
    "instance of type int: give an Instance": lambda: MissionEnv(3),  # type: ignore[arg-type]
    "option 'target' is unknown; use": lambda: MissionEnv(fields={"target": 3}),
    "pool = -1: must be a whole number": lambda: MissionEnv(pool=-1),
    "pool_seed = 0.5: must be": lambda: MissionEnv(pool_seed=0.5),  # type: ignore[arg-type]
    "fields = 3: must be": lambda: MissionEnv(fields=3),
    "options = 'abc': must be a dictionary": lambda: MissionEnv(fields=SMALL).reset(options="abc"),
    "share_of_limits = 'a': must be": lambda: Fields(share_of_limits="a"),
    "give pairs of ΔV budget and duration": lambda: Fields(limits=(3.0,)),
    "but an instance is given": lambda: MissionEnv(tiny()).reset(options={"targets": (3, 3)}),
    "no targets": lambda: MissionEnv(adr_opt.generate("tiny", 0, targets=0)),
    "no move is legal at the start": lambda: MissionEnv(tiny(delta_v_m_s=0.0)).reset(),
    "it needs targets, more duration_s or": lambda: MissionEnv(tiny(duration_s=60.0)).reset(),
    "call reset before the next step": lambda: MissionEnv(tiny()).step(np.int64(0)),
    "call reset first": lambda: MissionEnv(tiny()).action_masks(),
    "no mission has begun": lambda: MissionEnv(tiny()).mission,
    "action 1.5: must be a whole number": lambda: _begun().step(1.5),  # type: ignore[arg-type]
}


def _begun() -> MissionEnv:
    env = MissionEnv(tiny())
    env.reset()
    return env


@pytest.mark.parametrize("sentence", WRONG)
def test_wrong_input_is_refused_in_one_sentence(sentence: str) -> None:
    """What cannot be meant is refused by an InputError that names it."""
    with pytest.raises(InputError, match=sentence) as caught:
        WRONG[sentence]()
    assert "\n" not in str(caught.value)


def test_pictures_and_text() -> None:
    """``ansi`` states time, ΔV and visits; ``rgb_array`` is a picture that changes with them."""
    env = MissionEnv(tiny(), render_mode="ansi")
    assert env.render() is None
    env.reset()
    start = env.render()
    assert start.startswith("0.0 of 36.0 h, 1000 of 1000 m/s left, at station: 0 of ")
    action = np.flatnonzero(env.action_masks())[0]
    env.step(action)
    assert f"at {tiny().targets[action].name}: 1 of " in env.render()
    env = MissionEnv(tiny(), render_mode="rgb_array")
    env.reset()
    before = env.render()
    env.step(action)
    after = env.render()
    assert before.shape == after.shape == (400, 400, 3)
    assert before.dtype == np.uint8
    assert (before != after).any()
    silent = MissionEnv(tiny())
    silent.reset()
    assert silent.render() is None


def test_gymnasium_makes_it_with_its_own_checks() -> None:
    """``gymnasium.make`` wraps it in its checks, and a whole episode passes them silently."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(ID, fields=SMALL)
        _, info = env.reset(seed=5)
        assert is_masking_supported(env)
        terminated = False
        while not terminated:
            np.testing.assert_array_equal(get_action_masks(env), info["action_mask"])
            action = env.action_space.sample(mask=info["action_mask"])
            _, _, terminated, _, info = env.step(action)
        env.close()


def make() -> MissionEnv:
    return MissionEnv(fields=SMALL)


def test_spaces_are_as_wide_as_stated() -> None:
    """The spaces have the documented shapes and limits, for any number of targets."""
    for targets in (1, 50, 200):
        assert space("published", targets).shape == (7 * targets + 8,)
        assert space("choices", targets)["moves"].shape == (targets + 1, 36)
        assert space("choices", targets)["mission"].shape == (15,)
    box = space("published", 3)
    assert (box.low == -LIMIT).all()
    assert (box.high == LIMIT).all()
    assert PUBLISHED.most_targets == 50
    assert VARIED.most_targets == 60
    assert MissionEnv(fields=VARIED).action_space.n == 61


def test_the_page_lists_every_number_option_and_observation() -> None:
    """docs/environment.md has the fields of every observation in their order, and all options."""
    page = (Path(__file__).parents[2] / "docs/environment.md").read_text(encoding="utf-8")
    tables = [
        re.findall(r"^\| (\d+) \| (.*) \|$", section, re.MULTILINE)
        for section in page.split("\n### ")[1:]
    ]
    wanted = [
        list(enumerate(CHOICE_FIELDS)),
        list(enumerate(MISSION_FIELDS)),
        list(enumerate(PUBLISHED_ELEMENTS)),
    ]
    assert [[(int(number), name) for number, name in table] for table in tables] == wanted
    options = re.findall(r"^\| `([a-z_]+)` \|", page, re.MULTILINE)
    assert options == [field.name for field in dataclasses.fields(Fields)]
    assert set(re.findall(r"^- `([a-z]+)`: a", page, re.MULTILINE)) == set(OBSERVATIONS)
    for stated in (
        f"shape (N + 1, {len(CHOICE_FIELDS)})",
        f"shape ({len(MISSION_FIELDS)},)",
        f"within ±{LIMIT:g}",
        f"seeds from {FIRST_SEED:,} on",
        f"for the {LOOKED_AHEAD} cheapest legal moves",
        f"first {ONWARD} open ones of the {NEAREST} targets",
    ):
        assert stated in " ".join(page.split()), stated


def test_the_examples_of_the_page_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The examples of docs/environment.md run as they stand, but for their fields.

    The episode that the first one plays becomes a plan file that passes ``check``.
    """
    monkeypatch.chdir(tmp_path)
    page = (Path(__file__).parents[2] / "docs/environment.md").read_text(encoding="utf-8")
    first, planned, second, *_ = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names: dict[str, Any] = {"SMALL": SMALL}
    exec(first.replace("adr_opt.learning.environment.VARIED", "SMALL"), names)
    assert names["terminated"]
    exec(planned, names)
    plan = adr_opt.load_plan("episode.plan.json")
    assert plan.legs
    assert adr_opt.check(adr_opt.load("episode.json"), plan) == ()
    exec(second.replace("256, VARIED", "4, SMALL").replace("slots=64", "slots=2"), names | {})


def trained(*more: object) -> str:
    """What the script that trains says of a small family, with more options."""
    root = Path(__file__).parents[2]
    line = f"{root}/examples/training/maskable_ppo.py --family tiny --pool 2 --steps 100 --fields 2"
    command = [sys.executable, *line.split(), *map(str, more)]
    return subprocess.run(command, cwd=root, capture_output=True, text=True, check=True).stdout


@pytest.mark.slow
def test_the_script_that_trains_runs(tmp_path: Path) -> None:
    """examples/training/maskable_ppo.py trains on a small family, and writes a plan that passes."""
    out = tmp_path / "plan.json"
    said = trained("--out", out)
    assert "steps trained in" in said
    assert said.count("mean of 2 fields") == 3
    assert adr_opt.check(adr_opt.generate("tiny", 0), adr_opt.load_plan(out)) == ()


@pytest.mark.slow
def test_the_script_without_a_library_of_learners_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """examples/training/ppo_alone.py steps, learns and evaluates."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "examples" / "training"))
    alone = importlib.import_module("ppo_alone")
    assert 0.0 < alone.main(600, count=8, pool=2, held=1) <= 50.0


@pytest.mark.slow
def test_the_environment_plays_in_torchrl(monkeypatch: pytest.MonkeyPatch) -> None:
    """examples/training/torchrl_missions.py plays legal moves to the end of each mission."""
    pytest.importorskip("torchrl")
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "examples" / "training"))
    for told in importlib.import_module("torchrl_missions").main(2):
        assert told["next", "done"].sum() == 1
        assert told["action_mask"].gather(1, told["action"].unsqueeze(1)).all()


@pytest.mark.slow
def test_the_script_trains_in_uncertain_worlds() -> None:
    """With ``--worlds`` the script trains in them, and three policies play the same worlds."""
    assert trained("--worlds", 3).count("mean of 6 worlds") == 3


def test_fields_drawn_ahead_are_worked_out_once_and_shared(monkeypatch: pytest.MonkeyPatch) -> None:
    """Environments of a process play on one pool, and no reset works out a timetable any more."""
    made: list[Instance] = []

    def counted(instance: Instance) -> Any:
        made.append(instance)
        return ready(instance)

    monkeypatch.setattr("adr_opt.learning.environment.drawn.ready", counted)
    envs = [MissionEnv(fields=SMALL, pool=5, pool_seed=77) for _ in range(3)]
    assert made == []
    names = set()
    for episode in range(30):
        env = envs[episode % 3]
        env.reset(seed=episode)
        names.add(env.mission.instance.name)
    assert len(made) == 5 + 1  # and the lowest field once more, for the number of its events
    assert names == {each.name for each in made}
    assert len({id(env._played) for env in envs}) == 1
    MissionEnv(fields=SMALL, pool=4, pool_seed=77).reset()
    assert len(made) == 6 + 4 + 1


def test_episodes_on_drawn_fields_are_missions_of_their_own() -> None:
    """What is legal on a field drawn ahead is legal in ``env.mission``, at the same cost.

    The budget and the duration are those of the mission, also where planes drift.
    """
    rng = np.random.default_rng(5)
    for dynamics in ("two-body", "j2"):
        fields = dataclasses.replace(SMALL, dynamics=dynamics)
        env = MissionEnv(fields=fields, pool=4)
        limits = set()
        for seed in range(6):
            env.reset(seed=seed)
            instance = env.mission.instance
            own = MissionEnv(instance)
            own.reset()
            limits.add((instance.chaser.tank.delta_v_m_s, instance.mission.duration_s))
            over = False
            while not over:
                mask = env.action_masks()
                targets = len(instance.targets)
                mine = np.append(np.flatnonzero(mask[:-1]), [targets] * int(mask[-1]))
                np.testing.assert_array_equal(mine, np.flatnonzero(own.action_masks()))
                at = rng.integers(mine.size)
                _, reward, over, _, info = env.step(int(np.flatnonzero(mask)[at]))
                _, same, _, _, info_of_own = own.step(int(mine[at]))
                assert reward == same
                for figure in ("time_s", "delta_v_left_m_s", "collected"):
                    assert info[figure] == info_of_own[figure]
            counted(env, info["collected"])
        assert len(limits) > 2


def test_without_a_pool_every_reset_draws_another_field() -> None:
    """``pool=0`` draws a field for each mission; the seed of a pool determines its fields."""

    def names(**options: int) -> set[str]:
        env = MissionEnv(fields=SMALL, **options)
        found = set()
        for seed in range(12):
            env.reset(seed=seed)
            found.add(env.mission.instance.name)
        return found

    assert len(names(pool=0)) == 12
    assert len(names(pool=1)) == 1
    assert names(pool=3, pool_seed=1).isdisjoint(names(pool=3, pool_seed=2))


@pytest.mark.slow
def test_practice_compiles_all_that_an_environment_calls() -> None:
    """After ``episodes.practise`` neither environment asks for a kernel of other arguments."""
    code = """
from adr_opt.learning.episodes import practise
from numba.core.dispatcher import Dispatcher
import gc
def known():
    return {(id(each), signature) for each in gc.get_objects() if isinstance(each, Dispatcher)
            for signature in each.overloads}
practise()
from adr_opt.learning.environment import *
from small_fields import SMALL
before = known()
for name, model in [*((name, None) for name in OBSERVATIONS), ("choices", TROUBLED)]:
    env = MissionEnv(fields=SMALL, pool=2, observation=name, uncertainty=model)
    _, info = env.reset(seed=0)
    env.step(int(info["action_mask"].argmax()))
    many = MissionVecEnv(40, SMALL, slots=2, observation=name, uncertainty=model)
    many.reset()
    many.step(many.action_masks().argmax(axis=1))
    many.close()
new = known() - before
assert not new, new
"""
    subprocess.run(
        [sys.executable, "-c", code], cwd=Path(__file__).parents[1] / "fields", check=True
    )
