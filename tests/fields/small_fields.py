"""Fields for environments in tests, computed in milliseconds."""

from __future__ import annotations

import adr_opt
from adr_opt.learning.environment import Fields, Limits
from adr_opt.problem.instance import Instance

HOUR_S = 3600.0
SMALL = Fields(
    "tiny",
    targets=(3, 9),
    share_of_family=0.3,
    zones=(0, 3),
    delta_v_m_s=(300.0, 1500.0),
    duration_s=(15 * HOUR_S, 40 * HOUR_S),
    limits=(Limits(2000.0, 50 * HOUR_S),),
    share_of_limits=0.2,
)
"""Fields whose timetables are computed in milliseconds, of many sizes, budgets and durations."""


def tiny(seed: int = 0, **limits: float) -> Instance:
    instance = adr_opt.generate("tiny", seed)
    return instance.with_limits(**limits)
