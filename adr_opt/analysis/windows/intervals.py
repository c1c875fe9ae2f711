"""Intervals of time: where a function is positive, and intersections of lists.

A list of intervals is an array of shape (intervals, 2), of beginnings and ends [s], ascending and
without overlaps.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

PRECISION_S = 1e-3
"""Precision of the edges of intervals [s]."""


def positive(
    function: Callable[[Array], Array], begin_s: float, end_s: float, step_s: float
) -> Array:
    """Intervals in which a smooth function of time is positive.

    Extremes between samples are looked for, so that no interval is missed for being shorter than a
    step, as long as the function has no two extremes within one.

    Parameters
    ----------
    function : callable
        Of times, shape (n,) [s]; its values have the same shape.
    begin_s, end_s : float
        The span that is looked at.
    step_s : float
        Longest distance of samples.

    Returns
    -------
    (intervals, 2) float64
    """
    samples = max(math.ceil((end_s - begin_s) / step_s), 2) + 1
    times = np.linspace(begin_s, end_s, samples)
    values = function(times)
    for sign in (1.0, -1.0):  # humps below zero, then dips above it
        heights = np.concatenate([[-math.inf], sign * values[:samples], [-math.inf]])
        here = heights[1:-1]
        at = np.flatnonzero((here >= heights[:-2]) & (here >= heights[2:]) & (here < 0.0))
        low, high = times[np.maximum(at - 1, 0)], times[np.minimum(at + 1, samples - 1)]
        found = _peaks(function, sign, low, high)
        times = np.append(times, found)
        values = np.append(values, function(found))
    order = np.argsort(times, kind="stable")
    times, is_open = times[order], values[order] > 0.0
    at = np.flatnonzero(is_open[1:] != is_open[:-1])
    edges = _crossings(function, times[at], times[at + 1], is_open[at])
    ends = [
        np.array([begin_s] if is_open[0] else []),
        edges,
        np.array([end_s] if is_open[-1] else []),
    ]
    return np.concatenate(ends).reshape(-1, 2)


def _peaks(function: Callable[[Array], Array], sign: float, low: Array, high: Array) -> Array:
    """Times of maxima, or of minima with sign −1, in brackets."""
    while low.size and float((high - low).max()) > PRECISION_S:
        third = (high - low) / 3.0
        left = sign * function(low + third) > sign * function(high - third)
        low, high = np.where(left, low, low + third), np.where(left, high - third, high)
    return 0.5 * (low + high)


def _crossings(
    function: Callable[[Array], Array], low: Array, high: Array, was_open: npt.NDArray[np.bool_]
) -> Array:
    """Times of sign changes in brackets."""
    while low.size and float((high - low).max()) > PRECISION_S:
        middle = 0.5 * (low + high)
        same = (function(middle) > 0.0) == was_open
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)


def common(one: Array, other: Array) -> Array:
    """Intersection of two lists of intervals."""
    first = np.searchsorted(other[:, 1], one[:, 0], side="right")
    after = np.searchsorted(other[:, 0], one[:, 1], side="left")
    counts = np.maximum(after - first, 0)
    rows = np.repeat(np.arange(len(one)), counts)
    places = np.arange(rows.size) - np.repeat(np.cumsum(counts) - counts, counts) + first[rows]
    begins = np.maximum(one[rows, 0], other[places, 0])
    return np.column_stack([begins, np.minimum(one[rows, 1], other[places, 1])])


def shrunk(intervals: Array, margin_s: float) -> Array:
    """Intervals shortened at both ends; those that vanish are dropped."""
    kept = intervals[:, 1] - intervals[:, 0] > 2.0 * margin_s
    left: Array = intervals[kept] + np.array([margin_s, -margin_s])
    return left


def lasting(intervals: Array, least_s: float) -> Array:
    """The intervals of at least some duration."""
    kept: Array = intervals[intervals[:, 1] - intervals[:, 0] >= least_s]
    return kept
