"""The mission as a reinforcement-learning environment (extra ``[rl]``).

Importing this package registers ``adr_opt/Mission-v0`` and ``adr_opt/UncertainMission-v0`` with
Gymnasium. :class:`MissionEnv` is one mission; :class:`MissionVecEnv` hundreds of them in Numba, for
Stable-Baselines3, and what ``gymnasium.make_vec`` makes is the same for Gymnasium. With
``uncertainty`` all play in the worlds of rehearsals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ...common.errors import MissingExtra

try:
    import gymnasium
except ImportError:
    raise MissingExtra("the environment", "gymnasium", "rl") from None

from ..episodes.board import OBSERVATIONS
from ..episodes.worlds import TROUBLED, TROUBLES
from .fields import PUBLISHED, VARIED, Fields, Limits
from .mission_env import MissionEnv
from .plain import in_json
from .spaces import space
from .variants import RANDOMISED, REDUCED_FUEL, REDUCED_TIME

if TYPE_CHECKING:
    from .vector import MissionVecEnv

__all__ = [
    "ID",
    "OBSERVATIONS",
    "PUBLISHED",
    "RANDOMISED",
    "REDUCED_FUEL",
    "REDUCED_TIME",
    "TROUBLED",
    "TROUBLES",
    "UNCERTAIN_ID",
    "VARIED",
    "Fields",
    "Limits",
    "MissionEnv",
    "MissionVecEnv",
    "space",
]

ID = "adr_opt/Mission-v0"

UNCERTAIN_ID = "adr_opt/UncertainMission-v0"

_ENTRY_POINT = "adr_opt.learning.environment.mission_env:MissionEnv"

_VECTOR_ENTRY_POINT = "adr_opt.learning.environment.native:MissionVectorEnv"

gymnasium.register(id=ID, entry_point=_ENTRY_POINT, vector_entry_point=_VECTOR_ENTRY_POINT)
gymnasium.register(
    id=UNCERTAIN_ID,
    entry_point=_ENTRY_POINT,
    vector_entry_point=_VECTOR_ENTRY_POINT,
    kwargs={"uncertainty": in_json(TROUBLED)},
)


def __getattr__(name: str) -> Any:
    """:class:`MissionVecEnv` needs Stable-Baselines3 and PyTorch, the rest does not."""
    if name == "MissionVecEnv":
        try:
            from .vector import MissionVecEnv
        except ImportError:
            raise MissingExtra("MissionVecEnv", "stable-baselines3", "rl") from None
        return MissionVecEnv
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
