"""Bounds on policies, attacked by policies that decide at random and by enumeration."""

from __future__ import annotations

import math
from itertools import permutations
from typing import Any

import numpy as np
import pytest
from drawn_worlds import LATE, all_flown, drawn_uncertainty
from plans import unjudged
from random_rules import (
    captured,
    disposing_mission,
    drifting_mission,
    given_field,
    mixed_campaign,
    random_campaign,
    random_mission,
    reserving,
    towing_mission,
)
from roomy_fields import roomy_launched
from seeds import over_kinds, over_seeds
from verify_fields import campaign_with_cargo

import adr_opt
from adr_opt.analysis.rehearse import bounds as bounding
from adr_opt.analysis.rehearse.bounds import BoundSetting, bounds, gap, world_bounds
from adr_opt.analysis.rehearse.mission_facts import MissionFacts
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.analysis.rehearse.tries import TryWorths, rounded_up, worths_of_tries
from adr_opt.common.errors import InputError
from adr_opt.problem.chasers import InOrbit, Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.problem.world import DrawnWorld
from adr_opt.study import Place

EPSILON = 1e-9


def _captured(seed: int) -> Instance:
    """Targets with several windows, visited or towed, by one chaser or several."""
    return captured((random_mission, towing_mission, mixed_campaign)[seed % 3](seed), seed)


def _reserving(seed: int) -> Instance:
    """Parts of tanks are kept, and objects are released for a time or under control."""
    return reserving((random_mission, disposing_mission, mixed_campaign)[seed % 3](seed), seed)


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
    captured=(_captured, range(60), 3),
    reserving=(_reserving, range(60), 2),
)
def test_no_policy_exceeds_a_bound_in_any_world(draw, seeds) -> None:  # type: ignore[no-untyped-def]
    """Neither its prize that of perfect information, nor what its tries are worth the penalised."""
    met = 0
    for seed in seeds:
        instance = draw(seed)
        uncertainty = drawn_uncertainty(instance, seed)
        facts = MissionFacts(instance)
        bound = world_bounds(facts, BoundSetting(instance, uncertainty, "exact", 60.0), seed)
        world, best = DrawnWorld(instance, uncertainty, seed), 0.0
        for flown in all_flown(facts, world, seed):
            assert flown.prize <= bound.perfect + EPSILON, seed
            assert flown.expected <= bound.penalised + EPSILON, seed
            assert bound.required or not facts.required <= set(flown.serviced), seed
            best = max(best, flown.prize)
        met += best > bound.perfect - EPSILON
    assert met  # a bound that nobody meets may be worth nothing


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


def _most_in_world(facts: MissionFacts, world: DrawnWorld) -> float:
    """The most that any order of targets collects in a world, over all connections."""
    what, instance, best = facts.chasers[0], facts.instance, 0.0
    limits = what.limits
    numbers = range(facts.first_target, len(facts.names))
    for order in permutations(numbers):
        fronts, body, prize = [(limits.ready, what.budget)], what.start, 0.0
        for j in order:
            name = facts.names[j]
            rows = facts.rows(body, j, towed=False)
            took_s = world.service_s(name, float(limits.service[j]))
            took_s *= world.first_success(name) or 1
            factor = world.leg_factor("short", name)
            ends = [
                (max(arrival, float(limits.windows.opening[j])) + took_s, left - factor * cost)
                for free, left in fronts
                for departure, arrival, cost in zip(
                    rows.departure, rows.arrival, rows.delta_v, strict=True
                )
                if departure >= free - 1e-3
            ]
            fronts = _front(each for each in ends if each[0] <= limits.duration and each[1] >= 0.0)
            if not fronts:
                break
            body, prize = j, prize + instance.targets[j - facts.first_target].prize
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
    facts, world = MissionFacts(instance), DrawnWorld(instance, uncertainty, seed)
    found = world_bounds(facts, BoundSetting(instance, uncertainty, "exact", 60.0), seed)
    assert found.proven
    assert found.perfect == pytest.approx(_most_in_world(facts, world))


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
    made = rehearse(instance, unjudged(instance, plan), uncertainty, policy="follow", samples=6)
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
            MissionFacts(renamed), BoundSetting(renamed, tries, "exact", 60.0), world.seed
        )
        assert found.proven
        assert 0.0 < found.penalised <= len(renamed.targets)


def _noted(monkeypatch: pytest.MonkeyPatch, name: str) -> list[Any]:
    """What bounds are asked with under a name, one after the other."""
    asked = []

    def noted(problem, method, **more):  # type: ignore[no-untyped-def]
        asked.append(more.get(name))
        return adr_opt.bound(problem, method, **more)

    monkeypatch.setattr(bounding, "bound", noted)
    return asked


def test_proofs_elsewhere_use_one_core_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """A bound that can use all cores gets one where others are proven beside it."""
    asked = _noted(monkeypatch, "jobs")
    instance = adr_opt.generate("tiny", 0, targets=3)
    setting = BoundSetting(instance, Uncertainty(), "exact", 60.0)
    bounds(instance, Uncertainty(), samples=1)
    setting.study().row(0, Place(alone=False))
    assert asked == [None, 1]


def test_bounds_without_a_search_begin_with_a_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    """The bound of multipliers is given a plan, and both prove the same of a small field."""
    begun = _noted(monkeypatch, "start")
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
