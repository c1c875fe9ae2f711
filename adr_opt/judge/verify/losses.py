"""Losses of prizes that fall with the end of the service, in exact arithmetic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...problem.instance import Instance
from .legs import Legs


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


def lost_on(legs: Legs, losses: Sequence[Loss], unit: Fraction) -> npt.NDArray[np.int64]:
    """Losses at the ends of legs, rounded down to units; empty where no prize falls."""
    if not losses:
        return np.empty(0, dtype=np.int64)
    lost = np.zeros(legs.end.size, dtype=np.int64)
    destination = legs.pair % legs.terms.bodies
    for loss in losses:
        lost[(destination == loss.body) & (legs.end > loss.after_s)] = loss.lost // unit
    return lost


def lost_by(losses: Sequence[Loss], body: int, end_s: float, unit: Fraction) -> int:
    """Loss of a body's prize by a service that ends at a time, rounded down to units."""
    lost = [loss.lost for loss in losses if loss.body == body and end_s > loss.after_s]
    return math.floor(max(lost, default=Fraction(0)) / unit)
