"""The world of the one episode that :class:`.mission_env.MissionEnv` plays."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...common.errors import InputError
from ...kernels.episodes import worlds as kernels
from ...kernels.episodes.episodes import Episodes
from ...problem.uncertainty import Uncertainty
from ...problem.world import OUTCOMES
from ..episodes import UncertainPool, begin_in_worlds, new_worlds
from .drawn import PlayedFields

LAST_WORLD = 2**31 - 1
"""Worlds are drawn from those below."""

ALONE = np.zeros(1, dtype=np.int32)
"""The only episode."""


class PlayedWorld:
    """The uncertain world that one episode is played in.

    Parameters
    ----------
    played : PlayedFields
        The fields that it is played on.
    models : sequence of Uncertainty

    Attributes
    ----------
    played : PlayedFields
    losses : dict of str to str
        Targets that were lost so far, and the station where the way to it was too dear, each with
        the reason.
    """

    def __init__(self, played: PlayedFields, models: Sequence[Uncertainty]) -> None:
        self.played, self._models, self._slot = played, models, 0
        self._pool: UncertainPool | None = None
        self._states = new_worlds(self._uncertain, 1).states
        self.losses: dict[str, str] = {}

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_pool": None}

    @property
    def _uncertain(self) -> UncertainPool:
        """What is uncertain about the fields, which all copies share."""
        if self._pool is None:
            self._pool = self.played.uncertain(self._models)
            self._pool.install(self._slot)
        return self._pool

    @property
    def worlds(self) -> kernels.Worlds:
        """The world as kernels take it."""
        return kernels.Worlds(self._uncertain.tables, self._states)

    @property
    def seed(self) -> int:
        """Number of the world."""
        return int(self._states.seed[0])

    @property
    def uncertainty(self) -> Uncertainty:
        """The model that the world is drawn from."""
        return self._models[int(self._states.model[0])]

    def begin(self, episodes: Episodes, rng: np.random.Generator, seed: int | None) -> None:
        """Begin the episode, in a world that is given or drawn."""
        self._slot = int(episodes.slot[0])
        self._uncertain.install(self._slot)
        model = rng.integers(len(self._models), size=1)
        seeds = rng.integers(LAST_WORLD, size=1) if seed is None else np.array([seed])
        begin_in_worlds(self.played.pool, episodes, self.worlds, ALONE, (seeds, model))
        self.losses = {}

    def act(
        self,
        episodes: Episodes,
        actions: np.ndarray[Any, np.dtype[np.int64]],
        rewards: np.ndarray[Any, np.dtype[np.float32]],
    ) -> None:
        """Take an action, and note what was lost."""
        fields = self.played.pool
        kernels.act_in_worlds(fields.arrays, episodes, self.worlds, 0, 1, actions, rewards, ALONE)
        outcome = int(self._states.outcome[0])
        if outcome >= kernels.FAILED:
            field = fields.instances[int(episodes.slot[0])]
            assert field is not None
            self.losses[field.names[int(episodes.body[0])]] = OUTCOMES[outcome]

    def info(self) -> dict[str, Any]:
        """What the environment tells of the world."""
        outcome = int(self._states.outcome[0])
        return {
            "world": self.seed,
            "outcome": "" if outcome == kernels.ILLEGAL else OUTCOMES[outcome],
            "tries": int(self._states.tries[0]),
            "losses": dict(self.losses),
        }


def world_number(given: Any) -> int:
    """The number of a world that was asked for.

    Raises
    ------
    InputError
        It is not a whole number, or negative or too large.
    """
    try:
        seed = operator.index(given)
    except TypeError:
        seed = -1
    if not 0 <= seed < 2**63:
        raise InputError(f"world = {given!r}: must be a whole number from 0 on, below 2⁶³")
    return seed
