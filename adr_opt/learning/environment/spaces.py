"""The spaces of the observations."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces

from ...kernels.episodes import observation as kernels
from ..episodes.board import MISSION, MOVES, check_observation, move_fields, published_size


def space(name: str, targets: int) -> spaces.Space[Any]:
    """The space of an observation for a number of targets.

    ``published``
        Box of shape (7·targets + 8,): visited (targets,), ΔV left / budget, time left / duration,
        six elements of the chaser, six of each target (see
        :data:`adr_opt.kernels.episodes.published.PUBLISHED_ELEMENTS`).
    ``transfer``
        Dict of ``moves``, shape (targets + 1, 29), one row for each action (see
        :data:`adr_opt.kernels.episodes.observation.MOVE_FIELDS`), and ``mission``, shape (16,) (see
        :data:`adr_opt.kernels.episodes.observation.MISSION_FIELDS`).

    ``lookahead``
        As ``transfer``, with rows of 51 numbers: those of ``transfer`` and then
        :data:`adr_opt.kernels.episodes.lookahead.CHAIN_FIELDS`.
    ``transfer-prizes``, ``lookahead-prizes``
        As these, with one number more in each row, after the first 29: the prize in mean prizes of
        the field. Chains count prizes then, not targets.
    ``transfer-worlds``
        As ``transfer-prizes``, with rows of 39 numbers: the last are
        :data:`adr_opt.kernels.episodes.world_view.WORLD_FIELDS`.

    All numbers are float32 in [−5, 5].
    """
    check_observation(name)

    def box(*shape: int) -> spaces.Box:
        return spaces.Box(-kernels.LIMIT, kernels.LIMIT, shape, np.float32)

    if name == "published":
        return box(published_size(targets))
    return spaces.Dict(
        {MISSION: box(len(kernels.MISSION_FIELDS)), MOVES: box(targets + 1, len(move_fields(name)))}
    )
