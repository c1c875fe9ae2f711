"""Certificates that rest on the least time and ΔV of every service: they are verified, and true."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from brute_force import brute_force_campaign
from electric_fields import electric
from random_rules import drifting_mission, random_mission
from seeds import over_kinds
from towed_fields import drawn as towed
from varied_fields import variant

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.judge.verify import verify
from adr_opt.judge.verify.claim import bound_of, trivial_bound
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.evidence import Evidence
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.plan.certificate import Certificate, ProvenFloors
from adr_opt.problem.instance import Instance
from adr_opt.run import table_budget
from solvers.walks.floors import floor_evidence

SEEDS = 120


def pushed(seed: int) -> Instance:
    """Chasers of low thrust, most of which tow or leave kits."""
    kits = seed % 4 == 1
    return electric(seed, targets=3, chasers=1 + seed % 2, kits=kits, tows=not kits)


def proven(instance: Instance) -> tuple[float, Certificate]:
    """What floors prove of the prizes, and the certificate."""
    problem = Problem(instance)
    worth, evidence = floor_evidence(problem)
    result = certify_routes(
        problem, "floors", None, seed=0, runtime_s=0.0, upper_bound=worth, evidence=evidence
    )
    certificate = certificate_of(instance, result)
    assert Certificate.from_json(certificate.to_json()) == certificate
    return result.upper_bound, certificate


def fits(instance: Instance) -> bool:
    """Whether floors are known of it."""
    return instance.given is None


@over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(SEEDS), 25),
    j2=(drifting_mission, range(SEEDS), 25),
    variants=(variant, range(SEEDS), 25),
    towed=(towed, range(SEEDS), 25),
    pushed=(pushed, range(SEEDS), 12),
)
def test_what_floors_prove_is_verified(draw, seeds):
    """With every rule on and off the verifier comes to the bound that the solver states."""
    seen = 0
    for seed in seeds:
        instance = draw(seed)
        if not fits(instance):
            continue
        bound, certificate = proven(instance)
        verdict = verify(instance, None, certificate, connections=0)
        assert verdict.verified, (seed, verdict.reasons)
        assert verdict.upper_bound <= bound + 1e-5 * max(1.0, bound), seed
        seen += certificate.floors is not None
    assert seen > 0


@over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(SEEDS), 6),
    j2=(drifting_mission, range(SEEDS), 15),
    towed=(towed, range(SEEDS), 18),
    pushed=(pushed, range(SEEDS), 6),
)
def test_at_any_prices_no_plan_collects_more(draw, seeds):
    """Whatever time and ΔV are said to be worth, brute force finds no plan beyond the bound."""
    tight = 0
    for seed in seeds:
        instance = draw(seed)
        prizes, _ = brute_force_campaign(Problem(instance))
        if not (fits(instance) and math.isfinite(prizes)):
            continue
        _, certificate = proven(instance)
        rng = np.random.default_rng(seed)
        for _ in range(4):
            day = 10.0 ** rng.uniform(-2.0, 1.0) * rng.integers(0, 2)
            km_s = 10.0 ** rng.uniform(-2.0, 1.0) * rng.integers(0, 2)
            prices = ProvenFloors(
                worth_per_s=day / 86400.0,
                worth_per_m_s=km_s / 1000.0,
                ballast_kg=10.0 ** rng.uniform(0.0, 5.0) * rng.integers(0, 2),
                alone=certificate.prize_step is not None and bool(rng.integers(0, 2)),
            )
            bound = bound_of(instance, certificate.replace(floors=prices, multipliers={}, walks=()))
            assert bound >= prizes - 1e-9, (seed, day, km_s)
            tight += bound < trivial_bound(instance) - 1e-9
    assert tight > 0


def test_a_large_field_has_a_certificate(monkeypatch):
    """Of a field that is planned without a timetable the bound is certified, and forged it is not.

    A bound that is lower than what follows, and other prices with the same bound, are refused.
    """
    monkeypatch.setattr(table_budget, "LARGE_ENTRIES", 0)
    for name in ("LEAST_S", "MOMENT_S", "SHARE"):
        monkeypatch.setattr(table_budget, name, 0.0)
    instance = adr_opt.generate("nominal", 1, targets=40).with_limits(duration_s=3.0 * 86400.0)
    result = adr_opt.solve(instance, "auto", iterations=1, time_limit=60.0)
    result = replace(result, evidence=floors_of(instance, result.evidence))
    certificate = certificate_of(instance, result)
    assert certificate.floors is not None
    verdict = verify(instance, None, certificate)
    assert verdict.verified
    assert verdict.upper_bound == certificate.upper_bound < 40.0
    lower = certificate.replace(upper_bound=certificate.upper_bound - 1.0)
    assert not verify(instance, None, lower).verified
    for factor in (0.0, 0.5, 2.0):
        prices = certificate.floors.replace(worth_per_s=factor * certificate.floors.worth_per_s)
        assert not verify(instance, None, certificate.replace(floors=prices)).verified


def floors_of(instance: Instance, evidence: Evidence | None) -> Evidence:
    """The evidence of a large field: floors, whatever came after them."""
    assert evidence is not None
    assert evidence.floors == floor_evidence(Mission(instance))[1].floors
    return evidence


def test_floors_are_not_for_every_instance():
    """What floors are not known of, and floors beside walks, are refused in one sentence."""
    instance = adr_opt.generate("nominal", 1, targets=5)
    _, certificate = proven(instance.with_limits(duration_s=86400.0))
    assert certificate.floors is not None
    both = certificate.replace(multipliers={"debris-1": 0.5})
    with pytest.raises(InputError, match="on walks or on floors"):
        bound_of(instance, both)
    alone = certificate.replace(floors=certificate.floors.replace(alone=True), prize_step=None)
    with pytest.raises(InputError, match="chaser is rounded down to a prize_step"):
        bound_of(instance, alone)
