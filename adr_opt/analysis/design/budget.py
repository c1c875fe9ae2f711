"""Plans cut down to a budget: the last targets of routes, or whole launches, are left out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ...plan.plan import Plan
from ...plan.routes import routes_of
from ...problem.instance import Instance
from .prices import CampaignPrices, Legs
from .rating import Rating


@dataclass(frozen=True)
class _Cut:
    """A shorter route of one chaser, with what that saves and loses."""

    chaser: str
    legs: Legs
    saved: float
    lost: float


def cut_to_budget(
    instance: Instance, plan: Plan, prices: CampaignPrices, rating: Rating, budget: float
) -> dict[str, tuple[str, ...]] | None:
    """Orders of a plan without what is beyond a budget; None if nothing is left of them.

    The cut that loses the least for each euro is made first, or else the one that loses the least;
    the better outcome of both counts. The beginning of a route can be flown
    as before, so that only the ends of routes are cut, and whole routes.

    Parameters
    ----------
    instance : Instance
        With the prices applied.
    plan : Plan
    prices : CampaignPrices
    rating : Rating
    budget : float
        [euros].

    Returns
    -------
    dict of str to tuple of str, or None
        Bodies in order, by name of the chaser.
    """
    best: dict[str, Legs] | None = None
    most = -math.inf
    for order in (_by_ratio, _by_loss):
        routes = _cut(instance, plan, prices, rating, budget, order)
        if routes is not None and any(routes.values()):
            chosen = [body for legs in routes.values() for body in _targets(instance, legs)]
            worth = rating.worth_of(instance, chosen)
            if worth > most:
                best, most = routes, worth
    if best is None:
        return None
    return {name: tuple(body for body, _ in legs) for name, legs in best.items()}


def _by_ratio(cut: _Cut) -> tuple[float, float]:
    return cut.lost / cut.saved, cut.lost


def _by_loss(cut: _Cut) -> tuple[float, float]:
    return cut.lost, -cut.saved


def _cut(
    instance: Instance,
    plan: Plan,
    prices: CampaignPrices,
    rating: Rating,
    budget: float,
    order: Callable[[_Cut], tuple[float, float]],
) -> dict[str, Legs] | None:
    """Routes after as many cuts as the budget asks for, the first in order each time."""
    routes: dict[str, Legs] = {
        flown.chaser.name: flown.spent for flown in routes_of(instance, plan)
    }
    while _euros(instance, routes, prices) > budget:
        cuts = [
            cut
            for name, legs in routes.items()
            if legs
            for cut in _cuts(instance, routes, name, prices, rating)
        ]
        if not cuts:
            return None
        best = min(cuts, key=order)
        routes[best.chaser] = best.legs
    return routes


def _euros(instance: Instance, routes: Mapping[str, Legs], prices: CampaignPrices) -> float:
    return math.fsum(
        prices.of_route(instance, chaser, routes[chaser.name])
        for chaser in instance.chasers
        if chaser.name in routes
    )


def _cuts(
    instance: Instance,
    routes: Mapping[str, Legs],
    name: str,
    prices: CampaignPrices,
    rating: Rating,
) -> list[_Cut]:
    """Shorter routes of a chaser that cost less: one target less, or none at all."""
    chaser = next(each for each in instance.chasers if each.name == name)
    legs = routes[name]
    shorter: list[Legs] = [()]
    if chaser.end == "anywhere":
        shorter.append(_without_last_target(instance, legs))
    required = {target.name for target in instance.targets if target.required}
    spent, there = prices.of_route(instance, chaser, legs), _targets(instance, legs)
    others = [
        body
        for other, flown in routes.items()
        if other != name
        for body in _targets(instance, flown)
    ]
    before = rating.worth_of(instance, (*others, *there))
    found = []
    for rest in shorter:
        left = _targets(instance, rest)
        saved = spent - prices.of_route(instance, chaser, rest)
        if saved > 0.0 and required.isdisjoint(set(there) - set(left)):
            lost = before - rating.worth_of(instance, (*others, *left))
            found.append(_Cut(name, rest, saved, lost))
    return found


def _without_last_target(instance: Instance, legs: Legs) -> Legs:
    """The legs before the last target, without stations that follow nothing then."""
    rest = list(legs)
    while rest and rest[-1][0] in instance.station_names:
        rest.pop()
    rest = rest[:-1]
    while rest and rest[-1][0] in instance.station_names:
        rest.pop()
    return rest


def _targets(instance: Instance, legs: Sequence[tuple[str, float]]) -> list[str]:
    return [body for body, _ in legs if body not in instance.station_names]
