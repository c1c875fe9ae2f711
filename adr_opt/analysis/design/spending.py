"""What a budget allows at most: launches, and targets of plans with more launches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

from ...problem.chasers import Chaser
from ...problem.instance import Instance
from .prices import CampaignPrices
from .rating import Rating

ROUNDED = 1e-6
"""What rounding may take off a number of targets."""


class Spending(NamedTuple):
    """What is left of an instance within a budget.

    Attributes
    ----------
    planned : Instance
        Without chasers that no plan within the budget can use.
    bounded : Instance
        With as many chasers or fewer: those of which a bound is worked out.
    beyond : float
        No plan within the budget that uses more of them avoids more than this.
    """

    planned: Instance
    bounded: Instance
    beyond: float


def spending_of(
    instance: Instance, prices: CampaignPrices, rating: Rating, budget: float
) -> Spending | None:
    """What a budget allows; None if not even one launch.

    A chaser costs at least its fixed price. Where all are alike but for when they are available,
    those available first can fly whatever as many others can, as they may wait; so the others are
    left out. Each target costs at least its kit, so that plans with many launches have few targets:
    those are bounded by the largest worths alone, and the other plans by a proof.

    Parameters
    ----------
    instance : Instance
        With the prices applied.
    prices : CampaignPrices
    rating : Rating
    budget : float
        [euros].
    """
    chasers = instance.chasers
    spent = list(accumulate(sorted(chaser.priced.fixed for chaser in chasers)))
    count = sum(total <= budget for total in spent)
    if count == 0:
        return None
    if not _may_wait(instance) or not _alike(chasers):
        return Spending(instance, instance, 0.0)
    worths = sorted(rating.alone_of(instance), reverse=True)
    each = min(_least_of_target(instance, chaser, prices) for chaser in chasers)

    def most(targets: float) -> float:
        whole = len(worths) if targets > len(worths) else int(targets + ROUNDED)
        return math.fsum(worths[:whole])

    # Plans with exactly at + 1 launches, by their kits; plans with at most as many, by kits aboard.
    beyond = [most((budget - spent[at]) / each if each > 0.0 else math.inf) for at in range(count)]
    within = [most(_most_targets(chasers[0]) * (at + 1)) for at in range(count)]
    proven = min(
        range(count, 0, -1), key=lambda number: max(within[number - 1], *beyond[number:], 0.0)
    )
    return Spending(
        _first(instance, count), _first(instance, proven), max(beyond[proven:], default=0.0)
    )


def _may_wait(instance: Instance) -> bool:
    """Whether a chaser that is available earlier can fly all that it could later."""
    return instance.transfer.max_leg_s is None or instance.mission.mission_separation_s is not None


def _alike(chasers: Sequence[Chaser]) -> bool:
    """Whether chasers differ in nothing but their names and since when they are available."""
    kinds = {
        chaser.replace(name="chaser", available_s=(0.0, chaser.available_s[1]))
        for chaser in chasers
    }
    return len(kinds) == 1


def _first(instance: Instance, count: int) -> Instance:
    """The instance with the chasers that are available first."""
    if count == len(instance.chasers):
        return instance
    available = instance.available_s
    first = sorted(range(len(instance.chasers)), key=lambda at: (available[at][0], at))[:count]
    return instance.replace(chasers=tuple(instance.chasers[at] for at in sorted(first)))


def _least_of_target(instance: Instance, chaser: Chaser, prices: CampaignPrices) -> float:
    """The least that one more target costs [euros]."""
    if not all(target.service.takes_kit for target in instance.targets):
        return 0.0
    return prices.per_kit + chaser.priced.per_kg * chaser.kit_mass_kg


def _most_targets(chaser: Chaser) -> float:
    """The most targets that a chaser can service, as far as its limits say, if all take kits."""
    limits = [limit for limit in (chaser.kits, chaser.max_targets) if limit is not None]
    return min(limits, default=math.inf)
