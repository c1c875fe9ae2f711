"""The checkers of Gymnasium and Stable-Baselines3: they pass."""

from __future__ import annotations

import warnings

import gymnasium
import pytest
from gymnasium.utils.env_checker import check_env
from small_fields import SMALL, tiny
from stable_baselines3.common.env_checker import check_env as check_env_of_sb3

from adr_opt.learning.environment import ID, OBSERVATIONS, UNCERTAIN_ID


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
