"""Low thrust of a leg as a time history: a piecewise linear force in each window.

The law of steering is one of the place on the orbit, which no other program knows. As vectors in
inertial axes at points of time anyone can fly it, without asking where the chaser is. Points are
such that force and piecewise linear force have the same integrals against all functions that are
linear between points. Interpolated vectors themselves would be chords of arcs, and too short by a
part in ten thousand: a hundred kilometres after a drift of three months.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import solveh_banded

from ...fly.refine.bodies import Gravity, state_of
from ...fly.refine.thrust_record import thrust_states
from ...fly.trajectory.sampling import SHORTEST_ARC_S
from ...kernels.orbits.short_periods import Array
from ...plan.refined_plan import RefinedLeg
from .course import ThrustWindow

STEP_S = 30.0
"""Time between points: docs/exports.md states the resulting accuracy [s]."""

SHORTEST_S = 1.0
"""Shortest interval at the end of a window; a shorter one is merged with the previous one [s]."""

PLACES, WEIGHTS = np.polynomial.legendre.leggauss(3)
PLACES, WEIGHTS = 0.5 * (PLACES + 1.0), 0.5 * WEIGHTS


def thrust_windows(leg: RefinedLeg, gravity: Gravity) -> tuple[ThrustWindow, ...]:
    """Windows of a leg with their forces, those of less than a millisecond left out.

    Parameters
    ----------
    leg : RefinedLeg
    gravity : {"two-body", "j2", "j3", "j4"}
    """
    if leg.thrust is None:
        return ()
    flow = leg.thrust.force_n / leg.thrust.exhaust_m_s
    grids, laws = [], []
    for arc in leg.thrust.arcs:
        for start, end in arc.windows_s:
            if end - start >= SHORTEST_ARC_S:
                count = max(1, math.ceil((end - start - SHORTEST_S) / STEP_S))
                grids.append(np.append(start + STEP_S * np.arange(count), end))
                laws.append(np.array(arc.steering))
    if not grids:
        return ()
    times = np.concatenate([_within(grid) for grid in grids])
    departure = leg.states[0]
    states = thrust_states(leg.thrust, state_of(departure), departure.time_s, times, gravity)
    of_grid = iter(np.split(states, _ends(grids)))
    found, mass = [], leg.thrust.mass_kg
    for grid, law in zip(grids, laws, strict=True):
        forces = leg.thrust.force_n * _directions(next(of_grid), law)
        found.append(ThrustWindow(grid, _fitted(grid, forces), mass, flow))
        mass = found[-1].after_kg
    return tuple(found)


def _ends(grids: list[Array]) -> Array:
    """Indices in all times at which each grid but the last ends."""
    return np.cumsum([PLACES.size * (grid.size - 1) for grid in grids])[:-1]


def _within(grid: Array) -> Array:
    """Points of Gauss's rule between those of a grid."""
    points: Array = (grid[:-1, None] + np.diff(grid)[:, None] * PLACES).ravel()
    return points


def _directions(states: Array, law: Array) -> Array:
    """Unit vectors of thrust in states, by the law of docs/model.md section 11.6."""
    outward = states[:, :3] / np.linalg.norm(states[:, :3], axis=1)[:, None]
    momentum = np.cross(states[:, :3], states[:, 3:])
    momentum /= np.linalg.norm(momentum, axis=1)[:, None]
    ahead = np.cross(momentum, outward)
    # The third component of both is that of the pole: sine and cosine of the latitude times the
    # sine of the inclination.
    latitude = np.arctan2(outward[:, 2], ahead[:, 2])
    sine, cosine = np.sin(latitude)[:, None], np.cos(latitude)[:, None]
    a, b, c, d, e = law
    found = (
        (a * sine - b * cosine) * outward
        + (c + 2.0 * (a * cosine + b * sine)) * ahead
        + (d * cosine + e * sine) * momentum
    )
    unit: Array = found / np.linalg.norm(found, axis=1)[:, None]
    return unit


def _fitted(grid: Array, forces: Array) -> Array:
    """Values at the points of a grid, of the piecewise linear force of least squares.

    ``forces`` are those at the points of Gauss's rule.
    """
    steps = np.diff(grid)
    forces = steps[:, None, None] * forces.reshape(grid.size - 1, PLACES.size, 3)
    right = np.zeros((grid.size, 3))
    right[:-1] += np.einsum("k,k,ikx->ix", WEIGHTS, 1.0 - PLACES, forces)
    right[1:] += np.einsum("k,k,ikx->ix", WEIGHTS, PLACES, forces)
    # Integrals of products of the functions that are 1 at one point and 0 at the others.
    bands = np.zeros((2, grid.size))
    bands[0, 1:] = steps / 6.0
    bands[1, :-1] += steps / 3.0
    bands[1, 1:] += steps / 3.0
    found: Array = solveh_banded(bands, right)
    return found
