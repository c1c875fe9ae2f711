"""Optimistic connections for functions of time: bounds for any number of targets and chasers.

Of each body some ready times are *points*. One connection stands for all who are ready between a
point and the next: it leaves just before the latter, and arrives as if it had left at the former.
As nobody overtakes, each route of the functions is one of the connections that ends no later, and
what is proven of these holds of the functions. Where their best plan is none in truth, the times at
which it reaches its bodies become points, and it is gone: dynamic discretisation discovery (Boland,
Hewitt, Marshall and Savelsbergh, Operations Research 65(5), 2017; Vu, Hewitt, Boland and
Savelsbergh, Transportation Science 54(3), 2020, for tours with windows). Its possible plans are
routes at their true times, those of the route engine among them.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import SLACK_S
from adr_opt.kernels.core.windows import service_ends
from adr_opt.kernels.legs.given import legs_of
from adr_opt.legs.service_limits import limits_of
from adr_opt.mission.problem import Problem
from adr_opt.plan.plan import Plan
from adr_opt.problem.given import COLUMNS, of_rows
from adr_opt.problem.given_functions import LEAST_S, Function
from adr_opt.problem.instance import Instance

FloatArray = npt.NDArray[np.float64]

ROUNDED_S = SLACK_S / 16.0
"""Margin by which connections leave before the next point, beyond the slack within which a late
chaser still takes them; takers of the next ones count as ready twice that before it [s]."""

POINTS, FIRST_ROWS, MOST_ROWS = 400, 1_000_000, 4_000_000
"""Initial number of points over the duration, largest number of connections of all pairs then, and
later."""

SHARE = 0.5
"""Spacing of points as a share of a leg's duration, if initially longer than the leg."""


class OptimisticLegs:
    """Optimistic connections in place of the functions of an instance.

    Parameters
    ----------
    problem : Problem
        With functions of time.

    Attributes
    ----------
    points : dict of int to array
        Ready times at each body with functions, ascending [s].
    """

    def __init__(self, problem: Problem) -> None:
        instance = self._instance = problem.instance
        given = instance.given
        assert given is not None
        assert given.functions is not None
        self._limits = limits_of(instance)
        number = {name: body for body, name in enumerate(instance.names)}
        self._functions: dict[tuple[int, int], Function] = {}
        for origin, destination in given.functions.pairs:
            function = given.functions.of_pair(origin, destination)
            assert function is not None
            self._functions[number[origin], number[destination]] = function
        self._ready = [mission.rules.ready for mission in problem.missions]
        listed = {number[given.names[at]] for at in np.unique(given.destination)}
        entered = listed | {j for _, j in self._functions}
        spans = {i: self._span(i) for i, _ in self._functions if i in entered}
        rows = sum(spans[i][1] - spans[i][0] for i, _ in self._functions if i in spans)
        step = max(self._limits.duration / POINTS, rows / FIRST_ROWS)
        self.points = {
            i: np.unique([*self._ready, *np.arange(*spans.get(i, (0.0, 0.0)), step)])
            for i, _ in self._functions
        }

    def _span(self, body: int) -> tuple[float, float]:
        """First and last ready time at a body from which a leg leaves [s]."""
        windows, service = self._limits.windows, float(self._limits.service[body])
        last = max(
            float(each.departure[-1]) for (i, _), each in self._functions.items() if i == body
        )
        begin = max(float(windows.opening[body]) + service, 0.0)
        end = min(float(windows.closing[body]) + service, last)
        return (begin, end) if begin < end else (0.0, 0.0)

    def instance(self) -> Instance | None:
        """The instance on connections; None if there would be too many."""
        given, names = self._instance.given, self._instance.names
        assert given is not None
        number = np.array([names.index(name) for name in given.names], dtype=np.int64)
        parts = [(number[given.origin], number[given.destination], given.departure, given.arrival)]
        costs, rows = [given.cost], given.cost.size
        for (i, j), function in self._functions.items():
            made = self._connections(i, j, function, MOST_ROWS - rows)
            if made is None:
                return None
            size = made[0].size
            parts.append((np.full(size, i), np.full(size, j), *made))
            costs.append(np.full(size, function.cost))
            rows += size
        columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
        table = dict(zip(COLUMNS, [*columns, np.concatenate(costs)], strict=True))
        return self._instance.with_given(of_rows(table, names))

    def _connections(
        self, i: int, j: int, function: Function, most: int
    ) -> tuple[FloatArray, FloatArray] | None:
        """Departures and arrivals of a pair; None if there would be more than a maximum."""
        points, last = self.points[i], float(function.departure[-1])
        while True:
            _, lands = legs_of(function.departure, function.arrival, points - 2.0 * ROUNDED_S)
            leaves = np.append(points[1:] - SLACK_S - ROUNDED_S, last).clip(0.0, last)
            there = np.isfinite(lands)
            if int(there.sum()) > most:
                return None
            short = np.flatnonzero(there & (lands - leaves < LEAST_S))
            if not short.size:
                break
            half = points[short] + SHARE * (lands[short] - points[short] - LEAST_S)
            finer = np.union1d(points, half)
            if finer.size == points.size:
                return None
            points = finer
        leaves, lands = leaves[there], lands[there]
        # Of those whose services end together, as where a window opens later, the last stands for
        # all; what arrives too late is no connection.
        over = service_ends(self._limits.windows, j, lands, self._limits.service[j])
        kept = np.isfinite(over)
        kept[:-1] &= over[:-1] < over[1:]
        return leaves[kept], lands[kept]

    def refine(self, plan: Plan) -> bool:
        """Add a plan's arrival times at bodies as points; returns whether any is new."""
        number = {name: body for body, name in enumerate(self._instance.names)}
        windows, services, new = self._limits.windows, self._limits.service, False
        for chaser, route in enumerate(plan.routes):
            now = self._ready[chaser]
            for leg in route.legs:
                i, j = number[leg.origin], number[leg.destination]
                function, lands = self._functions.get((i, j)), np.array([leg.arrival_s])
                if function is not None:
                    finer = np.union1d(self.points[i], [now])
                    new = new or finer.size > self.points[i].size
                    self.points[i] = finer
                    _, lands = legs_of(
                        function.departure, function.arrival, np.array([now - 2.0 * ROUNDED_S])
                    )
                (now,) = service_ends(windows, j, lands, services[j]).tolist()
                if not math.isfinite(now):
                    break
        return new
