"""The tiny family with other prizes and limits."""

from __future__ import annotations

import numpy as np

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


def variant(seed: int) -> Instance:
    """4–7 targets with zones, zero, whole and fractional prizes, and any length and budget."""
    rng = np.random.default_rng(1000 + seed)
    targets = int(rng.integers(4, 8))
    instance = adr_opt.generate("tiny", 100 + seed, targets=targets, zones=int(rng.integers(0, 4)))
    prizes = rng.uniform(0.0, 4.0, targets).round(2 if seed % 2 else 0)
    return instance.replace(
        targets=tuple(
            target.replace(prize=float(prize))
            for target, prize in zip(instance.targets, prizes, strict=True)
        )
    ).with_limits(
        duration_s=86400.0 * float(rng.uniform(0.6, 2.0)),
        delta_v_m_s=float(rng.uniform(300.0, 2500.0)),
    )
