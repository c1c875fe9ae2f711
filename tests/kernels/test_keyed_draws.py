"""Draws by key: uniform, independent of each other, and the same wherever they are drawn."""

from __future__ import annotations

import itertools

import numpy as np
from scipy.stats import kstest

from adr_opt.kernels.orbits.keyed_draws import beginnings, joined, keyed_draws, mixed

SOME = np.arange(20_000)


def test_draws_are_uniform_and_independent() -> None:
    """Draws of neighbouring seeds, years and kinds are uniform, and no two go together."""
    drawn = {
        keys: keyed_draws(*keys, SOME) for keys in itertools.product((0, 1), (0, 1, 7), (1, 2))
    }
    for keys, values in drawn.items():
        assert kstest(values, "uniform").pvalue > 1e-4, keys
        assert abs(np.corrcoef(values[1:], values[:-1])[0, 1]) < 0.03, keys
    for one, other in itertools.combinations(drawn, 2):
        assert abs(np.corrcoef(drawn[one], drawn[other])[0, 1]) < 0.03, (one, other)


def test_small_chances_occur_as_often_as_they_should() -> None:
    """The smallest draws, which decide on rare events, are as small as they should be."""
    values = np.concatenate([keyed_draws(seed, 3, 1, SOME) for seed in range(100)])
    for chance in (1e-2, 1e-3, 1e-4, 1e-5):
        found, of = (values < chance).sum(), chance * len(values)
        assert abs(found - of) < 4.0 * np.sqrt(of), chance
    assert len(np.unique(values)) == len(values)


def test_a_draw_depends_on_its_key_alone() -> None:
    """A draw among others is that of its object alone, hashed step by step."""
    some = np.array([5, 3, 99_999])
    drawn = keyed_draws(4, 5, 6, some)
    assert keyed_draws(4, 5, 6, some[::-1].copy()).tolist() == drawn[::-1].tolist()
    high, low = beginnings(4, 5, 6)
    assert joined(mixed(high, 3), mixed(low, 3)) == drawn[1]
