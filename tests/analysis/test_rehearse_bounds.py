"""Bounds on policies, attacked by policies that decide at random and by enumeration."""

from __future__ import annotations

import math
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawn_worlds import AtRandom, drawn_uncertainty
from random_rules import (
    drifting_mission,
    given_field,
    mixed_campaign,
    random_campaign,
    random_mission,
    towing_mission,
)
from roomy_fields import roomy_launched
from seeds import over_kinds, over_seeds
from verify_fields import campaign_with_cargo

import adr_opt
from adr_opt.analysis.rehearse import bounds as bounding
from adr_opt.analysis.rehearse.bounds import BoundSetting, bounds, gap, world_bounds
from adr_opt.analysis.rehearse.flight import FlownMission, rehearsed
from adr_opt.analysis.rehearse.ground import Ground
from adr_opt.analysis.rehearse.intended import intended
from adr_opt.analysis.rehearse.policies import policy_of
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.analysis.rehearse.service_times import ServiceTimes, levels_of, most_worths
from adr_opt.analysis.rehearse.tries import TryWorths, rounded_up, worths_of_tries
from adr_opt.analysis.rehearse.worths import prices_of_tries
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.problem.chasers import InOrbit, Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import ServiceUncertainty, Uncertainty
from adr_opt.problem.world import DrawnWorld

EPSILON = 1e-9

RANDOM_POLICIES = 40


@over_kinds(
    "draw, seeds",
    single=(random_mission, range(40), 3),
    campaign=(random_campaign, range(40), 2),
    mixed=(mixed_campaign, range(20), 1),
    drifting=(drifting_mission, range(20), 1),
    given=(given_field, range(40), 3),
    launched=(roomy_launched, range(20), 2),
    towing=(towing_mission, range(20), 2),
    kits=(campaign_with_cargo, range(20), 2),
)
def test_no_policy_exceeds_a_bound_in_any_world(draw, seeds) -> None:  # type: ignore[no-untyped-def]
    """Neither its prize that of perfect information, nor what its tries are worth the penalised."""
    met = 0
    for seed in seeds:
        instance = draw(seed)
        uncertainty = drawn_uncertainty(instance, seed)
        ground = Ground(instance)
        bound = world_bounds(ground, BoundSetting(instance, uncertainty, "exact", 60.0), seed)
        world, best = DrawnWorld(instance, uncertainty, seed), 0.0
        for flown in _all_flown(ground, world, seed):
            assert flown.prize <= bound.perfect + EPSILON, seed
            assert flown.expected <= bound.penalised + EPSILON, seed
            assert bound.required or not ground.required <= set(flown.serviced), seed
            best = max(best, flown.prize)
        met += best > bound.perfect - EPSILON
    assert met  # a bound that nobody meets may be worth nothing


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
        ground = Ground(instance)
        # No target is worth less than the time of its service: prices beyond that are refused.
        share = float(np.random.default_rng(seed).uniform(0.0, 0.6))
        tries_s = prices_of_tries(ground, 1.0)
        worth_per_s = [ground.prizes[body] / tries_s[body] for body in tries_s if tries_s[body]]
        per_day = share * DAY_S * min(worth_per_s, default=0.0)
        setting = BoundSetting(instance, uncertainty, "exact", 60.0, per_day)
        bound, world = world_bounds(ground, setting, seed), DrawnWorld(instance, uncertainty, seed)
        for flown in _all_flown(ground, world, seed):
            assert _priced(ground, uncertainty, flown, per_day) <= bound.penalised + EPSILON, seed


def test_a_price_of_time_changes_no_mean() -> None:
    """What tries are worth with a price of their time has the mean of the prize."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "beam").plan
    uncertainty = Uncertainty(capture={"success": 0.6, "tries": 3}, gone=0.1)
    ground = Ground(instance)
    planned = intended(ground, plan)
    differences = []
    for seed in range(1500):
        world = DrawnWorld(instance, uncertainty, seed)
        policy = policy_of("skip")(ground, planned, uncertainty, 0)
        flown = rehearsed(ground, world, policy, planned.kits)
        differences.append(_priced(ground, uncertainty, flown, 3.0) - flown.prize)
    error = np.std(differences) / math.sqrt(len(differences))
    assert abs(np.mean(differences)) < 4.0 * error


def _priced(ground: Ground, uncertainty: Uncertainty, flown: FlownMission, per_day: float) -> float:
    """What the tries of a rehearsal are worth with a price of their time, draw by draw."""
    total, paid = 0.0, prices_of_tries(ground, per_day / DAY_S)
    for craft in flown.crafts:
        for made in craft.made:
            j = made.hop.destination
            if j < ground.stations or (made.outcome == "dry" and not made.tries):
                continue
            name = ground.names[j]
            worths = worths_of_tries(
                ground.prizes[j], uncertainty.success_of(name), uncertainty.tries_of(name),
                paid[j],
            )  # fmt: skip
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
                mean = success * ground.prizes[j] + (1.0 - success) * after[attempt]
                total += mean if caught else mean - after[attempt]
    return total


LATE = ServiceUncertainty.model_validate(
    {"factor": {"lognormal_sigma": 0.6}, "added": {"chance": 0.3, "mean_s": 4000.0}}
)
"""Times of services of which many are much longer than planned."""


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
            service_s=LATE, capture={"success": 0.8}, gone=0.1,
            targets={instance.targets[-1].name: {"service_s": {}}},
        ).of(instance)  # fmt: skip
        ground = Ground(instance)
        share = float(np.random.default_rng(seed).uniform(0.0, 0.4))
        tries_s = prices_of_tries(ground, 1.0)
        worth_per_s = [ground.prizes[body] / tries_s[body] for body in tries_s if tries_s[body]]
        per_day = share * DAY_S * min(worth_per_s, default=0.0)
        setting = BoundSetting(instance, uncertainty, "exact", 60.0, per_day)
        bound, world = world_bounds(ground, setting, seed), DrawnWorld(instance, uncertainty, seed)
        for flown in _all_flown(ground, world, seed):
            worth = _worth_of_times(ground, world, flown, per_day)
            assert worth <= bound.penalised + EPSILON, seed


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
    ground = Ground(instance)
    planned = intended(ground, plan)
    differences, late = [], 0
    for seed in range(1500):
        world = DrawnWorld(instance, uncertainty, seed)
        policy = policy_of("skip")(ground, planned, uncertainty, 0)
        flown = rehearsed(ground, world, policy, planned.kits)
        late += any(made.outcome == "late" for craft in flown.crafts for made in craft.made)
        differences.append(_worth_of_times(ground, world, flown, 8.0) - flown.prize)
    assert late > 100
    error = np.std(differences) / math.sqrt(len(differences))
    assert abs(np.mean(differences)) < 4.0 * error


def _worth_of_times(
    ground: Ground, world: DrawnWorld, flown: FlownMission, per_day: float
) -> float:
    """What services of one try are worth with a price of the time that they take in the mission."""
    total, per_s, uncertainty = 0.0, per_day / DAY_S, world.uncertainty
    for craft in flown.crafts:
        limits = ground.chasers[craft.chaser].limits
        for made in craft.made:
            j, outcome = made.hop.destination, made.outcome
            if j < ground.stations or (outcome == "dry" and not made.tries):
                continue
            name, planned_s = ground.names[j], float(limits.service[j])
            begin_s = max(made.hop.arrival, float(limits.opens[j]))
            left_s = limits.duration - begin_s
            times = ServiceTimes(planned_s, uncertainty.service_of(name))
            mean = uncertainty.success_of(name) * ground.prizes[j] * times.chance_by(left_s)
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
        assert times.mean_s == pytest.approx(drawn_s.mean(), abs=100.0)


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


def _all_flown(ground: Ground, world: DrawnWorld, seed: int):  # type: ignore[no-untyped-def]
    most = [0 if each.loads is None else each.loads.full.size - 1 for each in ground.chasers]
    for number in range(RANDOM_POLICIES):
        rng = np.random.default_rng([seed, number])
        kits = tuple(int(rng.integers(0, each + 1)) for each in most)
        yield rehearsed(ground, world, AtRandom(ground, rng), kits)
    plan = adr_opt.solve(ground.instance, time_limit=5.0).plan
    if plan is not None:
        planned = intended(ground, plan)
        for name in ("follow", "skip", "replan", "learned"):
            yield rehearsed(
                ground, world, policy_of(name)(ground, planned, world.uncertainty, 0), planned.kits
            )


def _alone(seed: int) -> Instance:
    """A few targets on which one chaser without a station spends its only tank."""
    instance = adr_opt.generate("tiny", seed, targets=4)
    rng = np.random.default_rng([6, seed])
    prizes = rng.choice([1.0, 1.5, 2.5], 4)
    return instance.replace(
        mission=instance.mission.replace(duration_s=40_000.0),
        stations=(),
        chasers=(
            instance.chaser.replace(
                start=InOrbit(orbit=instance.stations[0].orbit),
                end="anywhere",
                tank=Tank(delta_v_m_s=float(rng.uniform(200.0, 1200.0))),
            ),
        ),
        targets=tuple(
            target.replace(prize=float(prize))
            for target, prize in zip(instance.targets, prizes, strict=True)
        ),
    )


def _most_in_world(ground: Ground, world: DrawnWorld) -> float:
    """The most that any order of targets collects in a world, over all connections."""
    what, instance, best = ground.chasers[0], ground.instance, 0.0
    limits = what.limits
    numbers = range(ground.first_target, len(ground.names))
    for order in permutations(numbers):
        fronts, body, prize = [(limits.ready, what.budget)], what.start, 0.0
        for j in order:
            name = ground.names[j]
            rows = ground.rows(body, j, towed=False)
            took_s = world.service_s(name, float(limits.service[j]))
            took_s *= world.first_success(name) or 1
            factor = world.leg_factor("short", name)
            ends = [
                (max(arrival, float(limits.opens[j])) + took_s, left - factor * cost)
                for free, left in fronts
                for departure, arrival, cost in zip(
                    rows.departure, rows.arrival, rows.delta_v, strict=True
                )
                if departure >= free - 1e-3
            ]  # fmt: skip
            fronts = _front(each for each in ends if each[0] <= limits.duration and each[1] >= 0.0)
            if not fronts:
                break
            body, prize = j, prize + instance.targets[j - ground.first_target].prize
            best = max(best, prize)
    return best


def _front(states):  # type: ignore[no-untyped-def]
    """The states that no other one is earlier and richer than."""
    kept: list[tuple[float, float]] = []
    for free, left in sorted(states, key=lambda each: (each[0], -each[1])):
        if not kept or left > kept[-1][1]:
            kept.append((free, left))
    return kept


@over_seeds(range(30), gate=3)
def test_perfect_information_is_the_best_of_all_orders_in_the_world(seed: int) -> None:
    """Without stations and captures the bound is what enumeration collects in the drawn world."""
    instance = _alone(seed)
    uncertainty = Uncertainty(
        legs={"delta_v_factor": {"lognormal_sigma": 0.3}},
        service_s={"factor": {"lognormal_sigma": 0.4}, "added": {"chance": 0.3, "mean_s": 4000.0}},
    )
    ground, world = Ground(instance), DrawnWorld(instance, uncertainty, seed)
    found = world_bounds(ground, BoundSetting(instance, uncertainty, "exact", 60.0), seed)
    assert found.proven
    assert found.perfect == pytest.approx(_most_in_world(ground, world))


def test_tries_are_worth_their_prizes_on_average() -> None:
    """Worths of tries are those of dynamic programming; penalties have a mean of zero."""
    assert worths_of_tries(2.0, 0.8, 2) == pytest.approx((1.92, 1.6, 0.0))
    instance = adr_opt.generate("tiny", 0)
    uncertainty = Uncertainty(capture={"success": 0.7, "tries": 3}, gone=0.2)
    worths, target = TryWorths(instance, uncertainty), instance.first_target
    arrival = 0.2 * worths.on_arrival(target, gone=True)
    arrival += 0.8 * worths.on_arrival(target, gone=False)
    assert arrival == pytest.approx(0.0, abs=1e-12)
    for attempt in (1, 2, 3):
        mean = 0.7 * worths.of_try(target, attempt, caught=True)
        mean += 0.3 * worths.of_try(target, attempt, caught=False)
        assert mean == pytest.approx(0.7 * instance.targets[0].prize)


def test_follow_of_an_optimal_plan_is_optimal_where_only_captures_fail() -> None:
    """With one try and visits alone, its gap to the penalised bound is nothing in every world.

    Failures change neither tank, time nor payload. The plan is optimal for the sum of p r.
    """
    instance = adr_opt.generate("tiny", 2, targets=6)
    instance = instance.replace(chasers=(instance.chaser.replace(tank=Tank(delta_v_m_s=300.0)),))
    chances = {
        target.name: {"success": 0.3 + 0.1 * number}
        for number, target in enumerate(instance.targets)
    }
    uncertainty = Uncertainty(targets=chances)
    worth = instance.replace(
        targets=tuple(
            target.replace(prize=round(chances[target.name]["success"] * target.prize, 9))
            for target in instance.targets
        )
    )
    best = adr_opt.solve(worth, "exact", time_limit=60.0).plan
    assert best is not None
    assert best.status == "optimal"
    plan = best.replace(instance=best.instance.replace(name=instance.name, sha256=instance.sha256))
    made = rehearse(instance, plan, uncertainty, policy="follow", samples=6)
    found = bounds(instance, uncertainty, samples=6, time_limit=60.0)
    assert len({each.prize for each in made.outcomes}) > 1
    for outcome, world in zip(made.outcomes, found.worlds, strict=True):
        assert world.proven
        assert outcome.expected == pytest.approx(world.penalised)
        assert outcome.expected == pytest.approx(best.objective)
    gaps = found.gaps(made)
    assert gaps["penalised"]["gap"] == pytest.approx(0.0, abs=1e-9)
    assert gaps["perfect"]["gap"] > 0.0


def test_a_required_target_that_cannot_be_serviced_is_disproven() -> None:
    """Where a required target is always gone no world lets all required targets be met."""
    instance = adr_opt.generate("tiny", 0)
    first, *others = instance.targets
    instance = instance.replace(targets=(first.replace(required=True), *others))
    gone = Uncertainty(targets={first.name: {"gone": 1.0}})
    told = bounds(instance, gone, samples=2, time_limit=20.0).to_dict()
    assert told["required_met"]["share"] == 0.0
    told = bounds(instance, Uncertainty(), samples=1, time_limit=20.0).to_dict()
    assert told["required_met"]["share"] == 1.0


def test_names_of_targets_may_look_like_those_of_the_known_world() -> None:
    """A target may be called as the body is at which a chaser gives up."""
    instance = adr_opt.generate("tiny", 0, targets=3)
    tries = Uncertainty(capture={"success": 0.5, "tries": 2})
    first, second, *others = instance.targets
    for name in (" (given up)", " (given up, 1)"):
        second = second.replace(name=first.name + name)
        renamed = instance.replace(targets=(first, second, *others))
        world = next(
            world
            for world in (DrawnWorld(renamed, tries, seed) for seed in range(100))
            if world.first_success(first.name) != 1 and world.first_success(second.name) != 1
        )
        found = world_bounds(
            Ground(renamed), BoundSetting(renamed, tries, "exact", 60.0), world.seed
        )
        assert found.proven
        assert 0.0 < found.penalised <= len(renamed.targets)


def test_proofs_elsewhere_use_one_core_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """A bound that can use all cores gets one where others are proven beside it."""
    asked = []

    def noted(problem, method, **more):  # type: ignore[no-untyped-def]
        asked.append(more.get("jobs"))
        return adr_opt.bound(problem, method, **more)

    monkeypatch.setattr(bounding, "bound", noted)
    instance = adr_opt.generate("tiny", 0, targets=3)
    setting = BoundSetting(instance, Uncertainty(), "exact", 60.0)
    bounds(instance, Uncertainty(), samples=1)
    bounding._bounded_there(setting, (0,))
    assert asked == [None, 1]


def test_bounds_without_a_search_begin_with_a_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    """The bound of multipliers is given a plan, and both prove the same of a small field."""
    begun = []

    def noted(problem, method, **more):  # type: ignore[no-untyped-def]
        begun.append(more.get("start"))
        return adr_opt.bound(problem, method, **more)

    monkeypatch.setattr(bounding, "bound", noted)
    instance = adr_opt.generate("tiny", 1, targets=5)
    uncertainty = Uncertainty(service_s=LATE)
    found = [
        bounds(instance, uncertainty, samples=1, method=method, time_limit=60.0, time_price=2.0)
        for method in ("exact", "lagrangian")
    ]
    assert begun[:2] == [None, None]
    assert all(begun[2:])
    assert found[0].worlds[0].proven
    assert found[0].worlds == found[1].worlds


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


def test_bounds_are_resumed(tmp_path: Path) -> None:
    """Bounds in a file are not proven again."""
    instance = adr_opt.generate("tiny", 0)
    uncertainty = drawn_uncertainty(instance, 3)
    path = tmp_path / "bounds.jsonl"
    first = bounds(instance, uncertainty, samples=2, path=path)
    told: list[int] = []
    again = bounds(
        instance, uncertainty, samples=2, path=path, told=lambda done, of: told.append(done)
    )
    assert again.worlds == first.worlds
    assert not told


def test_intervals_of_gaps_cover_the_gap() -> None:
    """Of many drawn samples the 95 % intervals hold the true gap about as often."""
    rng = np.random.default_rng(1)
    covered = 0
    for _ in range(300):
        above = rng.normal(20.0, 2.0, 60)
        below = 0.9 * above + rng.normal(0.0, 1.0, 60)
        told = gap(above.tolist(), below.tolist())
        covered += told["low"] <= 0.1 <= told["high"]
    assert 0.90 <= covered / 300 <= 0.99
    assert gap([1.0], [1.0]) == {"gap": 0.0, "low": None, "high": None, "samples": 1}
    assert gap([], [])["gap"] is None


def test_prizes_are_rounded_up_to_few_digits() -> None:
    """Never below the prize, and by no more than a part in a hundred million."""
    for prize in (0.96, 1.0 / 3.0, 2e-7 / 3.0, 123456.789012345, 1e12 / 7.0):
        up = rounded_up(prize)
        assert prize * (1.0 - 1e-11) <= up <= prize * (1.0 + 2e-8)
        assert math.isfinite(up)
    assert rounded_up(0.0) == 0.0


def test_several_tries_with_kits_over_given_connections_are_refused() -> None:
    """No given connection leads to the body at which a chaser gives up."""
    instance = given_field(0)
    first, *others = instance.targets
    chaser = instance.chaser.replace(kits=2)
    kitted = instance.replace(targets=(first.replace(removal="kit"), *others), chasers=(chaser,))
    tries = Uncertainty(capture={"success": 0.5, "tries": 2})
    with pytest.raises(InputError, match="several tries"):
        bounds(kitted, tries, samples=1)


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
