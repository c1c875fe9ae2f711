"""When to fly an order of bodies: the schedule of least cost, exactly (MODEL section 4)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .connections import Connecting, Connections
from .kernels import schedule as kernels
from .kernels.rules import Rules

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

PAIRS_KEPT = 2_000
"""Pairs whose connections are kept: some 50 kB each in a mission of a week."""


@dataclass(frozen=True)
class Schedule:
    """What happens when an order of bodies is visited as far as the rules allow, at least cost.

    Attributes
    ----------
    made : int
        Number of moves that can be made; less than the length of the order if it cannot be flown.
    objective : float
        Sum of the prizes of the moves made.
    delta_v : float
        Total ΔV of the moves made [m/s].
    cost : float
        What the mission minimises among plans of the same prizes: that ΔV [m/s], or the end of
        the last leg's service [s].
    departures, arrivals, ends : (made,) float64
        Of each leg, and the end of the service that follows it [s].
    delta_vs, lefts : (made,) float64
        ΔV of each leg, and what is left after its service, as the rules count it: with the slack
        that a tank may be overdrawn by [m/s].
    revolutions : (made,) int64
        Phasing revolutions of each leg.
    """

    made: int
    objective: float
    delta_v: float
    cost: float
    departures: FloatArray
    arrivals: FloatArray
    ends: FloatArray
    delta_vs: FloatArray
    lefts: FloatArray
    revolutions: IntArray


class Front(NamedTuple):
    """All ways worth having to be at the last body of an order: labels, none dominates another.

    Attributes
    ----------
    ready, left, cost : (labels,) float64
        Since when the chaser is free there [s], ascending; ΔV left [m/s]; ΔV of all legs [m/s].
    parent, taken : (labels,) int64
        Label at the body before, and the connection taken from there.
    """

    ready: FloatArray
    left: FloatArray
    cost: FloatArray
    parent: IntArray
    taken: IntArray


class Scheduler:
    """Schedules orders of one mission; what two orders begin with in common is worked out once.

    Parameters
    ----------
    connecting : Connecting
        Of the instance.
    rules : callable
        Gives the rules of the mission, once they are needed.
    cost : {"delta-v", "duration"}
        What the best schedule of an order has least of.
    """

    def __init__(self, connecting: Connecting, rules: Callable[[], Rules], cost: str) -> None:
        self._rules = rules
        self._by_time = cost == "duration"

        def of_pair(i: int, j: int) -> Connections:
            return connecting.of_pair(i, j, connecting.planning_resolution_m_s)

        def least(i: int, j: int) -> float:
            return float(self.connections(i, j).delta_v.min(initial=math.inf))

        self.connections = lru_cache(PAIRS_KEPT)(of_pair)
        self._least = lru_cache(None)(least)
        # The order of the last call, the kits at its start, and its fronts. One object, so that
        # threads may share it.
        self._last: tuple[tuple[int, ...], int, tuple[Front, ...]] = ((), 0, ())

    def under(self, rules: Rules) -> Scheduler:
        """The same under other rules; what is known of connections is shared."""
        made = copy(self)
        made._rules = lambda: rules
        made._last = ((), 0, ())
        return made

    def kits_for(self, order: tuple[int, ...]) -> int:
        """How many kits the services of an order take: so many are taken along."""
        loads = self._rules().loads
        return 0 if loads is None else int(loads.takes[list(order)].sum())

    def ways(self, order: tuple[int, ...]) -> Iterator[tuple[int, Front]]:
        """The labels after an order, for every number of kits that may be left then."""
        loads = self._rules().loads
        taken = self.kits_for(order)
        for kits in range(taken, taken + 1 if loads is None else loads.full.size):
            fronts = self.fronts(order, kits)
            if len(fronts) > len(order):
                yield kits - taken, fronts[-1]

    def fronts(self, order: tuple[int, ...], kits: int | None = None) -> tuple[Front, ...]:
        """The labels at the start and after each move, as far as the order can be flown.

        Parameters
        ----------
        order : tuple of int
            Bodies; its moves keep to the rules of the order.
        kits : int, optional
            That are taken along; as many as are needed by default.
        """
        rules = self._rules()
        loads = rules.loads
        if kits is None:
            kits = self.kits_for(order)
            if loads is not None:
                kits = min(kits, loads.full.size - 1)
        before, with_kits, known = self._last
        common = 0
        while common < min(len(order), len(known) - 1) and order[common] == before[common]:
            common += 1
        fronts = list(known[: common + 1]) if kits == with_kits else []
        if not fronts:
            common = 0
            nothing = np.zeros(1, dtype=np.int64)
            ready = np.array([rules.ready])
            full = rules.budget if loads is None else float(loads.full[kits])
            fronts.append(Front(ready, np.array([full]), np.zeros(1), nothing, nothing))
        aboard = kits - self.kits_for(order[:common])
        for at in range(common, len(order)):
            i = order[at - 1] if at else rules.start
            j = order[at]
            found = self.connections(i, j)
            refill = -1.0
            if rules.is_station[j]:
                refill = rules.budget if loads is None else float(loads.full[aboard])
            here = fronts[-1]
            front = Front(
                *kernels.follow(
                    here.ready, here.left, here.cost,
                    (found.departure, found.arrival, found.delta_v),
                    rules.service[j], rules.opens[j], rules.closes[j], refill, loads, j, aboard,
                )
            )  # fmt: skip
            if not front.ready.size:
                break
            aboard -= self.kits_for((j,))
            fronts.append(front)
        self._last = order, kits, tuple(fronts)
        return self._last[2]

    def least_cost(self, order: tuple[int, ...]) -> float:
        """No schedule of an order costs less: each leg at its least ΔV [m/s]; or 0 s."""
        if self._by_time:
            return 0.0
        rules = self._rules()
        way = (rules.start, *order)
        return math.fsum(self._least(i, j) for i, j in pairwise(way))

    def of(self, order: tuple[int, ...]) -> Schedule:
        """The schedule of least cost: the earliest end of least ΔV, or the other way round."""
        fronts = self.fronts(order)
        rules = self._rules()
        made = len(fronts) - 1
        last = fronts[-1]
        keys = (last.cost, last.ready) if self._by_time else (last.ready, last.cost)
        label = int(np.lexsort(keys)[0])
        delta_v = float(last.cost[label])
        cost = delta_v
        if self._by_time:
            cost = float(last.ready[label]) if made else 0.0
        departures, arrivals, ends, delta_vs, lefts = np.empty((5, made))
        revolutions = np.empty(made, dtype=np.int64)
        for at in range(made - 1, -1, -1):
            front = fronts[at + 1]
            found = self.connections(order[at - 1] if at else rules.start, order[at])
            taken = front.taken[label]
            departures[at], arrivals[at] = found.departure[taken], found.arrival[taken]
            delta_vs[at], revolutions[at] = found.delta_v[taken], found.revolutions[taken]
            ends[at], lefts[at] = front.ready[label], front.left[label]
            label = front.parent[label]
        objective = math.fsum(rules.prize[j] for j in order[:made])
        return Schedule(
            made,
            objective,
            delta_v,
            cost,
            departures,
            arrivals,
            ends,
            delta_vs,
            lefts,
            revolutions,
        )
