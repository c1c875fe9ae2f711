"""Delays of the ends of services: their means, and their quantiles."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ...problem.uncertainty import Delay, Uncertainty
from .mission_facts import MissionFacts

FloatArray = npt.NDArray[np.float64]

ROUNDING = 1e-9
"""Difference of chances below which they count as equal."""


def mean_delays_s(facts: MissionFacts, uncertainty: Uncertainty) -> FloatArray:
    """Mean delays of the ends of services, all tries included.

    Parameters
    ----------
    facts : MissionFacts
    uncertainty : Uncertainty

    Returns
    -------
    (bodies,) float64
        0 of bodies that are no targets [s].
    """

    def of(name: str, planned: FloatArray) -> FloatArray:
        model, took = uncertainty.service_of(name), planned
        if model.factor is not None:
            took = took * model.factor.moments[0]
        if model.added is not None:
            took = took + _mean_s(model.added)
        failing = 1.0 - uncertainty.success_of(name)
        tries = sum(failing**number for number in range(uncertainty.tries_of(name)))
        return (1.0 - uncertainty.gone_of(name)) * tries * took - planned

    return _of_each(facts, uncertainty, of)


def largest_delays_s(facts: MissionFacts, uncertainty: Uncertainty, share: float) -> FloatArray:
    """Quantiles of the delays of the ends of services.

    Parameters
    ----------
    facts : MissionFacts
    uncertainty : Uncertainty
    share : float

    Returns
    -------
    (bodies,) float64
        0 of bodies that are no targets [s].
    """

    def of(name: str, planned: FloatArray) -> FloatArray:
        model, took = uncertainty.service_of(name), planned
        if model.factor is not None:
            took = took * model.factor.at(share)
        if model.added is not None:
            # Delays are there below their chance, and grow up to it.
            below = model.added.chance - (1.0 - share)
            took = took + (model.added.at(below) if below > ROUNDING else 0.0)
        tries = _tries_until(share, uncertainty.success_of(name), uncertainty.tries_of(name))
        return np.maximum(tries * took - planned, 0.0)

    return _of_each(facts, uncertainty, of)


def _of_each(
    facts: MissionFacts, uncertainty: Uncertainty, delays: Callable[[str, FloatArray], FloatArray]
) -> FloatArray:
    """Delays of all targets, computed once for those without distributions of their own."""
    planned = _planned_s(facts)
    usual = np.arange(planned.size) >= facts.first_target
    found = np.zeros(planned.size)
    for name in uncertainty.targets.keys() & facts.number.keys():
        target = facts.number[name]
        usual[target] = False
        found[target] = delays(name, planned[[target]])[0]
    if usual.any():
        found[usual] = delays(facts.names[int(np.argmax(usual))], planned[usual])
    return found


def _planned_s(facts: MissionFacts) -> FloatArray:
    """Planned times of services, without tows, shape (bodies,) [s]."""
    planned = facts.chasers[0].limits.service.copy()
    for target, tow_s in facts.tow_s.items():
        planned[target] -= tow_s
    return planned


def _mean_s(delay: Delay) -> float:
    """Mean of a delay, the chance of none included [s]."""
    if delay.most_s is None or delay.mean_s == 0.0:
        return delay.chance * delay.mean_s
    return -delay.chance * delay.mean_s * math.expm1(-delay.most_s / delay.mean_s)


def _tries_until(chance: float, success: float, most: int) -> int:
    """Number of tries within which one succeeds with a given chance."""
    for tries in range(1, most):
        if 1.0 - (1.0 - success) ** tries >= chance:
            return tries
    return most
