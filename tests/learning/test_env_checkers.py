"""The checkers of Gymnasium and Stable-Baselines3: they pass, and fail on broken copies."""

# ruff: noqa: D102  the broken copies say in one sentence what is wrong with them

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from small_fields import SMALL, tiny
from stable_baselines3.common.env_checker import check_env as check_env_of_sb3

from adr_opt.learning.environment import ID, OBSERVATIONS, UNCERTAIN_ID, MissionEnv


@pytest.mark.parametrize(
    ("known_as", "observation"), [*((ID, each) for each in OBSERVATIONS), (UNCERTAIN_ID, "choices")]
)
def test_the_checkers_pass(known_as: str, observation: str) -> None:
    """Gymnasium and Stable-Baselines3 find nothing to say against the environment."""
    env = gymnasium.make(known_as, fields=SMALL, observation=observation)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Rows of moves are no pictures, and Stable-Baselines3 would rather have vectors.
        warnings.filterwarnings("ignore", message=".*unconventional shape.*")
        check_env(env.unwrapped, skip_render_check=True)
        check_env_of_sb3(env.unwrapped, warn=True)
        check_env(gymnasium.make(known_as, instance=tiny(), render_mode="ansi").unwrapped)
        check_env(gymnasium.make(known_as, instance=tiny(), render_mode="rgb_array").unwrapped)


class Outside(MissionEnv):
    """Observations outside the space."""

    def step(self, action: Any) -> Any:
        observation, *rest = super().step(action)
        return {name: part + 100.0 for name, part in observation.items()}, *rest

    def reset(self, **arguments: Any) -> Any:
        observation, info = super().reset(**arguments)
        return {name: part + 100.0 for name, part in observation.items()}, info


class Missing(MissionEnv):
    """A part of the observation is not there."""

    def reset(self, **arguments: Any) -> Any:
        observation, info = super().reset(**arguments)
        return {"moves": observation["moves"]}, info


class Wide(MissionEnv):
    """Numbers of 64 bits."""

    def reset(self, **arguments: Any) -> Any:
        observation, info = super().reset(**arguments)
        return {name: part.astype(float) for name, part in observation.items()}, info


class Nan(MissionEnv):
    """A number that is none."""

    def reset(self, **arguments: Any) -> Any:
        observation, info = super().reset(**arguments)
        observation["mission"][0] = np.nan
        return observation, info


class Four(MissionEnv):
    """A step in the old protocol."""

    def step(self, action: Any) -> Any:
        observation, reward, terminated, _, info = super().step(action)
        return observation, reward, terminated, info


class Words(MissionEnv):
    """A reward that is no number."""

    def step(self, action: Any) -> Any:
        observation, _, *rest = super().step(action)
        return observation, "much", *rest


class Silent(MissionEnv):
    """No info."""

    def reset(self, **arguments: Any) -> Any:
        return super().reset(**arguments)[0]


class Numbered(MissionEnv):
    """``terminated`` is no bool."""

    def step(self, action: Any) -> Any:
        observation, reward, terminated, *rest = super().step(action)
        return observation, reward, float(terminated), *rest


BROKEN = (Outside, Missing, Wide, Nan, Four, Silent)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("broken", BROKEN)
def test_the_checkers_fail_on_broken_copies(broken: type[MissionEnv]) -> None:
    """Each deliberate fault is found by both checkers."""
    for check in (check_env, check_env_of_sb3):
        with pytest.raises((AssertionError, ValueError, TypeError)):
            check(broken(tiny()))


class Unseeded(MissionEnv):
    """Forgets its seed."""

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        return super().reset(options=options)


class Leaking(MissionEnv):
    """Gives out the array that the next step overwrites."""

    def step(self, action: Any) -> Any:
        _, *rest = super().step(action)
        return self._board.arrays, *rest


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("broken", "check"),
    [
        (Unseeded, check_env),
        (Leaking, check_env),
        (Words, check_env_of_sb3),
        (Numbered, check_env_of_sb3),
    ],
    ids=lambda it: it.__module__ if it in (check_env, check_env_of_sb3) else it.__name__,
)
def test_a_checker_fails_on_faults_that_the_other_does_not_see(
    broken: Callable[..., MissionEnv], check: Callable[[Any], None]
) -> None:
    """A forgotten seed, an array that changes afterwards and odd types are found."""
    env = broken(tiny()) if broken is not Unseeded else broken(fields=SMALL)
    with pytest.raises((AssertionError, ValueError)):
        check(env)
