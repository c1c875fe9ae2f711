"""Prices of time in bounds on policies, attacked by policies that decide at random."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from drawn_worlds import LATE, all_flown
from random_rules import given_field, random_campaign, random_mission, towing_mission
from roomy_fields import roomy_launched
from seeds import over_kinds
from verify_fields import campaign_with_cargo

import adr_opt
from adr_opt.analysis.rehearse.bounds import BoundSetting, bounds, world_bounds
from adr_opt.analysis.rehearse.flight import FlownMission, rehearsed
from adr_opt.analysis.rehearse.intended import intended
from adr_opt.analysis.rehearse.mission_facts import MissionFacts
from adr_opt.analysis.rehearse.policies import policy_of
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.analysis.rehearse.service_times import ServiceTimes, levels_of, most_worths
from adr_opt.analysis.rehearse.tries import worths_of_tries
from adr_opt.analysis.rehearse.worths import prices_of_tries
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import ServiceUncertainty, Uncertainty
from adr_opt.problem.world import DrawnWorld

EPSILON = 1e-9

Worth = Callable[[MissionFacts, DrawnWorld, FlownMission, float], float]
"""What a rehearsal is worth with a price of a day."""


def _attacked(
    instance: Instance, uncertainty: Uncertainty, most: float, worth: Worth, seed: int
) -> None:
    """Hold a bound with a drawn price of time against what policies that decide at random get."""
    facts = MissionFacts(instance)
    # No target is worth less than the time of its service: prices beyond that are refused.
    share = float(np.random.default_rng(seed).uniform(0.0, most))
    tries_s = prices_of_tries(facts, 1.0)
    worth_per_s = [facts.prizes[body] / tries_s[body] for body in tries_s if tries_s[body]]
    per_day = share * DAY_S * min(worth_per_s, default=0.0)
    setting = BoundSetting(instance, uncertainty, "exact", 60.0, per_day)
    bound, world = world_bounds(facts, setting, seed), DrawnWorld(instance, uncertainty, seed)
    for flown in all_flown(facts, world, seed):
        assert worth(facts, world, flown, per_day) <= bound.penalised + EPSILON, seed


def _equal_in_the_mean(
    instance: Instance, plan: Plan, uncertainty: Uncertainty, worth: Worth, per_day: float
) -> int:
    """Hold what rehearsals are worth against their prizes; how many of them end late."""
    facts = MissionFacts(instance)
    planned = intended(facts, plan)
    differences, late = [], 0
    for seed in range(1500):
        world = DrawnWorld(instance, uncertainty, seed)
        policy = policy_of("skip")(facts, planned, uncertainty, 0)
        flown = rehearsed(facts, world, policy, planned.kits)
        late += any(made.outcome == "late" for craft in flown.chasers for made in craft.made)
        differences.append(worth(facts, world, flown, per_day) - flown.prize)
    error = np.std(differences) / math.sqrt(len(differences))
    assert abs(np.mean(differences)) < 4.0 * error
    return late


@over_kinds(
    "draw, seeds",
    single=(random_mission, range(40), 3),
    campaign=(random_campaign, range(20), 1),
    launched=(roomy_launched, range(20), 1),
    towing=(towing_mission, range(20), 1),
    kits=(campaign_with_cargo, range(20), 1),
)
def test_no_policy_exceeds_a_bound_with_a_price_of_time(draw, seeds) -> None:  # type: ignore[no-untyped-def]
    """With the time of tries priced, what tries are worth stays below the bound, in every world.

    The price is part of what they are worth before, so that its mean is nothing.
    """
    for seed in seeds:
        instance = draw(seed)
        targets = {target.name: {"tries": 1 + at % 3} for at, target in enumerate(instance.targets)}
        uncertainty = Uncertainty(
            capture={"success": 0.6, "tries": 2}, gone=0.1, targets=targets
        ).of(instance)
        _attacked(instance, uncertainty, 0.6, _priced, seed)


def test_a_price_of_time_changes_no_mean() -> None:
    """What tries are worth with a price of their time has the mean of the prize."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "beam").plan
    uncertainty = Uncertainty(capture={"success": 0.6, "tries": 3}, gone=0.1)
    _equal_in_the_mean(instance, plan, uncertainty, _priced, 3.0)


def _priced(facts: MissionFacts, world: DrawnWorld, flown: FlownMission, per_day: float) -> float:
    """What the tries of a rehearsal are worth with a price of their time, draw by draw."""
    total, paid, uncertainty = 0.0, prices_of_tries(facts, per_day / DAY_S), world.uncertainty
    for craft in flown.chasers:
        for made in craft.made:
            j = made.hop.destination
            if j < facts.stations or (made.outcome == "dry" and not made.tries):
                continue
            name = facts.names[j]
            worths = worths_of_tries(
                facts.prizes[j], uncertainty.success_of(name), uncertainty.tries_of(name), paid[j]
            )
            after = [max(worth, 0.0) for worth in worths[1:]]
            gone = uncertainty.gone_of(name)
            if made.outcome == "gone":
                total += (1.0 - gone) * worths[0]
                continue
            total += (1.0 - gone) * worths[0] - worths[0]
            drawn = made.tries - (made.outcome in ("late", "dry"))
            for attempt in range(drawn):
                caught = made.outcome == "serviced" and attempt == drawn - 1
                success = uncertainty.success_of(name)
                mean = success * facts.prizes[j] + (1.0 - success) * after[attempt]
                total += mean if caught else mean - after[attempt]
    return total


@over_kinds(
    "draw, seeds",
    single=(random_mission, range(40), 3),
    campaign=(random_campaign, range(20), 1),
    given=(given_field, range(40), 1),
    launched=(roomy_launched, range(20), 1),
    kits=(campaign_with_cargo, range(20), 1),
)
def test_no_policy_exceeds_a_bound_with_a_price_of_uncertain_times(draw, seeds) -> None:  # type: ignore[no-untyped-def]
    """With the time of services priced that is drawn, what they are worth stays below the bound."""
    for seed in seeds:
        instance = draw(seed)
        targets = tuple(
            target.replace(removal="visit" if target.removal == "tow" else target.removal)
            for target in instance.targets
        )
        instance = instance.replace(targets=targets)
        uncertainty = Uncertainty(
            service_s=LATE,
            capture={"success": 0.8},
            gone=0.1,
            targets={instance.targets[-1].name: {"service_s": {}}},
        ).of(instance)
        _attacked(instance, uncertainty, 0.4, _worth_of_times, seed)


def test_a_price_of_uncertain_times_changes_no_mean() -> None:
    """What services are worth with a price of their drawn time has the mean of the prize.

    In a mission so short that many services end late.
    """
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "beam").plan
    ended_s = sorted(leg.end_s for leg in plan.legs)
    instance = instance.replace(
        mission=instance.mission.replace(duration_s=ended_s[min(2, len(ended_s) - 1)] + 100.0)
    )
    plan = adr_opt.solve(instance, "beam").plan
    uncertainty = Uncertainty(service_s=LATE, capture={"success": 0.7}, gone=0.1)
    assert _equal_in_the_mean(instance, plan, uncertainty, _worth_of_times, 8.0) > 100


def _worth_of_times(
    facts: MissionFacts, world: DrawnWorld, flown: FlownMission, per_day: float
) -> float:
    """What services of one try are worth with a price of the time that they take in the mission."""
    total, per_s, uncertainty = 0.0, per_day / DAY_S, world.uncertainty
    for craft in flown.chasers:
        limits = facts.chasers[craft.chaser].limits
        for made in craft.made:
            j, outcome = made.hop.destination, made.outcome
            if j < facts.stations or (outcome == "dry" and not made.tries):
                continue
            name, planned_s = facts.names[j], float(limits.service[j])
            begin_s = max(made.hop.arrival, float(limits.windows.opening[j]))
            left_s = limits.duration - begin_s
            times = ServiceTimes(planned_s, uncertainty.service_of(name))
            mean = uncertainty.success_of(name) * facts.prizes[j] * times.chance_by(left_s)
            total += (1.0 - uncertainty.gone_of(name)) * (mean - per_s * times.within_s(left_s))
            if outcome != "gone":
                total += per_s * min(world.service_s(name, planned_s), left_s)
    return total


def test_times_of_services_have_the_distribution_that_is_drawn() -> None:
    """Chances and means are those of draws, but for their noise and a part of the distribution."""
    rng = np.random.default_rng(2)
    for model in (
        LATE,
        ServiceUncertainty(factor={"lognormal_sigma": 0.5, "least": 0.8, "most": 1.5}),
        ServiceUncertainty(added={"chance": 0.4, "mean_s": 3000.0, "most_s": 5000.0}),
    ):
        drawn_s = np.full(20_000, 2000.0)
        if model.factor is not None:
            drawn_s *= [model.factor.at(each) for each in rng.random(drawn_s.size)]
        if model.added is not None:
            drawn_s += [model.added.at(each) for each in rng.random(drawn_s.size)]
        times = ServiceTimes(2000.0, model)
        for left_s in (900.0, 1700.0, 2000.0, 2900.0, 3100.0, 6900.0, 7100.0, 30_000.0):
            assert times.chance_by(left_s) == pytest.approx(np.mean(drawn_s <= left_s), abs=0.015)
            within = np.minimum(drawn_s, left_s)
            assert times.within_s(left_s) == pytest.approx(within.mean(), abs=70.0)
        assert times.within_s(math.inf) == pytest.approx(drawn_s.mean(), abs=100.0)


def test_levels_of_late_services_lie_above_their_worth() -> None:
    """At no time left is a service worth more than its level, or its level much more than it."""
    most = most_worths(2000.0, LATE, 1.0, 4.0 / DAY_S, 200_000.0)
    times, least = ServiceTimes(2000.0, LATE), 0.05
    levels = levels_of(most.left_s, most.worth, least)
    assert len(levels) > 3
    for left_s in np.random.default_rng(3).uniform(2000.0, 200_000.0, 300):
        worth = times.chance_by(left_s) - 4.0 / DAY_S * times.within_s(left_s)
        level = min(
            (each.worth for each in levels if left_s <= each.below_s), default=most.worth[-1]
        )
        assert worth - 1e-12 <= level <= worth + 2.0 * least


@pytest.mark.parametrize(
    "content",
    [
        {"service_s": {"added": {"chance": 0.04, "mean_s": 14400.0}}},
        {"service_s": {"added": {"mean_s": 0.0}}},
        {"service_s": {"factor": {"lognormal_sigma": 0.3}}, "capture": {"success": 0.08}},
        {"service_s": {"factor": {"lognormal_sigma": 0.3}}, "gone": 0.92},
    ],
)
def test_worths_that_hardly_fall_are_priced(content: dict[str, Any]) -> None:
    """Where what a late service counts falls by less than a level, bounds hold all the same."""
    instance, uncertainty = adr_opt.generate("tiny", 0, targets=4), Uncertainty(**content)
    found = bounds(instance, uncertainty, samples=2, time_price=0.1)
    followed = rehearse(
        instance, adr_opt.solve(instance, method="greedy").plan, uncertainty, samples=2
    )
    for world, row in zip(found.worlds, followed.outcomes, strict=True):
        assert world.proven
        assert world.perfect >= row.prize - EPSILON
        assert world.penalised >= 0.0


def test_targets_of_no_prize_forbid_no_price() -> None:
    """A target that nobody wants is left out by a clairvoyant, whatever time costs."""
    instance = adr_opt.generate("tiny", 0, targets=4)
    first, *others = instance.targets
    instance = instance.replace(targets=(first.replace(prize=0.0), *others))
    tries = Uncertainty(capture={"success": 0.8, "tries": 2})
    assert bounds(instance, tries, samples=1, time_price=0.1).worlds[0].proven
    with pytest.raises(InputError, match="a lower price"):
        bounds(instance, tries, samples=1, time_price=1000.0)


@pytest.mark.parametrize(
    ("price", "uncertain", "sentence"),
    [
        (-1.0, {}, "must be 0 or more"),
        (1e6, {}, "give a lower price"),
        (1.0, {"service_s": {"factor": {"lognormal_sigma": 0.1}}}, "only where services take"),
    ],
)
def test_prices_that_are_no_penalties_are_refused(
    price: float, uncertain: dict[str, object], sentence: str
) -> None:
    """A price of time that would make a bound invalid is one sentence."""
    instance = adr_opt.generate("tiny", 0)
    uncertainty = Uncertainty.model_validate({"capture": {"success": 0.5, "tries": 2}, **uncertain})
    with pytest.raises(InputError, match=sentence):
        bounds(instance, uncertainty, samples=1, time_price=price)
