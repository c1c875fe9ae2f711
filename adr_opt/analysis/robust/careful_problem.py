"""A mission whose plans keep tanks, stays and launches with some chances.

It is an ordinary mission (docs/model.md section 13.4): legs are charged for what they may cost
more, services take as long as stays do with that chance, launches come after slips, and prizes are
what going to a target is worth on average. Any planner plans it, and what any bound proves of it is
proven of all plans that keep these chances.
"""

from __future__ import annotations

import math
from statistics import NormalDist

from ...common.errors import InputError
from ...legs.corrections import CERTAIN, Corrections, Moments, RiskCharge
from ...mission.problem import Problem
from ...plan.leg_kinds import leg_kinds
from ...problem.instance import Instance
from ...problem.uncertainty import Uncertainty
from ..rehearse.mission_facts import MissionFacts
from ..rehearse.tries import mean_worths, with_worths
from .levels import Levels
from .stays import StayTime, slip_quantile

_NORMAL = NormalDist()


def careful_problem(
    facts: MissionFacts, uncertainty: Uncertainty, levels: Levels, *, threads: int | None = None
) -> Problem:
    """The mission with reserves.

    Parameters
    ----------
    facts : MissionFacts
        Of the instance.
    uncertainty : Uncertainty
    levels : Levels
    threads : int, optional
        Of the timetable.

    Raises
    ------
    InputError
        Tanks can be used so little that none holds anything with that chance, or some service has
        no time that it does not exceed.
    """
    instance = _instance(facts.instance, uncertainty, levels)
    corrections = Corrections(
        services_s=_services(facts, uncertainty, levels.stay),
        charge=risk_charge(facts, uncertainty, levels.tank),
    )
    finder = facts.finder.corrected(corrections).shortened(instance)
    return Problem(instance, threads=threads, connecting=finder)


def risk_charge(facts: MissionFacts, uncertainty: Uncertainty, level: float) -> RiskCharge | None:
    """What legs are charged so that each tank holds with a chance; None where legs are certain.

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
        raise InputError(f"tanks: no part of a full tank can be used with a chance of {level:.4g}")
    largest = max(what.budget for what in facts.chasers)
    charge = RiskCharge(score, largest, usable, factors)
    return charge or None


def is_bounded(facts: MissionFacts, uncertainty: Uncertainty) -> bool:
    """Whether what is proven of such a mission is proven of all plans that keep these chances.

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
                f"target {name!r}: no stay is long enough with a chance of {level:.6g}"
            )
        if longest_s > planned_s:
            found[name] = longest_s
    return found


def _instance(instance: Instance, uncertainty: Uncertainty, levels: Levels) -> Instance:
    """The instance with launches after slips, and prizes that are mean worths.

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
