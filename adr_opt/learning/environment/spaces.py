"""The spaces of the observations."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces

from ...kernels.episodes import choices as kernels
from ..episodes.board import MISSION, MOVES, check_observation, published_size


def space(name: str, targets: int) -> spaces.Space[Any]:
    """The space of an observation for a number of targets.

    ``published``
        Box of shape (7·targets + 8,): visited (targets,), ΔV left / budget, time left / duration,
        six elements of the chaser, six of each target (see
        :data:`adr_opt.kernels.episodes.published.PUBLISHED_ELEMENTS`).
    ``choices``
        Dict of ``moves``, shape (targets + 1, 36), one row for each action (see
        :data:`adr_opt.kernels.episodes.choices.CHOICE_FIELDS`), and ``mission``, shape (15,) (see
        :data:`adr_opt.kernels.episodes.choices.MISSION_FIELDS`).

    All numbers are float32 in [−5, 5].
    """
    check_observation(name)

    def box(*shape: int) -> spaces.Box:
        return spaces.Box(-kernels.LIMIT, kernels.LIMIT, shape, np.float32)

    if name == "published":
        return box(published_size(targets))
    return spaces.Dict(
        {
            MISSION: box(len(kernels.MISSION_FIELDS)),
            MOVES: box(targets + 1, len(kernels.CHOICE_FIELDS)),
        }
    )
