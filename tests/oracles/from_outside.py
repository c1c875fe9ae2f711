"""Benchmarks that others made: where their data lie, and flights by SciPy."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, J2, MU_M3_S2

BENCH = Path(__file__).parents[2] / "bench"
DATA = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", "../shared/data"))


def external(folder: str) -> list[pytest.MarkDecorator]:
    """The marks of tests that read a folder of data."""
    path = DATA / folder
    missing = f"no folder {path} (ADR_OPT_EXTERNAL_DATA)"
    return [pytest.mark.external, pytest.mark.skipif(not path.is_dir(), reason=missing)]


def pull(_, state):
    """The contest's equations of motion."""
    x, y, z = state[:3]
    r = math.sqrt(x * x + y * y + z * z)
    share, strength = 1.5 * J2 * (EARTH_RADIUS_M / r) ** 2, -MU_M3_S2 / r**3
    across, polar = 1.0 - 5.0 * (z / r) ** 2, 3.0 - 5.0 * (z / r) ** 2
    return [
        *state[3:],
        strength * x * (1.0 + share * across),
        strength * y * (1.0 + share * across),
        strength * z * (1.0 + share * polar),
    ]


def arrived(one, other, departure, arrival, times_s, impulses_m_s):
    """Miss of a debris object by a leg flown with SciPy from another one [m], [m/s]."""
    state, now = one.state(departure * DAY_S), 0.0
    ends = [*times_s, (arrival - departure) * DAY_S]
    for time, impulse in zip(ends, [*impulses_m_s, np.zeros(3)], strict=True):
        if time > now:
            flown = solve_ivp(pull, (0.0, time - now), state, "DOP853", rtol=1e-12, atol=1e-6)
            state, now = flown.y[:, -1], time
        state[3:] += impulse
    off = state - other.state(arrival * DAY_S)
    return np.linalg.norm(off[:3]), np.linalg.norm(off[3:])
