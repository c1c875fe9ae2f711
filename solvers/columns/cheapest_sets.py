"""Final phase of cost proofs: sets of targets by lower bounds on their cost.

Walks tell of every set of targets that a cheaper plan could be made of, and what it costs a chaser
at least; set packing finds the cheapest sets that are worth enough together. What a set costs at
the very least is found for those alone that it takes: the cheapest route over all orders
(:mod:`.cheapest_routes`), and for each number of refuellings where these are limited; limits of
propellant are not looked at. Then it is asked again, until it takes only sets whose cost is known,
or sets that are no cheaper together than the plan known.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import LinearConstraint

from adr_opt.common.stop import Stop
from adr_opt.mission.problem import Problem

from ..progress.cost_rounds import RELATIVE
from ..progress.gap import GapTracker
from ..routes.route_pool import RoutePool, dealt
from ..routes.set_packing import cheapest_of, packing
from .cheapest_routes import cheapest_routes

NEAR = 1e-7
"""Relative tolerance at which a route attains the lower bound of its set."""

SCALE = 1e3
"""Scaled cost of the known plan in the packing model."""

Set = tuple[int, frozenset[int], tuple[int, ...]]
"""Chaser type, targets, and refuellings at limited stations once known."""


class CheapestSets:
    """Determines the least cost of plans made of listed sets.

    Parameters
    ----------
    problem : Problem
    certificate : GapTracker
        Told of cheaper plans.
    pool : RoutePool
        Of routes; added to.
    least_worth : float
        What a plan has to be worth.
    stop : Stop
    """

    def __init__(
        self,
        problem: Problem,
        certificate: GapTracker,
        pool: RoutePool,
        least_worth: float,
        stop: Stop,
    ) -> None:
        self._problem, self._certificate, self._pool = problem, certificate, pool
        self._least_worth, self._stop = least_worth, stop
        self._least: dict[Set, float] = {}
        self._route: dict[Set, tuple[int, ...]] = {}
        self._known: set[Set] = set()
        self._counted = frozenset(
            number
            for number, station in enumerate(problem.instance.stations)
            if station.max_refuellings is not None
        )

    @property
    def size(self) -> int:
        """Number of listed sets."""
        return len(self._least)

    def note(self, kind: int, route: tuple[int, ...], worth: float, value: float) -> None:
        """List the set of targets of a route.

        Parameters
        ----------
        kind : int
        route : tuple of int
        worth : float
            What its targets are worth together, less all that they pay at second rows.
        value : float
            What no route of these targets is worth more than, less what it costs.
        """
        first = self._problem.instance.first_target
        key = kind, frozenset(j for j in route if j >= first), ()
        least = max(worth - value, 0.0)
        if least < self._least.get(key, math.inf):
            self._least[key], self._route[key] = least, route

    def settle(self) -> float:
        """Lower bound on the cost of plans of these sets; +inf if there is none.

        Plans are offered that are cheaper than the one known.
        """
        bound = 0.0
        if not self._counted:
            for key in self._least:
                self._look(key)
        while self._least:
            taken, bound, finished = self._cheapest(bound)
            if taken is None:
                return math.inf if finished else bound
            self._offer(taken)
            unknown = [key for key in taken if key not in self._known]
            enough = bound >= self._certificate.cost * (1.0 - 0.1 * RELATIVE)
            if not unknown or enough or not finished:
                return bound
            for key in unknown:
                if not self._find(key):
                    return bound
        return math.inf

    def _look(self, key: Set) -> None:
        """Whether a route attains the lower bound of its set."""
        mission = self._problem.kinds[key[0]].mission
        moves = mission.closed(self._route[key])
        schedule = mission.time(moves)
        if schedule.made == len(moves) and schedule.cost <= self._least[key] * (1.0 + NEAR) + NEAR:
            self._known.add(key)
            self._least[key] = min(self._least[key], schedule.cost)

    def _find(self, key: Set) -> bool:
        """Replace the lower bound of a set by its exact cost; False if time runs out."""
        kind, targets, _ = key
        over = self._stop.remaining_s() <= 0.0
        mission = self._problem.kinds[kind].mission
        found = (
            None
            if over
            else cheapest_routes(
                mission, targets, lambda: self._stop.remaining_s() <= 0.0, self._counted
            )
        )
        if found is None:
            return False
        # A set without a route cannot be serviced.
        del self._least[key], self._route[key]
        for route, cost, stops in found:
            own = kind, targets, stops
            self._least[own], self._route[own] = cost, route
            self._known.add(own)
            self._pool.add(kind, route)
        return True

    def _cheapest(self, before: float) -> tuple[list[Set] | None, float, bool]:
        """Cheapest sets with sufficient worth, their cost, and whether it is proven."""
        sets = list(self._least)
        costs = np.array([self._least[key] for key in sets])
        worths = np.array([self._problem.collected(targets) for _, targets, _ in sets])
        scale = 1.0 / max(self._least_worth, 1e-300)
        # What is dearer than the plan known is in none that is cheaper; and what HiGHS may be off
        # by is little in such units.
        known = self._certificate.cost
        unit = SCALE / max(known, 1e-300)
        found = cheapest_of(
            unit * np.minimum(costs, 2.0 * known),
            [
                packing(
                    self._problem,
                    [(kind, targets) for kind, targets, _ in sets],
                    [self._problem.limits.refuellings(stops) for *_, stops in sets],
                    all_flown=True,
                ),
                LinearConstraint(scale * worths[None, :], scale * self._least_worth, np.inf),
            ],
            self._stop.remaining_s(),
            gap=1e-9,
        )
        if found.taken is None:
            return None, before, found.solved
        taken = [sets[at] for at in found.taken]
        if not found.solved:
            return taken, before, False
        return taken, max(before, found.least / unit * (1.0 - 0.1 * RELATIVE)), True

    def _offer(self, taken: list[Set]) -> None:
        """Offer the routes of some sets as a plan."""
        routes = [(key[0], self._route[key]) for key in taken]
        for kind, route in routes:
            self._pool.add(kind, route)
        self._certificate.offer(*dealt(self._problem, routes))
