"""Multipliers of a Lagrangian bound, by a proximal level bundle method.

The bound L(π) is convex in π, and every evaluation gives a plane below it,
L(π) ≥ L_k + g_k (π − π_k) with g_k = 1 − (visits of each target by the best walk). The next
multipliers are those nearest to the best ones for which all planes lie below a level under the
best bound. If there are none, the level was too ambitious, and the planes prove it; if the bound
comes down well, the next level is lower still (Lemaréchal, Nemirovskii & Nesterov 1995).
Subgradient steps with Polyak's rule need several times as many evaluations here: walks repeat a
few cheap targets, and slopes swing wildly.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.memory import write

PASSES = 500
"""Maximum number of projection rounds. Stopping early only slows progress: every bound is valid."""

MOST_PLANES = 150
ROUND_AND_ROUND = 1.5
"""Ratio of the best walk to all prizes above which multipliers as large as these are a better start
than none."""

FIRST_AMBITION = 0.02
LEAST_AMBITION = 2e-5


@kernel
def nearest_below(slopes, offsets, weights, centre, tolerance, radius, point):
    """Point nearest to the centre with slopes·x ≤ offsets and x ≥ 0, by Hildreth's method.

    Parameters
    ----------
    slopes : (planes, n) float64
    offsets : (planes,) float64
    weights : (planes,) float64
        Dual weights to start from, at least 0; updated.
    centre : (n,) float64
    tolerance : float
        Of slopes·x ≤ offsets.
    radius : float
        Give up when the point must be farther away than this.
    point : (n,) float64
        Written.

    Returns
    -------
    found : bool
        False if the dual proves that there is no point within the radius, or if none came out.
    """
    planes, n = slopes.shape
    floor_weights = np.zeros(n)
    write(point, centre)
    for k in range(planes):
        for j in range(n):
            point[j] -= weights[k] * slopes[k, j]
    for _ in range(PASSES):
        worst = 0.0
        for k in range(planes):
            excess, square = -offsets[k], 0.0
            for j in range(n):
                excess += slopes[k, j] * point[j]
                square += slopes[k, j] * slopes[k, j]
            worst = max(worst, excess)
            step = max(excess / square, -weights[k])
            if step != 0.0:
                weights[k] += step
                for j in range(n):
                    point[j] -= step * slopes[k, j]
        for j in range(n):
            step = max(-point[j], -floor_weights[j])
            floor_weights[j] += step
            point[j] += step
        dual = 0.0
        for j in range(n):
            dual += 0.5 * (point[j] - centre[j]) ** 2 - floor_weights[j] * point[j]
        for k in range(planes):
            excess = -offsets[k]
            for j in range(n):
                excess += slopes[k, j] * point[j]
            dual += weights[k] * excess
        if dual > 0.5 * radius * radius:
            return False
        if worst <= tolerance:
            return True
    return False


class Convex(Protocol):
    """A bound that is convex in its multipliers, with the interface of :class:`WalkBound`."""

    prize: np.ndarray

    @property
    def dimensions(self) -> int:
        """Number of multipliers."""
        ...

    @property
    def total(self) -> float:
        """The sum of all prizes."""
        ...

    @property
    def radius(self) -> float:
        """Search radius around the best multipliers."""
        ...

    def first_point(self) -> np.ndarray:
        """Initial multipliers."""
        ...

    def allowed(self, point: np.ndarray) -> np.ndarray:
        """Nearest multipliers at which the bound can be evaluated."""
        ...

    def at(self, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Bound near a point, with its exact multipliers and its subgradient."""
        ...


class Descent:
    """Lowers the bound of a mission, one evaluation at a time.

    Parameters
    ----------
    bound : Convex

    Attributes
    ----------
    value : float
        Best bound so far; +inf before the first step.
    multipliers : (bodies,) float64
        Where it holds.
    done : bool
        No step will bring it down by more than the least ambition.
    evaluations : int
    """

    def __init__(self, bound: Convex) -> None:
        self._bound = bound
        self.value = np.inf
        self.multipliers = bound.first_point()
        self.done = False
        self.evaluations = 0
        self._ambition = 0.0
        self._slopes: list[np.ndarray] = []
        self._intercepts: list[float] = []
        self._weights = np.zeros(0)
        self._last = np.empty(0)

    def step(self) -> float:
        """Evaluate the bound once; returns its value there."""
        bound = self._bound
        point = self.multipliers if self.evaluations == 0 else self._next_point()
        if self.done:
            return self.value
        value, rounded, slope = bound.at(point)
        self.evaluations += 1
        if value == -np.inf:
            self.value, self.done = value, True  # there is nothing to bound
            return value
        if self.evaluations == 1:
            self._ambition = FIRST_AMBITION * abs(value)
            if value > ROUND_AND_ROUND * bound.total:
                self._ambition = FIRST_AMBITION * bound.total
                self.value, self.multipliers = bound.total, bound.allowed(bound.prize.copy())
        if value < self.value:
            if value < self.value - 0.7 * self._ambition and self.evaluations > 1:
                self._ambition *= 1.3
            self.value, self.multipliers = value, rounded
        if not slope.any():
            self.done = True  # every target once: the least of the bound
            return value
        if np.array_equal(rounded, self._last):
            # Weights may be such that all planes are met below 0 alone: then they lead nowhere.
            self._weights[:], self._ambition = 0.0, 0.5 * self._ambition
            return value
        self._last = rounded
        self._slopes.append(slope)
        self._intercepts.append(value - float(slope @ rounded))
        self._weights = np.append(self._weights, 0.0)
        if len(self._slopes) > MOST_PLANES:
            idle = int(np.argmin(self._weights[:-20]))
            del self._slopes[idle], self._intercepts[idle]
            self._weights = np.delete(self._weights, idle)
        return value

    def _next_point(self) -> np.ndarray:
        bound = self._bound
        slopes, intercepts = np.array(self._slopes), np.array(self._intercepts)
        point = np.empty(bound.dimensions)
        while self._ambition > LEAST_AMBITION * abs(self.value):
            weights = self._weights.copy()
            offsets = self.value - self._ambition - intercepts
            tolerance = 0.1 * self._ambition
            if nearest_below(
                slopes, offsets, weights, self.multipliers, tolerance, bound.radius, point
            ):
                self._weights = weights
                return bound.allowed(point)
            self._ambition *= 0.5
        self.done = True
        return self.multipliers
