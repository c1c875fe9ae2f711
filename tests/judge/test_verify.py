"""Certificates: proofs that hold are verified, and by a program that bounds what plans collect."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from random_rules import (
    captured_mission,
    drifting_mission,
    falling_campaign,
    falling_mission,
    freely,
    given_mission,
    launched_mission,
    mixed_campaign,
    random_campaign,
    random_mission,
    towing_mission,
)
from seeds import over_kinds, over_seeds
from varied_fields import variant
from verify_fields import (
    FEW,
    Spoilt,
    apart,
    campaign_with_cargo,
    laden,
    most_collected,
    proven,
    refuelling,
    towing_and_laden,
    weighed,
)

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.judge.verify import Verdict, verify
from adr_opt.judge.verify.rules import kept_apart
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.result import Result
from adr_opt.plan.certificate import Certificate, load_certificate
from adr_opt.problem.instance import Instance

INSTANCES = Path(__file__).parents[2] / "instances"

every_rule = over_kinds(
    "draw, share, seeds",
    two_body=(random_mission, 0.5, range(60), 5),
    j2=(drifting_mission, 0.4, range(40), 3),
    given=(given_mission, 0.15, range(40), 5),
    prizes=(variant, 0.5, range(30), 3),
    windows=(captured_mission, 0.2, range(60), 4),
    free=(lambda seed: freely(random_mission(seed), seed), 0.5, range(16), 2),
    launched=(lambda seed: launched_mission(2 * seed), 0.3, range(30), 2),
    free_j2=(lambda seed: freely(drifting_mission(seed), seed), 0.4, range(16), 2),
    **{
        draw.__name__: (draw, 0.3, range(16), 3)
        for draw in (laden, towing_mission, towing_and_laden, refuelling, falling_mission)
    },
)
"""Fields with every rule on and off, and the share of proofs that rest on walks, at least."""


def verdict_of(instance: Instance, result: Result, certificate: Certificate) -> Verdict:
    return verify(instance, result.plan, certificate, connections=FEW)


@every_rule
def test_every_proof_is_verified(draw, share, seeds):
    """Of missions with every rule on and off, each proof is verified, with the same bound."""
    by_walks = 0
    for seed in seeds:
        instance = draw(seed)
        result, certificate = proven(instance)
        assert result.status in ("optimal", "infeasible"), seed
        if certificate is None:
            continue
        verdict = verdict_of(instance, result, certificate)
        assert verdict.reasons == (), seed
        everything = math.fsum(each.greatest_prize for each in instance.targets)
        stated = min(result.upper_bound, everything)
        assert verdict.upper_bound == pytest.approx(stated, abs=1e-5), seed
        by_walks += bool(certificate.walks)
    assert by_walks >= share * len(seeds)


def test_windows_of_launches_are_those_of_the_instance():
    """Launches that lie apart may be when the instance says, worked out once more."""
    for seed in range(60):
        instance = apart(seed)
        windows = tuple(chaser.available_s for chaser in kept_apart(instance))
        assert windows == instance.available_s


@over_kinds(
    "draw, least, seeds",
    alike=(random_campaign, 1.0, range(12), 3),
    apart=(apart, 0.5, range(12), 3),
    weighed=(weighed, 0.5, range(12), 3),
    mixed=(mixed_campaign, 0.5, range(12), 3),
    j2=(lambda seed: random_campaign(seed, drifting_mission), 0.9, range(12), 3),
    cargo=(campaign_with_cargo, 0.8, range(12), 3),
    falls=(falling_campaign, 0.5, range(12), 3),
)
def test_bounds_of_campaigns_are_verified(draw, least, seeds):
    """The bound before the last packing is verified and holds; where it is the last, all is."""
    asked = whole = 0
    for seed in seeds:
        instance = draw(seed)
        result, certificate = proven(instance)
        if certificate is None:
            continue
        asked += 1
        verdict = verdict_of(instance, result, certificate)
        assert verdict.upper_bound >= most_collected(instance) - 1e-9, seed
        assert verify(instance, None, certificate, connections=FEW).verified, seed
        whole += verdict.verified
        if not verdict.verified:
            assert certificate.upper_bound > result.upper_bound, seed
    assert asked > len(seeds) / 6
    assert whole >= least * asked


@pytest.mark.parametrize("iterations", [1, 2, 3, 6])
@over_seeds(range(12), gate=3)
def test_bounds_of_proofs_cut_short_are_verified(iterations, seed):
    """After any number of iterations what the bound rests on is known, and verified."""
    instance = variant(seed)
    for run, method in ((adr_opt.bound, "lagrangian"), (adr_opt.solve, "auto")):
        result = run(instance, method, time_limit=60.0, iterations=iterations)
        if result.upper_bound == math.inf and result.status != "optimal":
            continue  # nothing was proven
        certificate = certificate_of(instance, result)
        stated = min(result.upper_bound, sum(each.prize for each in instance.targets))
        assert certificate.upper_bound == pytest.approx(stated, rel=1e-6)
        assert verdict_of(instance, result, certificate).reasons == ()


def test_a_bound_beside_a_planner_brings_its_evidence():
    """What a bound proves beside another planner is certified with the plan of that one."""
    instance = variant(3)
    result = adr_opt.solve(instance, "beam", bound="exact", time_limit=60.0)
    assert result.status == "optimal"
    verdict = verdict_of(instance, result, certificate_of(instance, result))
    assert verdict.verified
    assert verdict.gap == 0.0


def test_who_does_not_say_what_a_bound_rests_on_gets_no_certificate():
    """A bound without evidence, or no bound at all, is refused in one sentence."""
    instance = adr_opt.generate("tiny", 0, targets=8)
    result = adr_opt.solve(instance, "greedy")
    with pytest.raises(InputError, match="has proven no bound"):
        certificate_of(instance, result)
    with pytest.raises(InputError, match="gives no evidence for its bound"):
        certificate_of(instance, replace(result, upper_bound=7.0))


def test_a_certificate_over_spoilt_connections_is_refused(monkeypatch):
    """If connections are not those that `check` knows, a bound is refused that would follow."""
    instance = variant(1)
    result, certificate = proven(instance)
    assert certificate.walks
    monkeypatch.setattr(
        "adr_opt.judge.verify.verdict.ConnectionFinder",
        lambda of, **_: Spoilt(of, missing=0.8, cheaper_m_s=0.0),
    )
    assert "no connection from" in verify(instance, result.plan, certificate).reasons[0]


def test_packed_and_plain_files_are_the_same(tmp_path):
    """A certificate is read back as it was written, packed or not."""
    _, certificate = proven(variant(2))
    for name in ("c.json", "c.json.gz"):
        certificate.save(tmp_path / name)
        assert load_certificate(tmp_path / name) == certificate
    assert (tmp_path / "c.json.gz").read_bytes()[:2] == b"\x1f\x8b"


@pytest.mark.slow
def test_a_proof_of_the_library_is_verified():
    """A proof of a field of 50 targets is verified."""
    instance = adr_opt.load(INSTANCES / "nominal" / "nominal-000.json")
    result, certificate = proven(instance)
    assert result.status == "optimal"
    verdict = verify(instance, result.plan, certificate)
    assert verdict.reasons == ()
    assert verdict.upper_bound == result.upper_bound
    assert verdict.connections == 1000


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(INSTANCES.glob("nominal/*.json")), ids=lambda p: p.stem)
def test_all_nominal_proofs_are_verified(path):
    """So are those of all nominal fields."""
    instance = adr_opt.load(path)
    result = adr_opt.solve(instance, "exact", time_limit=300.0)
    assert verify(instance, result.plan, certificate_of(instance, result)).reasons == ()
