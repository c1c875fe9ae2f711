"""What is called optimal is the best plan to the last unit of prize, at any size of prizes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from brute_force import brute_force, brute_force_campaign
from calling import call
from nasty_prizes import KINDS, with_prizes
from random_rules import random_campaign
from seeds import over_kinds, over_seeds
from varied_fields import varied

import adr_opt
from adr_opt.common.errors import InputError, MissingExtra
from adr_opt.common.stop import MaxRuntime
from adr_opt.judge.verify import verify
from adr_opt.mission.certified import certify
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result
from adr_opt.problem.instance import Instance
from adr_opt.run.methods import BOUNDS, PLANNERS, get, spec

LIMIT_S = 30.0

all_kinds = pytest.mark.parametrize("kind", KINDS)
some_seeds = over_kinds("seeds", drawn=(range(25), 2))


def drawn(kind: str, seed: int) -> Instance:
    """A tiny mission of random limits with such prizes; of every other one some are required."""
    rng = np.random.default_rng(seed)
    days, delta_v_m_s = float(rng.uniform(0.7, 2.0)), float(rng.uniform(300.0, 1000.0))
    instance = varied(seed, targets=6, days=days, delta_v_m_s=delta_v_m_s)
    return with_prizes(instance, kind, seed, required=seed % 3 if seed % 2 else 0)


def planned(instance: Instance, method: str) -> Result:
    """What a method makes of an instance on one core."""
    jobs = {"jobs": 1} if spec(method).uses_cores else {}
    return adr_opt.solve(instance, method=method, stop=MaxRuntime(LIMIT_S), **jobs)


def hold(instance: Instance, result: Result, best: float, case: object) -> None:
    """Hold a result against the best there is: all that is said is true to the last unit."""
    assert result.upper_bound >= best, case
    assert (result.status == "infeasible") <= (best == -math.inf), case
    if result.plan is None:
        return
    assert adr_opt.check(instance, result.plan) == (), case
    assert result.objective <= best, case
    if result.status == "optimal":
        # Prizes without a step count as equal to a share of their sum, of which little may be had.
        total = math.fsum(target.prize for target in instance.targets)
        slack = 2e-11 * total / best if best > 0.0 else 0.0
        assert (result.objective, result.gap) == (best, pytest.approx(0.0, abs=slack)), case


@all_kinds
@some_seeds
def test_missions_equal_enumeration(kind: str, seeds: range) -> None:
    """Exact proofs find the best prizes and prove them, and their certificates are verified."""
    for seed in seeds:
        instance = drawn(kind, seed)
        best, _, _ = brute_force(Mission(instance, threads=1))
        for method in ("exact", "auto"):
            result = planned(instance, method)
            assert result.status == ("optimal" if best > -math.inf else "infeasible"), (
                seed,
                method,
            )
            hold(instance, result, best, (seed, method))
            verdict = verify(instance, result.plan, certificate_of(instance, result), connections=5)
            assert verdict.reasons == (), (seed, method)
            assert verdict.upper_bound == pytest.approx(result.upper_bound, rel=1e-10), seed
            if result.plan is not None:
                assert verdict.gap == 0.0, (seed, method)


@all_kinds
@some_seeds
def test_campaigns_equal_enumeration(kind: str, seeds: range) -> None:
    """So do those of several chasers, and where there is a certificate it is verified."""
    for seed in seeds:
        instance = random_campaign(seed)
        required = min(2, sum(target.required for target in instance.targets))
        instance = with_prizes(instance, kind, seed, required=required)
        best, _ = brute_force_campaign(Problem(instance))
        result = planned(instance, "exact")
        assert result.status == ("optimal" if best > -math.inf else "infeasible"), seed
        hold(instance, result, best, seed)
        try:
            certificate = certificate_of(instance, result)
        except InputError:  # the last step of the proof went through all sets of targets
            continue
        assert verify(instance, None, certificate, connections=5).reasons == (), seed
        # Enumeration adds prizes one by one, and so may be a last digit above their sum.
        least = best - 2.0**-48 * abs(best)
        assert certificate.upper_bound is None or certificate.upper_bound >= least, seed


@all_kinds
@pytest.mark.parametrize(
    "method", ["lagrangian", "routing-bound", pytest.param("mip", marks=pytest.mark.slow)]
)
@over_seeds(range(3), gate=1)
def test_no_method_states_too_much(kind: str, method: str, seed: int) -> None:
    """Bounds are not below the best plan by a single unit, and what is optimal is the best."""
    function = get(method, PLANNERS if method == "mip" else BOUNDS)
    instance = drawn(kind, seed)
    mission = Mission(instance, threads=1)
    best, _, sequence = brute_force(mission)
    more = {"start": sequence} if best > -math.inf else {}
    try:
        result = call(function, mission, stop=MaxRuntime(3.0), **more)
    except MissingExtra as missing:
        pytest.skip(str(missing))
    hold(instance, result, best, seed)


def test_a_large_prize_hides_no_visit() -> None:
    """Of one prize of ten million and some of 1, all that can be collected is."""
    instance = adr_opt.generate("tiny", 7)
    for number in (0, 5):
        targets = list(instance.targets)
        targets[number] = targets[number].replace(prize=1e7)
        nasty = instance.replace(targets=tuple(targets))
        best, _, _ = brute_force(Mission(nasty, threads=1))
        result = planned(nasty, "exact")
        assert (result.status, result.objective, result.upper_bound) == ("optimal", best, best)


def test_check_and_verify_tell_optimal_to_the_unit() -> None:
    """A plan that lacks two units of ten million is not optimal, to whoever reads its file."""
    instance = adr_opt.generate("tiny", 7)
    targets = list(instance.targets)
    targets[0] = targets[0].replace(prize=1e7)
    nasty = instance.replace(targets=tuple(targets))
    best = planned(nasty, "exact")
    certificate = certificate_of(nasty, best)
    assert best.sequence is not None
    mission = Mission(nasty)
    worse = next(
        result
        for result in (
            certify(
                mission,
                "x",
                best.sequence[:at],
                seed=0,
                runtime_s=0.0,
                upper_bound=best.upper_bound,
            )
            for at in range(len(best.sequence))
        )
        if result.objective == best.objective - 2.0
    )
    assert worse.status == "feasible"
    lying = worse.plan.replace(status="optimal")
    assert [fault.rule for fault in adr_opt.check(nasty, lying)] == ["status"]
    lying = worse.plan.replace(status="optimal", upper_bound=worse.objective, gap=0.0)
    assert adr_opt.check(nasty, lying) == ()  # figures agree, but it is not what was proven
    verdict = verify(nasty, lying, certificate.replace(plan_sha256=None), connections=5)
    assert any("the plan states the bound" in reason for reason in verdict.reasons)
    assert any("claims to be optimal" in reason for reason in verdict.reasons)


@pytest.mark.parametrize("method", ["greedy", "exact", "auto", "beam", "local-search"])
def test_all_collected_is_a_bound(method: str) -> None:
    """Whatever the method: where all is collected the bound is the sum of prizes, the gap 0."""
    instance = varied(0, targets=3, days=3.0, delta_v_m_s=1e6)
    instance = instance.replace(
        targets=tuple(
            target.replace(prize=prize)
            for target, prize in zip(instance.targets, (0.1, 0.2, 0.4), strict=True)
        )
    )
    result = adr_opt.solve(instance, method=method, time_limit=60.0)
    total = math.fsum((0.1, 0.2, 0.4))
    assert (result.status, result.objective) == ("optimal", total)
    assert (result.upper_bound, result.gap) == (total, 0.0)
    assert (result.plan.upper_bound, result.plan.gap) == (total, 0.0)
    assert adr_opt.check(instance, result.plan) == ()


@pytest.mark.parametrize("prize", [1e12, 4e-12])
@pytest.mark.parametrize("delta_v_m_s", [1e-9, 1.0, 1e9])
def test_certificates_of_the_largest_and_least_are_accepted(
    prize: float, delta_v_m_s: float
) -> None:
    """Own certificates are verified at prizes and tanks at the limits of the format."""
    instance = varied(1, prizes=(prize, 0.75 * prize), delta_v_m_s=delta_v_m_s, targets=4)
    for method in ("exact", "auto"):
        result = planned(instance, method)
        verdict = verify(instance, result.plan, certificate_of(instance, result), connections=5)
        assert verdict.reasons == (), method
        assert result.status == "optimal"
