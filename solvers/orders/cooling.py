"""Cooling schedule for simulated annealing of orders (Kirkpatrick, Gelatt and Vecchi 1983)."""

from __future__ import annotations

from typing import NamedTuple

from adr_opt.kernels.core.compile import inlined


class AnnealingSchedule(NamedTuple):
    """Objective weights of an order, and temperatures.

    Attributes
    ----------
    worth : float
        Worth of a second [prizes per s].
    hot, cold : float
        Temperatures at the beginning and at the end [prizes].
    iterations : int
    """

    worth: float
    hot: float
    cold: float
    iterations: int


@inlined
def temperature(schedule, iteration):
    """Temperature of an iteration, falling geometrically [prizes]."""
    hot, cold = schedule.hot, schedule.cold
    return hot * (cold / hot) ** (iteration / schedule.iterations)
