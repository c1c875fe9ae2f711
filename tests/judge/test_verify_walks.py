"""Walks of certificates: the best plan is one of them, and with full memory walks are plans."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from brute_force import brute_force
from random_rules import (
    drifting_mission,
    falling_mission,
    given_mission,
    random_mission,
    towing_mission,
)
from seeds import over_kinds
from varied_fields import variant
from verify_fields import laden, legs_for, refuelling, towing_and_laden, worths_of

from adr_opt.judge.verify.legs import losses_of
from adr_opt.judge.verify.walk_questions import walk_question, walks_reach
from adr_opt.mission.mission import Mission

every_mission = over_kinds(
    "draw, seeds",
    **{
        draw.__name__: (draw, range(40), 4)
        for draw in (
            random_mission,
            drifting_mission,
            given_mission,
            laden,
            towing_mission,
            towing_and_laden,
            refuelling,
            falling_mission,
        )
    },
)


@every_mission
def test_whatever_walks_remember_the_best_plan_is_one_of_them(draw, seeds):
    """With any multipliers and neighbourhoods, a walk collects what brute force says, or more."""
    count = 0
    for seed in seeds:
        instance = draw(seed)
        prizes, _, _ = brute_force(Mission(instance))
        if not math.isfinite(prizes):
            continue
        rng, bonus = np.random.default_rng(seed), Fraction(100)
        worths = worths_of(instance, bonus)
        best = Fraction(prizes) + bonus * sum(each.required for each in instance.targets)
        bodies = len(worths)
        multipliers = [Fraction(0)] * instance.first_target
        drawn = rng.uniform(0.0, 1.5, bodies) * rng.integers(0, 2, bodies)
        multipliers += [Fraction(float(each)) for each in drawn[instance.first_target :]]
        gains = [worth - less for worth, less in zip(worths, multipliers, strict=True)]
        remembered = rng.random((bodies, bodies)) < rng.choice([0.0, 0.3, 1.0])
        slot = float(rng.choice([3.0, 20.0, 400.0]))
        # A hair less: brute force has summed prizes as floating-point numbers.
        most = best - sum(multipliers) - Fraction(1, 10**9)
        losses = losses_of(instance)
        legs = legs_for(instance)
        assert walks_reach(
            walk_question(legs, gains, remembered, most, slot, losses=losses)
        ).reached, seed
        count += 1
    assert count > 0.6 * len(seeds)


@over_kinds(
    "draw, seeds",
    laden=(laden, range(120), 20),
    towing_and_laden=(towing_and_laden, range(120), 20),
)
def test_whatever_the_slot_the_best_plan_is_a_walk(draw, seeds):
    """However coarsely labels look ahead past services that make a tank worth more or less."""
    count = 0
    for seed in seeds:
        instance = draw(seed)
        if instance.chaser.kit_mass_kg == 0.0:
            continue
        prizes, _, _ = brute_force(Mission(instance))
        if not prizes > 0.0 or any(each.required for each in instance.targets):
            continue
        legs, worths = legs_for(instance), worths_of(instance, Fraction(0))
        remembered = np.ones((len(worths), len(worths)), dtype=np.bool_)
        most = Fraction(prizes) - Fraction(1, 10**9)
        for slot in np.geomspace(2.0, 1000.0, 8):
            assert walks_reach(
                walk_question(legs, worths, remembered, most, float(slot))
            ).reached, (seed, slot)
        count += 1
    assert count > len(seeds) / 8


@every_mission
def test_walks_that_remember_all_are_the_plans(draw, seeds):
    """Without multipliers and with full memory, no walk collects more than the best plan."""
    decided = 0
    for seed in seeds:
        instance = draw(seed)
        prizes, _, _ = brute_force(Mission(instance))
        if not math.isfinite(prizes) or any(each.required for each in instance.targets):
            continue
        worths = worths_of(instance, Fraction(0))
        remembered = np.ones((len(worths), len(worths)), dtype=np.bool_)
        more = Fraction(prizes) + Fraction(1, 10**4)
        losses = losses_of(instance)
        legs = legs_for(instance)
        assert not walks_reach(
            walk_question(legs, worths, remembered, more, 20.0, losses=losses)
        ).reached, seed
        decided += prizes < sum(worths)
    assert decided > len(seeds) / 5


def test_no_label_is_dropped_that_the_best_plan_needs():
    """Where every set of targets is worth something else, the best plan alone is found, and is.

    One of these missions is a trap for whoever drops labels without looking at what they remember.
    """
    for seed in range(16, 32):
        instance = variant(seed)
        prizes = np.random.default_rng(seed).uniform(0.2, 1.0, len(instance.targets)).round(3)
        pairs = zip(instance.targets, prizes.tolist(), strict=True)
        instance = instance.replace(targets=tuple(t.replace(prize=worth) for t, worth in pairs))
        best, _, _ = brute_force(Mission(instance))
        legs, worths = legs_for(instance), worths_of(instance, Fraction(0))
        remembered = np.ones((len(worths), len(worths)), dtype=np.bool_)
        for off, reached in ((-1e-6, True), (1e-6, False)):
            most = Fraction(best) + Fraction(off)
            assert (
                walks_reach(walk_question(legs, worths, remembered, most, 20.0)).reached == reached
            ), seed
