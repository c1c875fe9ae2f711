"""Impulses of least total size: the bound, the equations, and as few as need be."""

from __future__ import annotations

import numpy as np
import pytest

from adr_opt.fly.refine.least import fewest, least_impulses

MOTION = 1e-3
"""Mean motion of a circular orbit [rad/s]."""


def effects(times: int, span_s: float) -> np.ndarray:
    """What impulses do to relative motion at the end (Clohessy–Wiltshire), shape (times, 6, 3)."""
    found = np.empty((times, 6, 3))
    for at, left in enumerate(span_s - np.linspace(0.0, span_s, times)):
        s, c, n = np.sin(MOTION * left), np.cos(MOTION * left), MOTION
        found[at] = [
            [s / n, 2 * (1 - c) / n, 0],
            [2 * (c - 1) / n, (4 * s - 3 * n * left) / n, 0],
            [0, 0, s / n],
            [c, 2 * s, 0],
            [-2 * s, 4 * c - 3, 0],
            [0, 0, c],
        ]
    return found


def sizes(impulses: np.ndarray) -> np.ndarray:
    return np.sqrt(np.sum(impulses**2, axis=1))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("times", "span_s"), [(7, 6e3), (60, 6e3), (200, 1e5)])
def test_the_least_is_between_bound_and_total(seed: int, times: int, span_s: float) -> None:
    """The equations are met, the total is that of the impulses, and the dual bound is near."""
    change = np.random.default_rng(seed).normal(size=6) * [1e4, 1e5, 1e4, 10.0, 10.0, 10.0]
    matrices = effects(times, span_s)
    least = least_impulses(matrices, change)
    assert np.allclose(np.einsum("kij,kj->i", matrices, least.impulses), change, rtol=1e-7)
    assert sizes(least.impulses).sum() == pytest.approx(least.total)
    assert least.bound <= least.total <= 1.002 * least.bound


@pytest.mark.parametrize("seed", range(4))
def test_nobody_else_finds_less(seed: int) -> None:
    """A general optimiser, begun at random impulses that meet the equations, ends no lower."""
    optimize = pytest.importorskip("scipy.optimize")
    rng = np.random.default_rng(seed)
    change = rng.normal(size=6) * [1e3, 1e3, 1e3, 1.0, 1.0, 1.0]
    matrices = effects(5, 5e3)
    rows = matrices.transpose(1, 0, 2).reshape(6, 15)
    scale = np.abs(rows).max(axis=1)
    found = optimize.minimize(
        lambda u: np.sqrt(np.sum(u.reshape(5, 3) ** 2, axis=1) + 1e-12).sum(),
        np.linalg.lstsq(rows / scale[:, None], change / scale, rcond=None)[0],
        constraints={"type": "eq", "fun": lambda u: (rows @ u - change) / scale},
        method="SLSQP",
        options={"maxiter": 500},
    )
    assert least_impulses(matrices, change, 1e-5).total <= found.fun * (1.0 + 1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_six_impulses_are_enough(seed: int) -> None:
    """Any impulses become at most six of the same effect and of no greater total."""
    rng = np.random.default_rng(seed)
    matrices, impulses = effects(50, 2e4), rng.normal(size=(50, 3))
    few = fewest(matrices, impulses)
    assert np.count_nonzero(sizes(few)) <= 6
    assert sizes(few).sum() <= sizes(impulses).sum() * (1.0 + 1e-12)
    wanted = np.einsum("kij,kj->i", matrices, impulses)
    reached = np.einsum("kij,kj->i", matrices, few)
    assert np.allclose(reached, wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())
