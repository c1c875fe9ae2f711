"""The tiny family with other prizes and limits."""

from __future__ import annotations

import adr_opt
from adr_opt.problem.instance import Instance


def varied(
    seed: int,
    *,
    prizes: tuple[float, ...] = (1.0,),
    zones: int = 0,
    days: float = 1.5,
    delta_v_m_s: float = 1000.0,
    targets: int | None = None,
) -> Instance:
    """A tiny instance with its prizes taken in turn from a list, and other limits."""
    instance = adr_opt.generate("tiny", seed, zones=zones, targets=targets)
    return instance.replace(
        targets=tuple(
            target.replace(prize=prizes[number % len(prizes)])
            for number, target in enumerate(instance.targets)
        )
    ).with_limits(duration_s=86400.0 * days, delta_v_m_s=delta_v_m_s)
