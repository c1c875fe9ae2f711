"""Certificates: proofs that hold are verified, and by a program that bounds what plans collect."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from brute_force import brute_force, brute_force_campaign
from random_rules import (
    carrying,
    drifting_mission,
    filled,
    given_mission,
    mixed_campaign,
    priced,
    random_campaign,
    random_mission,
)
from test_exact import variant

import adr_opt
from adr_opt.bodies import Station, Target
from adr_opt.campaign import Campaign, problem_of
from adr_opt.certificate import Certificate, certificate_of, load_certificate
from adr_opt.chasers import Chaser
from adr_opt.connections import Connecting, Connections
from adr_opt.errors import InputError
from adr_opt.instance import Instance
from adr_opt.mission import Mission
from adr_opt.result import Result
from adr_opt.settings import MissionSettings
from adr_opt.verifying import Verdict, verify
from adr_opt.verifying.legs import legs_of
from adr_opt.verifying.rules import KNOWN, kept_apart, refuse_unknown
from adr_opt.verifying.sampling import sample_connections
from adr_opt.verifying.walks import walks_reach

INSTANCES = Path(__file__).parents[1] / "instances"
FEW = 10
"""Connections that are flown again where that is not what is tested."""

every_rule = pytest.mark.parametrize(
    ("draw", "seeds"),
    [
        *(pytest.param(random_mission, range(at, 90, 3), id=f"two-body-{at}") for at in range(3)),
        *(pytest.param(drifting_mission, range(at, 60, 3), id=f"j2-{at}") for at in range(3)),
        pytest.param(given_mission, range(60), id="given"),
        pytest.param(variant, range(30), id="prizes"),
    ],
)


def proven(instance: Instance, method: str = "exact") -> tuple[Result, Certificate]:
    """What a method proves, and its certificate, which survives being written."""
    result = adr_opt.solve(instance, method, time_limit=60.0)
    certificate = certificate_of(instance, result)
    assert Certificate.from_json(certificate.to_json()) == certificate
    return result, certificate


def verdict_of(instance: Instance, result: Result, certificate: Certificate) -> Verdict:
    return verify(instance, result.plan, certificate, connections=FEW)


@every_rule
def test_every_proof_is_verified(draw, seeds):
    """Of missions with every rule on and off, each proof is verified, with the same bound."""
    by_walks = 0
    for seed in seeds:
        instance = draw(seed)
        result, certificate = proven(instance)
        assert result.status in ("optimal", "infeasible"), seed
        verdict = verdict_of(instance, result, certificate)
        assert verdict.reasons == (), seed
        if result.upper_bound == -math.inf:
            assert verdict.upper_bound == -math.inf, seed
        else:
            assert verdict.upper_bound == pytest.approx(result.upper_bound, abs=1e-5), seed
        by_walks += bool(certificate.walks)
    assert by_walks >= len(seeds) // 6


@pytest.mark.parametrize("draw", [random_mission, drifting_mission, given_mission])
def test_whatever_walks_remember_the_best_plan_is_one_of_them(draw):
    """With any multipliers and neighbourhoods, a walk collects what brute force says, or more."""
    for seed in range(40):
        instance = draw(4000 + seed)
        mission = Mission(instance)
        prizes, _, _ = brute_force(mission)
        if not math.isfinite(prizes):
            continue
        rng = np.random.default_rng(seed)
        bodies = len(instance.names)
        legs = legs_of(instance, instance.chaser, Connecting(instance))
        worths = [Fraction(0)] * instance.first_target
        bonus = Fraction(100)
        worths += [Fraction(each.prize) + bonus * each.required for each in instance.targets]
        best = Fraction(prizes) + bonus * sum(each.required for each in instance.targets)
        multipliers = [
            Fraction(float(each)) if at >= instance.first_target else Fraction(0)
            for at, each in enumerate(rng.uniform(0.0, 1.5, bodies) * rng.integers(0, 2, bodies))
        ]
        gains = [worth - less for worth, less in zip(worths, multipliers, strict=True)]
        remembered = rng.random((bodies, bodies)) < rng.choice([0.0, 0.3, 1.0])
        slot = float(rng.choice([3.0, 20.0, 400.0]))
        # A hair less: brute force has summed prizes as floating-point numbers.
        most = best - sum(multipliers) - Fraction(1, 10**9)
        assert walks_reach(legs, gains, remembered, most, slot).reached, seed


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
        legs = legs_of(instance, instance.chaser, Connecting(instance))
        gains = [Fraction(0)] * instance.first_target
        gains += [Fraction(target.prize) for target in instance.targets]
        remembered = np.ones((len(gains), len(gains)), dtype=np.bool_)
        for off, reached in ((-1e-6, True), (1e-6, False)):
            most = Fraction(best) + Fraction(off)
            assert walks_reach(legs, gains, remembered, most, 20.0).reached == reached, seed


@pytest.mark.parametrize("draw", [random_mission, drifting_mission, given_mission])
def test_walks_that_remember_all_are_the_plans(draw):
    """Without multipliers and with full memory, no walk collects more than the best plan."""
    decided = 0
    for seed in range(40):
        instance = draw(5000 + seed)
        prizes, _, _ = brute_force(Mission(instance))
        if not math.isfinite(prizes) or any(each.required for each in instance.targets):
            continue
        legs = legs_of(instance, instance.chaser, Connecting(instance))
        gains = [Fraction(0)] * instance.first_target
        gains += [Fraction(each.prize) for each in instance.targets]
        remembered = np.ones((len(gains), len(gains)), dtype=np.bool_)
        more = Fraction(prizes) + Fraction(1, 10**4)
        assert not walks_reach(legs, gains, remembered, more, 20.0).reached, seed
        decided += prizes < sum(gains)
    assert decided > 10


def apart(seed: int) -> Instance:
    """A campaign whose chasers are launched anywhere, and at least so long apart."""
    drawn = random_campaign(seed)
    chasers = (
        chaser.replace(start="anywhere", tank=filled(chaser.tank)) for chaser in drawn.chasers
    )
    rest_s = float(np.random.default_rng([14, seed]).uniform(0.0, 0.6)) * drawn.mission.duration_s
    mission = drawn.mission.replace(launch_separation_s=rest_s)
    return drawn.replace(chasers=tuple(chasers), mission=mission)


def weighed(seed: int) -> Instance:
    """A mission by expense, of a chaser that starts in an orbit with some of its propellant."""
    return priced(random_mission(seed), seed)


def test_windows_of_launches_are_those_of_the_instance():
    """Launches that lie apart may be when the instance says, worked out once more."""
    for seed in range(60):
        instance = apart(seed)
        windows = tuple(chaser.available_s for chaser in kept_apart(instance))
        assert windows == instance.available_s


@pytest.mark.parametrize(
    ("draw", "least"),
    [
        (random_campaign, 1.0),
        (apart, 0.5),
        (weighed, 0.5),
        (mixed_campaign, 0.5),
        (lambda seed: random_campaign(seed, drifting_mission), 0.9),
        (lambda seed: carrying(random_mission(seed), seed), 0.2),
    ],
    ids=["alike", "apart", "weighed", "mixed", "j2", "launched"],
)
def test_bounds_of_campaigns_are_verified(draw, least):
    """The bound before the last packing is verified and holds; where it is the last, all is."""
    asked = whole = 0
    for seed in range(18):
        instance = draw(seed)
        found = adr_opt.solve(instance, "exact", time_limit=60.0)
        if found.status in ("infeasible", "optimal") and found.evidence is None:
            continue  # found by going through all sets of a few targets, which is no evidence
        asked += 1
        result, certificate = proven(instance)
        verdict = verdict_of(instance, result, certificate)
        problem = problem_of(instance)
        if isinstance(problem, Campaign):
            prizes, _ = brute_force_campaign(problem)
        else:
            prizes, _, _ = brute_force(problem)
        assert verdict.upper_bound >= prizes - 1e-9, seed
        assert verify(instance, None, certificate, connections=FEW).verified, seed
        whole += verdict.verified
        if not verdict.verified:
            assert certificate.upper_bound > result.upper_bound, seed
    assert asked > 3
    assert whole >= least * asked


@pytest.mark.parametrize("iterations", [1, 2, 3, 6])
def test_bounds_of_proofs_cut_short_are_verified(iterations):
    """After any number of iterations what the bound rests on is known, and verified."""
    for seed in range(12):
        instance = variant(seed)
        for run, method in ((adr_opt.bound, "lagrangian"), (adr_opt.solve, "auto")):
            result = run(instance, method, time_limit=60.0, iterations=iterations)
            if result.upper_bound == math.inf and result.status != "optimal":
                continue  # nothing was proven
            certificate = certificate_of(instance, result)
            stated = min(result.upper_bound, sum(each.prize for each in instance.targets))
            assert certificate.upper_bound == pytest.approx(stated, rel=1e-6), seed
            assert verdict_of(instance, result, certificate).reasons == (), seed


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
    with pytest.raises(InputError, match="has proven nothing"):
        certificate_of(instance, result)
    with pytest.raises(InputError, match="does not say what its bound rests on"):
        certificate_of(instance, replace(result, upper_bound=7.0))


def test_every_field_of_an_instance_is_known():
    """A new field of an instance is refused until the verifier has been taught what it means."""
    for kind in (Instance, Station, Target, Chaser, MissionSettings):
        assert KNOWN[kind] == set(kind.model_fields), kind.__name__


def test_what_cannot_be_verified_yet_is_refused(monkeypatch):
    """Fields and ways to remove targets that nobody knows are one sentence."""
    instance = adr_opt.generate("tiny", 0)
    _, certificate = proven(instance)
    known = {**KNOWN, Target: KNOWN[Target] - {"required"}}
    targets = (instance.targets[0].replace(required=True), *instance.targets[1:])
    changed = instance.replace(targets=targets)
    certificate = certificate.replace(
        instance=certificate.instance.replace(sha256=changed.sha256), plan_sha256=None
    )
    monkeypatch.setattr("adr_opt.verifying.rules.KNOWN", known)
    with pytest.raises(InputError, match="not yet verifiable: a target with a field required"):
        verify(changed, None, certificate)
    monkeypatch.undo()
    strange = instance.targets[0].model_copy(update={"removal": "net"})
    caught = instance.model_copy(update={"targets": (strange, *instance.targets[1:])})
    with pytest.raises(InputError, match=f"not yet verifiable: '{strange.name}' has .* 'net'"):
        refuse_unknown(caught)


class Spoilt(Connecting):
    """Connections some of which are missing, or cheaper than they are."""

    def __init__(self, instance: Instance, missing: float, cheaper_m_s: float) -> None:
        super().__init__(instance)
        self._missing, self._cheaper = missing, cheaper_m_s

    def of_pair(self, i: int, j: int, resolution_m_s: float) -> Connections:
        """What is left of a pair."""
        found = super().of_pair(i, j, resolution_m_s)
        kept = np.random.default_rng([i, j]).random(found.departure.size) >= self._missing
        return Connections(
            found.departure[kept], found.arrival[kept], found.delta_v[kept] - self._cheaper,
            found.revolutions[kept],
        )  # fmt: skip


@pytest.mark.parametrize("draw", [random_mission, drifting_mission, given_mission])
def test_connections_are_those_of_check(draw):
    """All that are drawn can be flown, none is missing; spoilt ones are found out."""
    found_missing = found_cheaper = looked_at = 0
    for seed in range(24):
        instance = draw(seed)
        whole = sample_connections(instance, Connecting(instance), 100, seed)
        assert whole.faults == (), seed
        looked_at += whole.departures
        fewer = sample_connections(instance, Spoilt(instance, 0.7, 0.0), 60, seed)
        found_missing += any(fault.startswith("no connection") for fault in fewer.faults)
        cheaper = sample_connections(instance, Spoilt(instance, 0.0, 1e-3), 60, seed)
        found_cheaper += any("cannot be flown" in fault for fault in cheaper.faults)
    assert looked_at > 40
    assert found_missing > 7
    assert found_cheaper > 10


def test_a_certificate_over_spoilt_connections_is_refused(monkeypatch):
    """If connections are not those that `check` knows, a bound is refused that would follow."""
    instance = variant(1)
    result, certificate = proven(instance)
    assert certificate.walks
    monkeypatch.setattr(
        "adr_opt.verifying.verdict.Connecting", lambda of: Spoilt(of, missing=0.8, cheaper_m_s=0.0)
    )
    assert "no connection from" in verify(instance, result.plan, certificate).reasons[0]


def test_packed_and_plain_files_are_the_same(tmp_path):
    """A certificate is read back as it was written, packed or not."""
    _, certificate = proven(variant(2))
    for name in ("c.json", "c.json.gz"):
        certificate.save(tmp_path / name)
        assert load_certificate(tmp_path / name) == certificate
    assert (tmp_path / "c.json.gz").read_bytes()[:2] == b"\x1f\x8b"


def test_a_proof_of_the_library_is_verified():
    """A proof of a field of 50 targets is verified."""
    instance = adr_opt.load(INSTANCES / "nominal" / "nominal-001.json")
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
