"""Impulses of least total size for a linear change: a second-order cone problem.

    minimise Σ |u_k|   subject to   Σ M_k u_k = d

over vectors u_k of three components, with six equations: D. Lawden's primer vector (Optimal
Trajectories for Space Navigation, 1963) for linear motion. Its dual is: maximise y·d subject to
|M_kᵀ y| ≤ 1; M_kᵀ y is the primer, and impulses stand only where it has length one, so that six
impulses are enough.

Solved by iteratively reweighted least squares (I. Gorodnitsky and B. Rao, IEEE Transactions on
Signal Processing 45, 1997): the least Σ |u_k|²/w_k with w_k the sizes of the round before. Each
round meets the equations exactly, costs one 6 × 6 system, and gives a bound from the dual.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...kernels.orbits.short_periods import Array

MOST_ROUNDS = 2000

LEAST_SHARE = 1e-12
"""Lower limit of weights as a share of the largest impulse, so that no weight is zero."""


class Least(NamedTuple):
    """Impulses, their total size, and a lower bound on it."""

    impulses: Array  # (times, 3) [m/s]
    total: float
    bound: float


def least_impulses(effects: Array, change: Array, tolerance: float = 1e-3) -> Least:
    """Impulses of least total size.

    Parameters
    ----------
    effects : (times, equations, 3) float64
        M_k: what an impulse at each time changes.
    change : (equations,) float64
        d.
    tolerance : float
        Relative gap to the dual bound at which it is enough.
    """
    count, equations, _ = effects.shape
    rows = effects.transpose(1, 0, 2).reshape(equations, 3 * count)
    # Equations in units of their own: metres and radians in one system lose digits.
    scale = 1.0 / np.sqrt(np.sum(rows * rows, axis=1))
    rows, wanted = rows * scale[:, None], change * scale
    products = (rows.reshape(equations, count, 3).transpose(1, 0, 2)).copy()
    squares = (products @ products.transpose(0, 2, 1)).reshape(count, equations * equations)
    weights = np.ones(count)
    best = Least(np.zeros((count, 3)), np.inf, 0.0)
    bound = 0.0
    for _ in range(MOST_ROUNDS):
        system = (weights @ squares).reshape(equations, equations)
        try:
            dual = np.linalg.solve(system, wanted)
        except np.linalg.LinAlgError:
            break
        primer = (dual @ rows).reshape(count, 3)
        lengths = np.sqrt(np.sum(primer * primer, axis=1))
        bound = max(bound, float(dual @ wanted) / max(float(lengths.max()), 1e-300))
        sizes = weights * lengths
        total = float(sizes.sum())
        if not np.isfinite(total):
            break
        if total < best.total:
            best = Least(primer * weights[:, None], total, bound)
        if best.total - bound <= tolerance * best.total:
            break
        weights = np.maximum(sizes, LEAST_SHARE * sizes.max())
    return Least(best.impulses, best.total, bound)


def fewest(effects: Array, impulses: Array) -> Array:
    """Impulses with the same effect and no greater total size, at most one per equation.

    Along their directions the sizes solve a linear program, of which a basic solution has as many
    impulses as there are equations. One after the other is emptied into the others.

    Parameters
    ----------
    effects : (times, equations, 3) float64
    impulses : (times, 3) float64

    Returns
    -------
    (times, 3) float64
        Most of them zero.
    """
    sizes = np.sqrt(np.sum(impulses * impulses, axis=1))
    directions = impulses / np.maximum(sizes, 1e-300)[:, None]
    columns = np.einsum("kij,kj->ik", effects, directions)
    columns = columns / np.sqrt(np.sum(columns * columns, axis=1))[:, None]
    equations = columns.shape[0]
    # Small ones first: most of them are what the iteration has not yet driven to zero.
    left = [int(at) for at in np.argsort(sizes) if sizes[at] > 0.0]
    while len(left) > equations:
        some = left[: equations + 1]
        free = np.linalg.svd(columns[:, some])[2][-1]
        if free.sum() > 0.0:
            free = -free
        shrinking = free < 0.0
        if not shrinking.any():
            break
        reach = np.where(shrinking, sizes[some] / np.where(shrinking, -free, 1.0), np.inf)
        which = int(np.argmin(reach))
        sizes[some] = np.maximum(sizes[some] + reach[which] * free, 0.0)
        sizes[some[which]] = 0.0
        left = [at for at in left if sizes[at] > 0.0]
    found: Array = sizes[:, None] * directions
    return found
