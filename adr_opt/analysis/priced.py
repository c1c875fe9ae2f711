"""Exact timing of orders of bodies: the flyable part, the obstacle, and remedies."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..common.card import Shown
from ..common.clock import now_s
from ..common.errors import InputError
from ..common.wording import counted
from ..mission.build_legs import legs
from ..mission.certified import certify_routes
from ..mission.mission import Mission
from ..mission.problem import Problem, problem_of
from ..plan.plan import Leg, Plan
from ..problem.instance import AnyInstance, Instance
from ..problem.rules import CAMPAIGNS, FIRST, MODELLED, RELEASES, Follower
from ..problem.support import followed
from ..run.legal_moves import why_illegal
from .remedies import Remedy, Shortfall, missing, remedies

Route = Iterable[int | str]
Asked = Plan | Mapping[str, Route] | Iterable[Any]
"""A plan, a route by name of each chaser, a single route, or one for each chaser."""

NOTHING = Shortfall()

METHOD = "by-hand"
"""Method stated in plans of given orders."""


@dataclass(frozen=True, repr=False)
class PricedRoute(Shown):
    """The flyable part of a chaser's order, at least cost.

    Attributes
    ----------
    chaser : str
    order : tuple of str
        Names of the bodies.
    legs : tuple of Leg
        Of its beginning, as far as that can be flown.
    reason : str
        Why the next leg cannot be flown; empty where all can.
    missing : Shortfall
        With what more it could be flown.
    remedies : tuple of Remedy
        Single changes after which it can be flown, the best first.
    """

    chaser: str
    order: tuple[str, ...]
    legs: tuple[Leg, ...]
    reason: str = ""
    missing: Shortfall = NOTHING
    remedies: tuple[Remedy, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether the whole order can be flown."""
        return not self.reason

    def to_dict(self) -> dict[str, Any]:
        """The route as JSON data."""
        return {
            "chaser": self.chaser,
            "order": list(self.order),
            "legs": [leg.model_dump(mode="json") for leg in self.legs],
            "breaks_at_leg": None if self.holds else len(self.legs) + 1,
            "reason": self.reason or None,
            "missing": None if self.holds else self.missing.to_dict(),
            "mendings": [each.to_dict() for each in self.remedies],
        }


@dataclass(frozen=True, repr=False)
class PricedOrder(Shown):
    """Orders of all chasers of an instance, timed.

    Attributes
    ----------
    instance : Instance
    routes : tuple of PricedRoute
        Of each chaser.
    objective : float
        Sum of the prizes of what can be flown.
    lacking : tuple of str
        Required targets that no order goes to.
    unended : tuple of str
        Chasers whose orders can be flown, but end where they may not.
    runtime_s : float
    """

    instance: Instance
    routes: tuple[PricedRoute, ...]
    objective: float
    lacking: tuple[str, ...]
    unended: tuple[str, ...]
    runtime_s: float

    @property
    def holds(self) -> bool:
        """Whether the orders form a plan: all flyable, with no required target missing."""
        return all(route.holds for route in self.routes) and not (self.lacking or self.unended)

    def plan(self, problem: Problem | None = None) -> Plan:
        """The plan of the orders; without a problem, the timetable is built for it.

        Raises
        ------
        InputError
            They are none.
        """
        if not self.holds:
            raise InputError("the order cannot be flown as given; repair it first")
        problem = problem_of(self.instance) if problem is None else problem
        flown = [
            mission.numbers(route.order).tolist()
            for mission, route in zip(problem.missions, self.routes, strict=True)
        ]
        made = certify_routes(problem, METHOD, flown, seed=0, runtime_s=self.runtime_s).plan
        assert made is not None
        return made

    def to_dict(self) -> dict[str, Any]:
        """The orders as JSON data."""
        return {
            "instance": {"name": self.instance.name, "sha256": self.instance.sha256},
            "holds": self.holds,
            "objective": self.objective,
            "lacking": list(self.lacking),
            "unended": list(self.unended),
            "routes": [route.to_dict() for route in self.routes],
        }


FOLLOWS = Follower(
    "price",
    FIRST
    | CAMPAIGNS
    | MODELLED
    | RELEASES
    | {"functions of time", "capture windows", "end of life"},
)


def price(instance: AnyInstance, orders: Asked, *, mend: bool = True) -> PricedOrder:
    """Time orders of bodies by the exact scheduler, each at least cost.

    Parameters
    ----------
    instance : Instance, path or dict
    orders : Plan, mapping, or sequence
        Bodies in order, by name or number: one sequence for a single chaser; for several, a
        sequence of sequences, or a mapping from names of chasers. Of a plan, which may belong to
        another instance with these bodies, only the orders are used, not the times.
    mend : bool
        Whether to look for changes that repair an order that cannot be flown.

    Raises
    ------
    InputError
        A name is not that of a chaser or a body, two chasers go to one target, missions are kept
        apart, or the time of legs is limited.
    """
    begun = now_s()
    instance = followed(instance, FOLLOWS)
    named = _by_chaser(instance, orders)
    _check(instance, named)
    # Only the bodies of the orders: their connections are what they are among all.
    wanted = {name for order in named.values() for name in order}
    numbers = [number for number, name in enumerate(instance.names) if name in wanted]
    problem = problem_of(instance.part(numbers))
    routes, unended, prize = [], [], 0.0
    for mission in problem.missions:
        order = named.get(mission.chaser.name, ())
        route = _route(mission, order, mend)
        moves = mission.numbers(order[: len(route.legs)]).tolist()
        prize += mission.prizes(moves, [leg.free_s for leg in route.legs])
        if route.holds and not mission.may_stop(tuple(moves)):
            unended.append(mission.chaser.name)
        routes.append(route)
    done = {leg.destination for route in routes for leg in route.legs}
    lacking = tuple(
        target.name
        for target in instance.targets
        if target.required and target.name not in wanted | done
    )
    return PricedOrder(instance, tuple(routes), prize, lacking, tuple(unended), now_s() - begun)


def _by_chaser(instance: Instance, orders: Asked) -> dict[str, tuple[str, ...]]:
    """The given orders by chaser, as names."""
    if isinstance(orders, Plan):
        orders = orders.orders
        if len(instance.chasers) == 1 == len(orders):  # an only chaser, whatever it was called
            orders = {instance.chasers[0].name: next(iter(orders.values()))}
    if not isinstance(orders, Mapping):
        chasers, routes = [chaser.name for chaser in instance.chasers], list(orders)
        single = [isinstance(route, (int, np.integer, str)) for route in routes]
        if len(chasers) == 1 and all(single):
            routes, single = [routes], []
        if len(routes) > len(chasers) or any(single):
            raise InputError(
                "orders: must be a sequence of bodies for each of "
                f"{counted(len(chasers), 'chaser')}"
            )
        orders = dict(zip(chasers, routes, strict=False))
    names, found = instance.names, {}
    for chaser, order in orders.items():
        for body in order:
            if not isinstance(body, str) and not 0 <= body < len(names):
                raise InputError(
                    f"{body!r} is not a body of {instance.name!r}, which are 0 to {len(names) - 1}"
                )
        found[chaser] = tuple(body if isinstance(body, str) else names[body] for body in order)
    return found


def _check(instance: Instance, orders: Mapping[str, tuple[str, ...]]) -> None:
    chasers, bodies = {chaser.name for chaser in instance.chasers}, set(instance.names)
    whose: dict[str, str] = {}
    for chaser, order in orders.items():
        if chaser not in chasers:
            raise InputError(f"{chaser!r} is not a chaser of {instance.name!r}")
        for name in order:
            if name not in bodies:
                raise InputError(f"{name!r} is not a body of {instance.name!r}")
            if name not in instance.station_names and whose.setdefault(name, chaser) != chaser:
                raise InputError(f"{name!r} is visited by {whose[name]!r} and by {chaser!r}")


def _route(mission: Mission, order: tuple[str, ...], mend: bool) -> PricedRoute:
    moves = tuple(mission.numbers(order).tolist())
    made = mission.time_by_class(moves).made
    flown = legs(mission, moves[:made])
    name = mission.chaser.name
    if made == len(moves):
        return PricedRoute(name, order, flown)
    reason = why_illegal(mission, list(moves), made)
    if not mend:
        return PricedRoute(name, order, flown, reason)
    lacks = missing(mission, moves, made)
    return PricedRoute(name, order, flown, reason, lacks, remedies(mission, moves))
