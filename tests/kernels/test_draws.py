"""Draws of worlds by kernels: the numbers that the standard library gives."""

from __future__ import annotations

import hashlib
import math
from statistics import NormalDist

import numpy as np
import pytest

from adr_opt.kernels.core import draws
from adr_opt.problem.world import uniform

MASK = (1 << 64) - 1


def mixed(state: int) -> int:
    """One finaliser of splitmix64, in whole numbers of any size."""
    state = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    state = ((state ^ (state >> 27)) * 0x94D049BB133111EB) & MASK
    return state ^ (state >> 31)


@pytest.mark.parametrize("seed", [0, 7, 2**31 - 1, 2**63 + 5, 2**70 + 3])
def test_uniform_numbers_are_those_of_whole_arithmetic(seed: int) -> None:
    """A number by seed and names is that of splitmix64 and BLAKE2 in Python's own integers."""
    for count in range(200):
        text = f"sleg\x00sdebris\x00i{count}".encode()
        key = int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "little")
        state = (key + mixed((seed * 0x9E3779B97F4A7C15 + 1) & MASK)) & MASK
        wanted = ((mixed(state) >> 12) + 0.5) * 2.0**-52
        assert uniform(seed, "leg", "debris", count) == wanted


def test_quantiles_are_those_of_the_standard_library() -> None:
    """Normal quantiles agree with those of Python in the middle, on the shoulders and in tails."""
    rng = np.random.default_rng(0)
    small = 10.0 ** -rng.uniform(0.0, 300.0, 500)
    for p in (*rng.random(3000), *small, *(1.0 - 1e-10 * rng.random(500))):
        wanted = NormalDist().inv_cdf(float(p))
        assert draws.normal_quantile(p) == pytest.approx(wanted, rel=2e-15, abs=1e-300)


def test_delays_are_exponential_up_to_a_maximum() -> None:
    """Delays of equidistant numbers have the chance, mean and maximum that are asked for."""
    numbers = (np.arange(20_000) + 0.5) / 20_000
    found = np.array([draws.delay_at(each, 0.4, 100.0, 300.0) for each in numbers])
    assert (found > 0.0).mean() == pytest.approx(0.4, abs=1e-4)
    assert found.max() == 300.0
    assert found.mean() == pytest.approx(-40.0 * math.expm1(-3.0), rel=1e-3)
