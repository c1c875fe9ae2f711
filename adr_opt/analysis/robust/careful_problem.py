"""A mission with reserves, so that tanks, stays and launches hold with required chances.

It is an ordinary mission (docs/model.md section 13.4): legs are charged for what they may cost
more, services take as long as stays do with that chance, launches come after slips, and prizes are
what going to a target is worth on average. Any planner plans it, and what any bound proves of it is
proven of all plans that keep these chances.

:class:`Levels` are the chances: how likely each tank, stay and launch is to be kept.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from statistics import NormalDist
from typing import NamedTuple

from ...common.errors import InputError
from ...legs.corrections import CERTAIN, Corrections, Moments, RiskCharge
from ...mission.problem import Problem
from ...plan.leg_kinds import leg_kinds
from ...plan.plan import Plan
from ...plan.routes import routes_of
from ...problem.instance import Instance
from ...problem.uncertainty import Uncertainty
from ..departures import plan_of
from ..rehearse.mission_facts import MissionFacts
from ..rehearse.tries import mean_worths, with_worths
from .promise import Promise, StayTime, slip_quantile

_NORMAL = NormalDist()

MOST_LEVEL = 1.0 - 1e-9

LEAST_STEP = 0.3
"""Least difference of shared levels from the confidence, in normal scores."""


class Levels(NamedTuple):
    """Required chance of each part of a promise.

    Attributes
    ----------
    tank : float or None
        Each tank; None: legs take what they are planned to.
    stay : float
        Each stay ends before the next leg departs.
    launch : float
        Each launch.
    """

    tank: float | None
    stay: float
    launch: float


def equal(confidence: float) -> Levels:
    """Levels kept by every plan whose promise holds with a confidence."""
    return Levels(confidence, confidence, confidence)


def shared(confidence: float, promise: Promise) -> Levels:
    """The risk shared out equally: among kinds of parts, and among the parts of each.

    Each level is above the confidence, since charges ask less than a tank of unequal legs needs.

    Parameters
    ----------
    confidence : float
        Of the whole promise.
    promise : Promise
        Of a plan, whose numbers of parts are assumed.
    """
    numbers = len(promise.tanks), len(promise.stays), len(promise.launches)
    kinds = sum(number > 0 for number in numbers)
    least = _NORMAL.cdf(_NORMAL.inv_cdf(confidence) + LEAST_STEP)
    return Levels(*(max(confidence ** (1.0 / max(1, kinds * number)), least) for number in numbers))


def between(first: Levels, second: Levels, share: float) -> Levels:
    """Levels interpolated or extrapolated between two others by their normal scores."""

    def score(level: float | None) -> float:
        assert level is not None
        return _NORMAL.inv_cdf(min(level, MOST_LEVEL))

    return Levels(
        *(
            min(_NORMAL.cdf(score(a) + share * (score(b) - score(a))), MOST_LEVEL)
            for a, b in zip(first, second, strict=True)
        )
    )


def careful_problem(
    facts: MissionFacts,
    uncertainty: Uncertainty,
    levels: Levels,
    *,
    services_s: Mapping[str, float] | None = None,
) -> Problem:
    """The mission with reserves.

    Parameters
    ----------
    facts : MissionFacts
        Of the instance.
    uncertainty : Uncertainty
    levels : Levels
    services_s : mapping of str to float, optional
        Times of services that last otherwise than planned, by name of the target; by default as
        long as stays do with the chance of the levels [s].

    Raises
    ------
    InputError
        Tanks can be used so little that none holds anything with that chance, or some service has
        no time that it does not exceed.
    """
    instance = _instance(facts.instance, uncertainty, levels)
    corrections = Corrections(
        services_s=_services(facts, uncertainty, levels.stay) if services_s is None else services_s,
        charge=None if levels.tank is None else risk_charge(facts, uncertainty, levels.tank),
    )
    finder = facts.finder.corrected(corrections).shortened(instance)
    return Problem(instance, connecting=finder)


def risk_charge(facts: MissionFacts, uncertainty: Uncertainty, level: float) -> RiskCharge | None:
    """Charges on legs so that each tank holds with a chance; None if legs are certain.

    Raises
    ------
    InputError
        No tank holds anything with that chance.
    """
    factors: dict[tuple[str, str], Moments] = {}
    for body, name in enumerate(facts.names):
        for kind in leg_kinds():
            target = None if body < facts.stations else name
            model = uncertainty.factor_of(kind.name, target)
            if model is not None and model.lognormal_sigma > 0.0:
                factors[name, kind.name] = Moments(*model.moments)
    usable = CERTAIN if uncertainty.tanks is None else Moments(*uncertainty.tanks.moments)
    # Below a half a plan may bet on legs that are cheap: no reserve is valid for all.
    score = max(0.0, _NORMAL.inv_cdf(level))
    if usable.mean <= score * usable.sigma:
        raise InputError(f"tanks: no share of a full tank is usable with a chance of {level:.4g}")
    largest = max(what.budget for what in facts.chasers)
    charge = RiskCharge(score, largest, usable, factors)
    return charge or None


def is_bounded(facts: MissionFacts, uncertainty: Uncertainty) -> bool:
    """Whether bounds on this mission hold for all plans that keep the required chances.

    Not where tanks by mass can be used in part: what a service makes of the ΔV that is left is not
    a share of it.
    """
    return uncertainty.tanks is None or all(what.loads is None for what in facts.chasers)


def _services(facts: MissionFacts, uncertainty: Uncertainty, level: float) -> dict[str, float]:
    """Time of each service that may last longer, by name of the target [s]."""
    limits, found = facts.chasers[0].limits, {}
    for body in range(facts.first_target, len(facts.names)):
        name = facts.names[body]
        planned_s = float(limits.service[body]) - facts.tow_s.get(body, 0.0)
        stay = StayTime(uncertainty, name, planned_s)
        if stay.is_certain:
            continue
        longest_s = stay.quantile(level)
        if not math.isfinite(longest_s):
            raise InputError(
                f"target {name!r}: no planned stay suffices with a chance of {level:.6g}"
            )
        if longest_s > planned_s:
            found[name] = longest_s
    return found


def _instance(instance: Instance, uncertainty: Uncertainty, levels: Levels) -> Instance:
    """The instance with launches after slips, and mean worths as prizes.

    Launches are kept apart as planned: the slip of one delays no other.
    """
    chasers = []
    for chaser, (since, until) in zip(instance.chasers, instance.available_s, strict=True):
        slip = uncertainty.slip_of(chaser.name) if chaser.is_launched else None
        if slip is not None:
            since += slip_quantile(slip, levels.launch)
        if until is not None and since > until:  # never in time
            since, chaser = until, chaser.replace(max_targets=0)
        chasers.append(chaser.replace(available_s=(since, until)))
    mission = instance.mission.replace(launch_separation_s=None)
    instance = instance.replace(chasers=tuple(chasers), mission=mission)
    return with_worths(instance, mean_worths(instance, uncertainty))


def as_it_is(problem: Problem, plan: Plan) -> Plan:
    """A plan with reserves as a plan of the instance: the same connections at their own cost."""
    legs = {
        each.chaser.name: [
            (leg.destination, leg.departure_s, leg.arrival_s) for _, leg in each.legs
        ]
        for each in routes_of(problem.instance, plan)
    }
    return plan_of(problem, legs if len(problem.missions) > 1 else next(iter(legs.values())))
