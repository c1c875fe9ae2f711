"""Orders of all chasers: the current plan, for one chaser or several."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np

from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem

from ...routes.one_chaser import left, targets_of
from .order import Bodies, ClosedOrder, flown
from .window_network import SlackWorth


class Fleet:
    """An order for each chaser, without common targets.

    Parameters
    ----------
    problem : Problem
    layers : sequence of Mission
        Of each chaser, with the connections that windows choose from.
    orders : sequence of ClosedOrder

    Attributes
    ----------
    layers : tuple of Mission
    orders : tuple of ClosedOrder
    objective : float
        What the targets of all orders are worth.
    cost : float
        What the mission minimises among plans that are worth the same.
    """

    def __init__(
        self, problem: Problem, layers: tuple[Mission, ...], orders: tuple[ClosedOrder, ...]
    ) -> None:
        self._problem = problem
        self.layers = layers
        self.orders = orders
        timings = [order.timing for order in orders]
        costs = [timing.cost for timing in timings]
        self.objective = math.fsum(timing.objective for timing in timings)
        self.cost = problem.instance.objective.together(costs)

    @classmethod
    def flying(
        cls, problem: Problem, layers: tuple[Mission, ...], routes: Collection[Bodies]
    ) -> Fleet:
        """Orders of some routes; None for a chaser whose route cannot be flown."""
        nothing = np.empty(0, np.int64)
        orders = [
            flown(layer, route) or ClosedOrder(layer, nothing)
            for layer, route in zip(layers, routes, strict=True)
        ]
        return cls(problem, layers, tuple(orders))

    @property
    def unit(self) -> float:
        """Mean worth of targets with a positive worth."""
        worths = self._problem.planning_prizes
        return float(worths[worths > 0.0].mean())

    def better_than(self, other: Fleet) -> bool:
        """Whether it collects more, or as much at less cost (docs/model.md section 5)."""
        return (self.objective, -self.cost) > (other.objective, -other.cost)

    def with_orders(self, changed: Mapping[int, ClosedOrder]) -> Fleet:
        """A copy with other orders for some chasers, by number."""
        orders = tuple(changed.get(number, order) for number, order in enumerate(self.orders))
        return Fleet(self._problem, self.layers, orders)

    def offered(self, chaser: int, anew: Collection[int] = ()) -> Mission:
        """The layer of a chaser over the targets that the others leave.

        Parameters
        ----------
        chaser : int
            Its number.
        anew : collection of int
            Others whose orders count as given up.
        """
        layer = self.layers[chaser]
        others = [
            order.moves
            for number, order in enumerate(self.orders)
            if number != chaser and number not in anew
        ]
        if not others:
            return layer
        return layer.offering(left(self._problem, targets_of(self._problem, others)))

    def worth(
        self, chasers: Collection[int], time_share: float, delta_v_share: float
    ) -> SlackWorth:
        """Worth of time and ΔV to some chasers, relative to the prizes of their orders.

        Parameters
        ----------
        chasers : collection of int
            Their numbers.
        time_share, delta_v_share : float
            Worth of the whole duration of a mission, and of its whole ΔV, relative to the prize of
            its order.
        """
        timings = [self.orders[chaser].timing for chaser in chasers]
        ends = [self.layers[chaser].rules.duration for chaser in chasers]
        count = len(timings)
        scale = max(math.fsum(timing.objective for timing in timings) / count, self.unit)
        delta_v = math.fsum(timing.delta_v for timing in timings) / count
        duration = math.fsum(ends) / count
        return SlackWorth(time_share * scale / duration, delta_v_share * scale / max(delta_v, 1.0))
