"""Fields of orbits about the Moon, drawn like those of the contest."""

from __future__ import annotations

import numpy as np

from .reading import Problem

HIGH_M, LOW_M = 15_000e3, 3_750e3
"""Semi-major axes of both shells [m]."""

LOW_SHARE = 0.19
"""Of the orbits, those in the low shell; they lie in three planes."""

FAN_SHARE = 0.75
"""Of those in the high shell, the ones whose planes are spread evenly; the others lie in three."""

SPREAD = 2e-3
"""Of the semi-major axes, relative, to either side."""

PLANES_RAD = 0.0, 0.5 * np.pi, np.pi
"""Inclinations about which the others lie [rad]."""

TILT_RAD = 0.03
"""How far from them, to either side [rad]."""


def drawn(targets: int, seed: int) -> Problem:
    """A field of so many orbits, with the rules of the contest.

    As in the contest's small instance there are two shells, a fan of planes from inclination 0 to
    π and clusters at 0, π/2 and π; nodes and eccentricities are below 0.01.
    """
    rng = np.random.default_rng(seed)
    low = round(LOW_SHARE * targets)
    fan = round(FAN_SHARE * (targets - low))
    axis = np.where(np.arange(targets) < low, LOW_M, HIGH_M)
    axis = axis * (1.0 + rng.uniform(-SPREAD, SPREAD, targets))
    tilt = rng.choice(PLANES_RAD, targets) + rng.uniform(-TILT_RAD, TILT_RAD, targets)
    tilt[low : low + fan] = (np.arange(fan) + 0.5) * np.pi / max(fan, 1)
    small = rng.uniform(0.0, 0.01, (2, targets))
    turns = rng.uniform(0.0, 2.0 * np.pi, (2, targets))
    elements = np.column_stack([axis, small[0], tilt, small[1], *turns])
    longest_d = 4.0 * targets
    return Problem(
        f"drawn-{targets}-{seed}", 0.0, 0.001, longest_d, 100.0, 600.0, 5,
        elements[rng.permutation(targets)],
    )  # fmt: skip
