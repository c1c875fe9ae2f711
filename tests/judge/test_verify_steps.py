"""Walks in steps of time: no plan is worth more, and bounds of large fields are verified."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
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
from verify_fields import (
    laden,
    legs_for,
    most_collected,
    proven,
    refuelling,
    towing_and_laden,
    worths_of,
)

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.judge.verify import steps, verify
from adr_opt.judge.verify.rules import kept_apart
from adr_opt.judge.verify.steps import most_in_steps
from adr_opt.judge.verify.terms import terms_of
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.mission import Mission
from adr_opt.plan.certificate import Certificate
from adr_opt.problem.instance import Instance


def most_of(instance: Instance, *asked: Any) -> Fraction | None:
    """What no walk of the only chaser collects more than."""
    connecting = ConnectionFinder(instance)
    terms = terms_of(instance, kept_apart(instance)[0], connecting)
    return most_in_steps(terms, connecting, *asked)[0]


def changes_tanks(instance: Instance) -> bool:
    """Whether services change what is left of a tank."""
    cargo = legs_for(instance).terms.cargo
    return bool(np.any(cargo.share != 1.0) or np.any(cargo.lost))


@over_kinds(
    "draw, seeds",
    **{
        draw.__name__: (draw, range(40), 2)
        for draw in (
            random_mission,
            drifting_mission,
            given_mission,
            variant,
            laden,
            towing_mission,
            towing_and_laden,
            refuelling,
            falling_mission,
        )
    },
)
def test_at_any_multipliers_and_prices_the_best_plan_is_worth_no_more(draw, seeds):
    """However coarse steps and slots are, with every rule on and off, and by tanks or by prices."""
    asked = by_price = 0
    for seed in seeds:
        instance = draw(seed)
        prizes, _, _ = brute_force(Mission(instance))
        if not math.isfinite(prizes):
            continue
        rng, bonus = np.random.default_rng([31, seed]), Fraction(100)
        worths = worths_of(instance, bonus)
        best = Fraction(prizes) + bonus * sum(each.required for each in instance.targets)
        drawn = rng.uniform(0.0, 1.5, len(worths)) * rng.integers(0, 2, len(worths))
        drawn[: instance.first_target] = 0.0
        multipliers = [Fraction(float(each)) for each in drawn]
        gains = [worth - less for worth, less in zip(worths, multipliers, strict=True)]
        legs, last_s = legs_for(instance), instance.mission.duration_s
        least_s, shortest = last_s / 20_000.0, min(legs.shortest, last_s)
        if shortest < 1.1 * least_s:
            continue
        # A little less: who is ready within a slack of a step's end is ready at its beginning.
        length_s = max(least_s, shortest * float(rng.choice([0.02, 0.3, 0.99])))
        tank_m_s = float(legs.terms.cargo.full[0])
        slot_m_s = max(tank_m_s / 20_000.0, float(rng.choice([0.5, 20.0, 300.0])))
        least = best - sum(multipliers) - Fraction(1, 10**9)
        prices: list[Fraction | None] = [Fraction(0)]
        if not changes_tanks(instance):
            prices += [None, Fraction(float(rng.choice([1e-4, 1e-3, 1e-2, 1.0])))]
        for price in prices:
            most = most_of(instance, gains, length_s, slot_m_s, price)
            assert most is not None, (seed, price)
            assert most >= least, (seed, price)
            by_price += bool(price)
        asked += 1
    assert asked > len(seeds) / 2
    if draw in (random_mission, drifting_mission, given_mission):
        assert by_price > len(seeds) / 2


@pytest.mark.usefixtures("no_network")
@over_kinds(
    "draw, seeds",
    **{
        draw.__name__: (draw, range(16), 16 if draw is given_mission else 6)
        for draw in (random_mission, drifting_mission, given_mission, variant)
    },
)
@pytest.mark.parametrize("iterations", [5, pytest.param(40, marks=pytest.mark.slow)])
def test_what_streams_of_legs_prove_is_verified(draw, seeds, iterations):
    """The bound without a network is verified as it is stated, and no plan is beyond it."""
    in_steps = by_price = 0
    for seed in seeds:
        instance = draw(seed)
        result = adr_opt.bound(instance, "lagrangian", time_limit=60.0, iterations=iterations)
        if result.upper_bound == math.inf:
            continue
        certificate = certificate_of(instance, result)
        assert Certificate.from_json(certificate.to_json()) == certificate
        verdict = verify(instance, None, certificate, connections=5)
        assert verdict.reasons == (), seed
        stated = min(result.upper_bound, sum(each.prize for each in instance.targets))
        assert verdict.upper_bound <= stated + 1e-5, seed
        assert verdict.upper_bound >= most_collected(instance) - 1e-9, seed
        in_steps += certificate.time_step_s is not None
        by_price += any(walks.worth_per_m_s is not None for walks in certificate.walks)
    assert in_steps >= len(seeds) / 8
    assert by_price >= len(seeds) / 8


@pytest.mark.usefixtures("no_network")
def test_where_services_change_tanks_no_leg_has_a_price():
    """Then the bound of walks that pay nothing is verified."""
    in_steps = 0
    for seed in range(12):
        instance = (laden, towing_mission)[seed % 2](seed)
        result = adr_opt.solve(instance, "auto", time_limit=60.0, iterations=3)
        if result.upper_bound == math.inf or result.evidence is None:
            continue
        certificate = certificate_of(instance, result)
        assert verify(instance, result.plan, certificate, connections=0).reasons == (), seed
        if certificate.time_step_s is not None:
            in_steps += 1
            assert not changes_tanks(instance) or certificate.walks[0].worth_per_m_s == 0.0
    assert in_steps >= 2


def in_steps_of(seed: int) -> tuple[Instance, Certificate]:
    """A field, and a certificate that counts the walks of a proof in steps."""
    instance = variant(seed)
    _, certificate = proven(instance)
    assert certificate is not None
    walks = tuple(each.replace(neighbourhoods={}) for each in certificate.walks)
    return instance, certificate.replace(walks=walks, time_step_s=200.0)


@pytest.mark.slow
def test_walks_in_steps_that_are_said_to_collect_less_are_refused():
    """Whatever price and steps are claimed, no bound is accepted below the best plan."""
    refused = accepted = 0
    for seed in range(30):
        instance, certificate = in_steps_of(seed)
        best, rng = most_collected(instance), np.random.default_rng(seed)
        for _ in range(6):
            forged = certificate.replace(
                walks=tuple(
                    walks.replace(
                        most=walks.most + float(rng.uniform(-3.0, 3.0)),
                        worth_per_m_s=rng.choice([None, 0.0, 1e-4, 2e-3]),
                    )
                    for walks in certificate.walks
                ),
                upper_bound=max(0.0, best + float(rng.uniform(-2.0, 2.0))),
                time_step_s=float(rng.uniform(20.0, 2000.0)),
                delta_v_slot_m_s=float(rng.choice([1.0, 20.0, 200.0])),
            )
            verdict = verify(instance, None, forged, connections=0)
            assert verdict.upper_bound >= best - 1e-9, seed
            refused += not verdict.verified
            accepted += verdict.verified
            assert not verdict.verified or forged.upper_bound >= best - 1e-5
    assert refused > 30
    assert accepted > 10


def test_what_cannot_be_counted_in_steps_is_one_sentence(monkeypatch):
    """Steps longer than a leg, far too many of them, memory, prices of tanks that change."""
    instance, certificate = in_steps_of(1)

    def refused(match: str, of: Instance = instance, **changes: Any) -> None:
        with pytest.raises(InputError, match=match):
            verify(of, None, certificate.replace(**changes), connections=0)

    (walks,) = certificate.walks
    names = instance.names
    refused("field time_step_s = 100000.0: some legs", time_step_s=1e5)
    refused("none may exceed 32766", time_step_s=1e-3)
    refused("none may exceed 32766", delta_v_slot_m_s=1e-4)
    remembering = walks.replace(neighbourhoods={names[1]: (names[2],)})
    refused("remember only the previous body", walks=(remembering,))
    paying = walks.replace(worth_per_m_s=0.1)
    refused("walks pay for ΔV only in steps", walks=(paying,), time_step_s=None)
    monkeypatch.setattr(steps, "available_bytes", lambda: 1e4)
    refused("not verifiable here: it takes")
    monkeypatch.undo()
    heavy = next(made for made in map(towing_mission, range(40)) if changes_tanks(made))
    with pytest.raises(InputError, match="must have worth_per_m_s = 0"):
        most_of(heavy, worths_of(heavy, Fraction(0)), 100.0, 20.0, None)
