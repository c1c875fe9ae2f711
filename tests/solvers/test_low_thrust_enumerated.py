"""Missions of low thrust against enumeration with exact masses."""

from __future__ import annotations

import math
from typing import Any

import pytest
from electric_fields import Enumerated, electric
from seeds import over_kinds

import adr_opt
from adr_opt.judge.check.verdict import check
from adr_opt.judge.verify import verify
from adr_opt.mission.certify import certificate_of
from adr_opt.problem.instance import instance_of

KINDS = {
    "alone": ({}, range(60), 3),
    "kits": ({"kits": True}, range(100, 140), 1),
    "tows": ({"tows": True}, range(300, 340), 3),
    "coarse": ({"resolution_m_s": 20.0}, range(400, 440), 2),
    "two": ({"chasers": 2}, range(200, 230), 1),
    "free": ({"free": True}, range(500, 540), 3),
}


@over_kinds("options, seeds", **KINDS)
def test_plans_and_bounds_include_the_optimum(options: dict[str, Any], seeds: range):
    """Plans are legal and collect no more, and bounds no less, than enumeration with exact masses.

    In which a chaser may vent propellant, and fly a leg as a heavier one. Some plans have legs of
    lighter classes.
    """
    closed = some = lighter = 0
    for seed in seeds:
        instance = electric(seed, **options)
        best = Enumerated(instance).best()
        result = adr_opt.solve(instance, time_limit=math.inf, iterations=40)
        assert result.plan is not None, seed
        assert not list(check(instance, result.plan)), seed
        assert result.objective <= best <= result.upper_bound, seed
        bound = adr_opt.bound(instance, time_limit=math.inf, iterations=40)
        assert bound.upper_bound >= best, seed
        closed += result.status == "optimal"
        lighter += any(leg.mass_class_kg for leg in result.plan.legs)
        some += 0.0 < best < sum(target.prize for target in instance.targets)
    assert closed > 0.5 * len(seeds)
    assert some > 0.3 * len(seeds)
    # A leg of the coarse ones hardly saves as much as their resolution.
    assert lighter > 0 or options.get("resolution_m_s", 0.0) > 10.0


@pytest.mark.parametrize("method", ["greedy", "beam", "local-search", "ortools", "exact"])
def test_methods_plan_low_thrust(method: str):
    """Every kind of method has a legal plan; what it says is proven is, whatever the mass."""
    instance = electric(3)
    result = adr_opt.solve(instance, method, time_limit=1.0)
    assert result.plan is not None
    assert not list(check(instance, result.plan))
    assert result.objective <= Enumerated(instance).best() <= result.upper_bound


@pytest.mark.slow
def test_certificates_of_low_thrust_are_verified():
    """A bound on legs of the lightest chaser is verified with these legs."""
    verified = 0
    for seed in range(6):
        instance = electric(seed, targets=5)
        result = adr_opt.solve(instance, time_limit=math.inf, iterations=40)
        if result.evidence is None or not result.evidence.walks:
            continue
        verdict = verify(instance, result.plan, certificate_of(instance, result), connections=20)
        assert not verdict.reasons, seed
        verified += verdict.labels > 0
    assert verified > 1


@pytest.mark.slow
def test_fleets_of_both_kinds():
    """A campaign of an electric chaser and a chemical one has legs of both kinds, and bounds."""
    kinds = set()
    for seed in range(200, 208):
        content = electric(seed, chasers=2).model_dump(mode="json")
        chemical = content["chasers"][1]
        del chemical["thrust_n"], chemical["duty_cycle"]
        chemical["tank"]["isp_s"] = 300.0
        instance = instance_of(content)
        result = adr_opt.solve(instance, time_limit=math.inf, iterations=20)
        assert result.plan is not None
        assert not list(check(instance, result.plan)), seed
        assert result.objective <= result.upper_bound
        kinds |= {leg.kind for leg in result.plan.legs}
        alone = instance.replace(chasers=instance.chasers[:1])
        assert (
            result.objective >= adr_opt.solve(alone, time_limit=math.inf, iterations=20).objective
        )
        assert result.upper_bound >= Enumerated(alone).best()
    assert "low-thrust" in kinds
    assert len(kinds) > 1


def test_what_is_proven_of_a_margin_is_not_said_of_all_plans():
    """With a reserve the result has a bound, and the plan none; progress hears only that bound."""
    instance = electric(3)
    heard: list[tuple[float, float]] = []
    result = adr_opt.solve(
        instance,
        time_limit=math.inf,
        iterations=20,
        margin=0.3,
        progress=lambda known, bound: heard.append((known, bound)),
    )
    assert result.plan is not None
    total = sum(target.prize for target in instance.targets)
    assert result.objective < total
    assert math.isfinite(result.upper_bound)
    assert result.plan.upper_bound is None
    assert any("collects more than" in note for note in result.notes)
    assert all(known <= bound + 1e-9 for known, bound in heard)
    bounds = [bound for _, bound in heard if math.isfinite(bound)]
    assert min(bounds) == pytest.approx(result.upper_bound, abs=1.0)
