"""Many missions at once, as a vectorised environment of Gymnasium."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from ...common.constants import SLACK_M_S
from ...common.errors import InputError
from ...problem.instance import AnyInstance
from ..episodes import AnyUncertainty, Observation
from .fields import PUBLISHED, AnyFields
from .mission_env import POOL
from .plain import SpecHolder
from .vector import MissionVecEnv

OF_SB3 = ("terminal_observation", "TimeLimit.truncated", "episode")
"""What only Stable-Baselines3 reads of an episode that has ended."""


class MissionVectorEnv(SpecHolder, gymnasium.vector.VectorEnv[Observation, Any, Any]):
    """What ``gymnasium.make_vec`` makes: :class:`.MissionVecEnv` in the protocol of Gymnasium.

    An episode that ends is followed by a new one in the same step: ``info["final_obs"]`` is what
    was seen last, ``info["final_info"]`` what is told of it. ``info["action_mask"]`` has the legal
    actions of all missions, int8.

    Parameters
    ----------
    num_envs : int
        Missions at once.
    instance, fields, pool, pool_seed, observation, uncertainty
        As in :class:`.MissionEnv`; ``pool`` is at least 1.
    render_mode : None
    threads : int
        Threads that work out the pool and step the missions; nothing depends on their number.

    Raises
    ------
    InputError
        An argument is not valid, or a render mode is given.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "autoreset_mode": AutoresetMode.SAME_STEP,
        "render_modes": [],
    }

    def __init__(  # noqa: PLR0913
        self,
        num_envs: int = 1,
        instance: AnyInstance | None = None,
        *,
        fields: AnyFields = PUBLISHED,
        pool: int = POOL,
        pool_seed: int = 0,
        observation: str = "choices",
        render_mode: None = None,
        uncertainty: AnyUncertainty | Sequence[AnyUncertainty] | None = None,
        threads: int = 1,
    ) -> None:
        if render_mode is not None:
            raise InputError(
                f"render_mode = {render_mode!r}: missions that are stepped together have no "
                'pictures; make them with vectorization_mode="sync"'
            )
        self.missions = MissionVecEnv(
            num_envs,
            fields,
            instance=instance,
            observation=observation,
            slots=pool,
            threads=threads,
            seed=pool_seed,
            uncertainty=uncertainty,
        )
        self.num_envs, self.render_mode = num_envs, None
        self.single_observation_space = self.missions.observation_space
        self.single_action_space = self.missions.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin all missions anew.

        Raises
        ------
        InputError
            Options are given: make the environment with other fields instead.
        """
        if options:
            raise InputError(
                "missions that are stepped together take no options; make them with other fields"
            )
        unseeded = self._np_random is None
        super().reset(seed=seed)
        if seed is not None or unseeded:
            self.missions.draw_anew(int(self.np_random.integers(2**63)))
        return self.missions.reset(), self._info()

    def step(
        self, actions: npt.NDArray[np.integer[Any]]
    ) -> tuple[Observation, Any, Any, Any, dict[str, Any]]:
        """Make one move in each mission; those that end begin anew.

        Raises
        ------
        InputError
            Not one whole number for each mission, or no mission has begun.
        """
        self.missions.step_async(np.asarray(actions))
        _, rewards, ended, told = self.missions.step_wait()
        info = self._info()
        for index in np.flatnonzero(ended).tolist():
            said = told[index]
            final = {name: part for name, part in said.items() if name not in OF_SB3}
            final = {"final_obs": said["terminal_observation"], "final_info": final}
            info = self._add_info(info, final, index)
        return self.missions.observations(), rewards, ended, np.zeros_like(ended), info

    def _info(self) -> dict[str, Any]:
        """What :class:`.MissionEnv` tells of missions without worlds, stacked."""
        episodes = self.missions.episodes
        told = {
            "action_mask": self.missions.action_masks().astype(np.int8),
            "serviced": episodes.serviced.copy(),
            "refuelled": episodes.refuelled.copy(),
            "collected": episodes.collected.copy(),
            "time_s": episodes.time.copy(),
            "delta_v_left_m_s": np.maximum(episodes.left - SLACK_M_S, 0.0),
        }
        every = np.ones(self.num_envs, dtype=np.bool_)
        return told | {f"_{name}": every.copy() for name in told}

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads."""
        self.missions.close()
