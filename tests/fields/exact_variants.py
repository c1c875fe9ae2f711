"""The tiny family with zones, other prizes and other limits."""

from __future__ import annotations

import numpy as np

import adr_opt
from adr_opt.problem.instance import Instance


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
