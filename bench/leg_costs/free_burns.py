"""Dual vectors of the price of free burns: found, and how near their bound comes."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog
from tables import head, row

from adr_opt.kernels.legs.free_burns import DUALS

Array = npt.NDArray[np.float64]

DIRECTIONS, PER_REVOLUTION = 24, 24
"""Directions and places at which the primer is held below 1; afterwards all is scaled to it."""


def _effects(revolutions: int, places: Array) -> tuple[Array, Array]:
    """Changes (c, d, Δe along, across) by unit impulses ahead and outward, (places, 4) each."""
    swept = (2 * revolutions + 3) * math.pi
    cosine, sine, one = np.cos(places), np.sin(places), np.ones_like(places)
    ahead = 2.0 * np.stack([one, 1.0 - 2.0 * places / swept, cosine, sine], axis=1)
    outward = np.stack([0.0 * one, 8.0 / (3.0 * swept) * one, sine, -cosine], axis=1)
    return ahead, outward


def _drawn(rng: np.random.Generator) -> Array:
    """Changes of a leg, every other time with one of them small."""
    changes = rng.standard_normal(4)
    if rng.random() < 0.5:
        changes[rng.integers(4)] *= 0.2
    return changes


def _bounds(duals: Array, changes: Array) -> Array:
    """What dual vectors and their mirror images say of changes, (changes, duals)."""
    odd = np.abs(changes[:, 1:3] @ duals[:, 1:3].T)
    trivial = 0.5 * np.maximum(np.abs(changes[:, 0]), np.hypot(changes[:, 2], changes[:, 3]))
    return np.maximum(odd + np.abs(changes[:, ::3] @ duals[:, ::3].T), trivial[:, None])


def dual_vectors(draws: int = 300) -> None:
    """Two dual vectors for each number of revolutions, of all that are optimal for drawn changes.

    The pair with the least mean square of what its bound lacks is chosen. Beside it stands how near
    the bound comes to the least sum of impulses, and how near that of the vectors in use does.
    """
    head("k", "dual vectors", "bound over least: mean", "least", "in use: mean", "least")
    turns = np.linspace(0.0, math.tau, DIRECTIONS, endpoint=False)
    for revolutions in range(len(DUALS)):
        rng, swept = np.random.default_rng(revolutions), (2 * revolutions + 3) * math.pi
        grid = np.linspace(0.0, swept, round(swept / math.tau * PER_REVOLUTION) + 1)
        ahead, outward = _effects(revolutions, grid)
        limits = np.concatenate([math.cos(x) * ahead + math.sin(x) * outward for x in turns])
        changes = np.array([_drawn(rng) for _ in range(draws)])
        found = [
            linprog(-each, limits, np.ones(len(limits)), bounds=[(None, None)] * 4, method="highs")
            for each in changes
        ]
        least = np.array([-each.fun for each in found])
        ahead, outward = _effects(revolutions, np.linspace(0.0, swept, 20001))
        duals = np.array(
            [each.x / max(1.0, np.hypot(ahead @ each.x, outward @ each.x).max()) for each in found]
        )
        shares = _bounds(duals, changes) / least[:, None]
        lacks = [
            np.mean((1.0 - np.maximum(shares, each[:, None])) ** 2, axis=0) for each in shares.T
        ]
        pair = np.unravel_index(np.argmin(lacks), (draws, draws))
        ours = shares[:, list(pair)].max(axis=1)
        used = (_bounds(DUALS[revolutions], changes) / least[:, None]).max(axis=1)
        told = "; ".join(" ".join(f"{x:.6f}" for x in duals[at]) for at in pair)
        row(revolutions, told, *(f"{x:.3f}" for of in (ours, used) for x in (of.mean(), of.min())))
