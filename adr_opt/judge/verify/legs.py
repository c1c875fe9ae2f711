"""The legs that one chaser may fly, and losses of prizes at their ends, as plain arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...common.errors import InputError
from ...legs.connection_finder import ConnectionFinder
from ...problem.chasers import Chaser
from ...problem.instance import Instance
from .terms import Terms, flown_from, terms_of

FloatArray = npt.NDArray[np.float64]

MOST = 2**58
"""Largest loss of prize at one service [units]."""


class Loss(NamedTuple):
    """Loss of a prize by a service that ends after a time; a tow belongs to the service.

    Attributes
    ----------
    body : int
    after_s : float
        [s].
    lost : Fraction
        Of the greatest prize.
    """

    body: int
    after_s: float
    lost: Fraction


def losses_of(instance: Instance) -> tuple[Loss, ...]:
    """All losses of prizes that fall, those of a target in order of time."""
    found = []
    for body, target in enumerate(instance.targets, start=instance.first_target):
        levels = target.prize_until or ()
        prizes = [*(Fraction(prize) for _, prize in levels), Fraction(target.prize)]
        for (until_s, _), then in zip(levels, prizes[1:], strict=True):
            found.append(Loss(body, until_s + SLACK_S, prizes[0] - then))
    return tuple(found)


def lost_by(
    losses: Sequence[Loss], body: npt.NDArray[np.int64], end_s: FloatArray, unit: Fraction
) -> npt.NDArray[np.int64]:
    """Losses of bodies' prizes by services that end at times, rounded down to units."""
    lost = np.zeros(body.size, dtype=np.int64)
    for loss in losses:
        lost[(body == loss.body) & (end_s > loss.after_s)] = min(loss.lost // unit, MOST)
    return lost


LEAST_S = 1e-4
"""Least duration of a leg, far above the slack: walks are processed in order of time [s]."""


class Legs(NamedTuple):
    """Legs by pair of bodies, sorted by end of the stay, then by ΔV.

    Attributes
    ----------
    terms : Terms
        What they keep to.
    first : (bodies² + 1,) int64
        First leg of each pair, number origin · bodies + destination.
    pair : (legs,) int64
    departure, end, delta_v : (legs,) float64
        [s], end of service, or of the tow that follows it [s], [m/s].
    cheapest : (legs,) float64
        Least ΔV of the leg and those of its pair that end later [m/s].
    quickest : (bodies²,) float64
        Least time from departure to the end of the stay, of each pair [s].
    shortest : float
        Of all [s].
    """

    terms: Terms
    first: npt.NDArray[np.int64]
    pair: npt.NDArray[np.int64]
    departure: FloatArray
    end: FloatArray
    delta_v: FloatArray
    cheapest: FloatArray
    quickest: FloatArray
    shortest: float


def legs_of(instance: Instance, chaser: Chaser, connecting: ConnectionFinder) -> Legs:
    """Legs of a chaser that end in time and are affordable."""
    terms = terms_of(instance, chaser, connecting)
    bodies = terms.bodies
    columns: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    sizes = np.zeros(bodies * bodies + 1, dtype=np.int64)
    for i in range(bodies):
        for j, departure, end, delta_v in flown_from(i, terms, connecting):
            order = np.lexsort((delta_v, end))
            columns.append((departure[order], end[order], delta_v[order]))
            sizes[i * bodies + j + 1] = order.size
    departure, end, delta_v = (
        np.concatenate([np.empty(0), *parts]) for parts in zip(*columns, strict=True)
    )
    first = np.cumsum(sizes)
    cheapest, quickest = delta_v.copy(), np.full(bodies * bodies, math.inf)
    for number, (low, high) in enumerate(pairwise(first)):
        quickest[number] = np.min(end[low:high] - departure[low:high], initial=math.inf)
        cheapest[low:high] = np.minimum.accumulate(cheapest[low:high][::-1])[::-1]
    pair = np.repeat(np.arange(bodies * bodies), np.diff(first))
    shortest = float(quickest.min())
    if shortest < LEAST_S:
        raise InputError(f"cannot be verified yet: the shortest leg takes only {shortest:g} s")
    return Legs(terms, first, pair, departure, end, delta_v, cheapest, quickest, shortest)
