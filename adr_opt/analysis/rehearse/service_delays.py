"""By how much later than planned services end: on average, and at most in a share of cases."""

from __future__ import annotations

import math

from ...problem.uncertainty import Delay, Uncertainty
from .ground import Ground

ROUNDING = 1e-9
"""Difference of chances that counts as none."""


def mean_delay_s(ground: Ground, target: int, uncertainty: Uncertainty) -> float:
    """By how much later than planned a service ends on average, all tries counted [s].

    Parameters
    ----------
    ground : Ground
    target : int
        Number of its body.
    uncertainty : Uncertainty
    """
    name, planned = ground.names[target], _planned_s(ground, target)
    model, took = uncertainty.service_of(name), planned
    if model.factor is not None:
        took *= model.factor.moments[0]
    if model.added is not None:
        took += _mean_s(model.added)
    failing = 1.0 - uncertainty.success_of(name)
    tries = sum(failing**number for number in range(uncertainty.tries_of(name)))
    return (1.0 - uncertainty.gone_of(name)) * tries * took - planned


def largest_delay_s(ground: Ground, target: int, uncertainty: Uncertainty, share: float) -> float:
    """By how much later than planned a service ends at most in a share of cases [s].

    Parameters
    ----------
    ground : Ground
    target : int
        Number of its body.
    uncertainty : Uncertainty
    share : float
    """
    name, planned = ground.names[target], _planned_s(ground, target)
    model, took = uncertainty.service_of(name), planned
    if model.factor is not None:
        took *= model.factor.at(share)
    if model.added is not None:
        # Delays are there below their chance, and grow up to it.
        below = model.added.chance - (1.0 - share)
        took += model.added.at(below) if below > ROUNDING else 0.0
    tries = _tries_until(share, uncertainty.success_of(name), uncertainty.tries_of(name))
    return max(tries * took - planned, 0.0)


def _planned_s(ground: Ground, target: int) -> float:
    return float(ground.chasers[0].limits.service[target]) - ground.tow_s.get(target, 0.0)


def _mean_s(delay: Delay) -> float:
    """Mean of a delay, that there may be none counted [s]."""
    if delay.most_s is None or delay.mean_s == 0.0:
        return delay.chance * delay.mean_s
    return -delay.chance * delay.mean_s * math.expm1(-delay.most_s / delay.mean_s)


def _tries_until(chance: float, success: float, most: int) -> int:
    """Number of tries after which one has succeeded by a chance."""
    for tries in range(1, most):
        if 1.0 - (1.0 - success) ** tries >= chance:
            return tries
    return most
