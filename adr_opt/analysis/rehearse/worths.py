"""Values of targets to a clairvoyant in a known world (docs/model.md section 13.3)."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...problem.bodies import Target
from ...problem.instance import Instance
from ...problem.uncertainty import Uncertainty
from ...problem.world import DrawnWorld
from .mission_facts import MissionFacts
from .service_times import LateWorth, levels_of, most_worths
from .tries import TryWorths

LEVEL = 0.05
"""Least step in the falling value of a late service, as a share of the prize."""

ALIKE = 0.05
"""Difference of the times of tries that have one price, as a share of the median."""


class Counted(NamedTuple):
    """Value of a target to a clairvoyant.

    Attributes
    ----------
    going_on, giving_up : float
        With all tries that it takes, and with fewer.
    late : tuple of LateWorth
        What going on counts at most where little time is left, falling; with any, a service may
        go on after the mission.
    """

    going_on: float
    giving_up: float = 0.0
    late: tuple[LateWorth, ...] | None = None


Worth = Callable[[Target], Counted]


def can_be_serviced(world: DrawnWorld, target: Target) -> bool:
    """Whether a target exists and one of its tries succeeds."""
    return not world.is_gone(target.name) and world.first_success(target.name) is not None


def clairvoyant_worth(facts: MissionFacts, world: DrawnWorld) -> Worth:
    """The prize of each target that can be serviced in a world."""
    return lambda target: Counted(target.prize if can_be_serviced(world, target) else 0.0)


def required_worth(facts: MissionFacts, world: DrawnWorld) -> Worth:
    """1 for each required target that can be serviced in a world."""
    return lambda target: Counted(float(target.required and can_be_serviced(world, target)))


def takes_uncertain_time(uncertainty: Uncertainty, target: str) -> bool:
    """Whether the service of a target may differ in time from the plan."""
    model = uncertainty.service_of(target)
    return model.factor is not None or model.added is not None


def is_priced(uncertainty: Uncertainty, target: Target) -> bool:
    """Whether the time of a target's service can be priced.

    It is certain, or there is one try, and no tow that has to end in time as well.
    """
    if not takes_uncertain_time(uncertainty, target.name):
        return True
    is_once = uncertainty.tries_of(target.name) == 1 or uncertainty.success_of(target.name) == 1.0
    return is_once and target.removal != "tow"


def prices_of_tries(facts: MissionFacts, per_s: float) -> dict[int, float]:
    """Price of the planned time of a try at each target, by its number.

    Tries of about the median time all have its price: prizes are the same then, and proofs quicker.
    """
    service = facts.chasers[0].limits.service
    tries_s = {
        body: float(service[body]) - facts.tow_s.get(body, 0.0)
        for body in range(facts.first_target, len(facts.names))
    }
    if not tries_s:
        return {}
    usual_s = sorted(tries_s.values())[len(tries_s) // 2]
    return {
        body: per_s * (usual_s if abs(try_s - usual_s) <= ALIKE * usual_s else try_s)
        for body, try_s in tries_s.items()
    }


def penalised_worth(facts: MissionFacts, world: DrawnWorld, per_s: float = 0.0) -> Worth:
    """The mean prize of going to each target, and the part left if a chaser gives up.

    Parameters
    ----------
    per_s : float
        Price of the time of services [prize per s].
    """
    of_tries = _worth_of_tries(facts, world, per_s)

    def worth(target: Target) -> Counted:
        if per_s > 0.0 and takes_uncertain_time(world.uncertainty, target.name):
            return _worth_of_time(facts, world, target, per_s)
        return of_tries(target)

    return worth


def _worth_of_tries(facts: MissionFacts, world: DrawnWorld, per_s: float) -> Worth:
    """Value of a target whose service times are certain."""
    worths = TryWorths(facts.instance, world.uncertainty, prices_of_tries(facts, per_s))

    def worth(target: Target) -> Counted:
        number, first = facts.number[target.name], world.first_success(target.name)
        tries = world.uncertainty.tries_of(target.name) if first is None else first
        if world.is_gone(target.name):
            return Counted(max(worths.most(number), 0.0))
        # To give up later counts more, and is said to take no longer than one try.
        given_up = max(worths.after_failures(number, tries - 1), 0.0)
        return Counted(max(worths.after(number, tries), 0.0), given_up)

    return worth


def _worth_of_time(facts: MissionFacts, world: DrawnWorld, target: Target, per_s: float) -> Counted:
    """Value of a single try of uncertain time: the mean worth less the price of the time spent."""
    uncertainty, name = world.uncertainty, target.name
    planned_s = float(facts.chasers[0].limits.service[facts.number[name]])
    most = most_worths(
        planned_s,
        uncertainty.service_of(name),
        uncertainty.success_of(name) * target.prize,
        per_s,
        facts.instance.mission.duration_s,
    )
    worth = (1.0 - uncertainty.gone_of(name)) * most.worth
    if not world.is_gone(name):
        worth = worth + per_s * np.minimum(world.service_s(name, planned_s), most.left_s)
    worth = np.maximum(worth, 0.0)
    return Counted(float(worth[-1]), 0.0, levels_of(most.left_s, worth, LEVEL * target.prize))


def refused_price(facts: MissionFacts, uncertainty: Uncertainty, per_s: float) -> str | None:
    """Why a price of the time of services is refused; None if it is not."""
    instance: Instance = facts.instance
    if not all(is_priced(uncertainty, target) for target in instance.targets):
        return (
            "penalties may price the time of tries only where services take as long as planned, or "
            "are tried once and no tow follows; leave it out"
        )
    paid = prices_of_tries(facts, per_s)
    worths = TryWorths(instance, uncertainty, paid)
    for body, target in enumerate(instance.targets, start=facts.first_target):
        # Of a drawn time, and of no prize, less than nothing counts as nothing.
        counts = target.prize > 0.0 and not takes_uncertain_time(uncertainty, target.name)
        if counts and worths.most(body) < 0.0:
            return "a target is worth less than the time of its service; give a lower price"
    return None
