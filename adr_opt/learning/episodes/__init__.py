"""Many missions at once: stacked fields, states, observations.

What the environment (:mod:`adr_opt.learning.environment`) and the learned planner stand on; needs
NumPy and Numba alone.
"""

from .board import OBSERVATIONS, Board, Observation, allowed, check_observation, published_size
from .pool import (
    FOLLOWS,
    FieldPool,
    check_playable,
    in_mean_prizes,
    new_episodes,
    playing_time_s,
    start,
)
from .worlds import (
    LOSS_WORDS,
    AnyUncertainty,
    UncertainPool,
    begin_in_worlds,
    models_of,
    new_worlds,
    practise,
)

__all__ = [
    "FOLLOWS",
    "LOSS_WORDS",
    "OBSERVATIONS",
    "AnyUncertainty",
    "Board",
    "FieldPool",
    "Observation",
    "UncertainPool",
    "allowed",
    "begin_in_worlds",
    "check_observation",
    "check_playable",
    "in_mean_prizes",
    "models_of",
    "new_episodes",
    "new_worlds",
    "playing_time_s",
    "practise",
    "published_size",
    "start",
]
