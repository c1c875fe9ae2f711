"""Certificates where masses count: kits, tows, tanks by mass, and stations that run empty."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from brute_force import brute_force_campaign
from random_rules import limited, towing_mission
from seeds import over_kinds
from verify_fields import laden, legs_for, proven, refuelling, towing_and_laden, worths_of

import adr_opt
from adr_opt.common.constants import SLACK_M_S
from adr_opt.common.errors import InputError
from adr_opt.judge.check.tank import TankLevel
from adr_opt.judge.verify import verify
from adr_opt.judge.verify.cargo import Cargo, left_after
from adr_opt.judge.verify.claim import bound_of
from adr_opt.judge.verify.names import check_names
from adr_opt.judge.verify.walk_questions import walk_question, walks_reach
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.evidence import Evidence, Walks
from adr_opt.mission.problem import Problem
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.instance import Instance


def running_empty(seed: int) -> Instance:
    """A chaser that refuels at stations that run empty, and launches that lie apart."""
    made = refuelling(seed)
    return limited(made.replace(targets=made.targets[:4]), seed)


def scarce(seed: int) -> Instance:
    """Two chasers who share one or two refuellings at each station."""
    made, rng = refuelling(seed), np.random.default_rng([16, seed])
    return made.replace(
        stations=tuple(
            each.replace(max_refuellings=int(rng.integers(1, 3))) for each in made.stations
        ),
        chasers=tuple(made.chaser.replace(name=f"chaser-{number}") for number in (1, 2)),
        targets=tuple(
            each.replace(
                prize=float(rng.choice([1.0, 1.5, 2.0])), window_s=(0.0, None), required=False
            )
            for each in made.targets
        ),
    )


@pytest.mark.parametrize(
    ("draw", "seeds", "least_paid"),
    [
        (running_empty, range(0, 16, 2), 0),
        (scarce, [0, 1, 2, 3, 30, 43], 1),
        pytest.param(running_empty, range(0, 40, 2), 0, marks=pytest.mark.slow),
        pytest.param(scarce, [*range(12), 30, 43], 3, marks=pytest.mark.slow),
    ],
)
def test_bounds_where_stations_run_empty_are_verified(draw, seeds, least_paid):
    """The bound before the last packing is verified and holds, refuellings paid for or not."""
    count = paid = 0
    for seed in seeds:
        instance = draw(seed)
        _, certificate = proven(instance)
        if certificate is None:
            continue
        verdict = verify(instance, None, certificate, connections=0)
        assert verdict.verified, seed
        assert verdict.upper_bound >= brute_force_campaign(Problem(instance))[0] - 1e-9, seed
        count += bool(certificate.walks)
        paid += any(station.name in certificate.multipliers for station in instance.stations)
    assert count > 0.43 * len(seeds)
    assert paid >= least_paid


def test_multipliers_of_stations_count_as_often_as_there_are_refuellings():
    """Who writes and who verifies add up the same, also where a packing has proven less."""
    drawn = adr_opt.generate("tiny", 0)
    instance = drawn.replace(stations=(drawn.stations[0].replace(max_refuellings=3),))
    multipliers = np.zeros(len(instance.names))
    multipliers[0] = 0.5
    walks = Walks((0,), 1.0, np.zeros((multipliers.size, multipliers.size), dtype=np.bool_))
    result = replace(
        adr_opt.solve(instance, "greedy"),
        upper_bound=1.0,
        evidence=Evidence(multipliers, (walks,), 20.0),
    )
    certificate = certificate_of(instance, result)
    assert certificate.upper_bound == bound_of(instance, certificate) == 2.0
    unrounded = certificate.replace(prize_step=None)
    assert bound_of(instance, unrounded) == pytest.approx(2.5, rel=1e-15)
    with pytest.raises(InputError, match=r"'station' is neither a target .* with max_refuellings"):
        check_names(
            drawn, certificate.replace(instance=certificate.instance.replace(sha256=drawn.sha256))
        )


@over_kinds("seeds", drawn=(range(60), 20))
def test_whatever_refuellings_cost_the_best_plan_is_worth_no_more_than_follows(seeds):
    """With any multipliers of stations, what the best plan collects is below no bound."""
    count = 0
    for seed in seeds:
        instance = running_empty(seed)
        prizes, _ = brute_force_campaign(Problem(instance))
        often = {each.name: each.max_refuellings for each in instance.stations}
        if not math.isfinite(prizes) or all(each is None for each in often.values()):
            continue
        rng, worths = np.random.default_rng(seed), worths_of(instance, Fraction(0))
        remembered = rng.random((len(worths), len(worths))) < rng.choice([0.0, 1.0])
        most, gains = Fraction(prizes) - Fraction(1, 10**9), list(worths)
        for body, limit in enumerate(often.values()):
            if limit is not None:
                gains[body] -= Fraction(float(rng.uniform(0.0, 2.0)))
                most += limit * gains[body]
        assert walks_reach(
            walk_question(legs_for(instance), gains, remembered, most, 20.0)
        ).reached, seed
        count += 1
    assert count > len(seeds) / 3


@pytest.mark.slow
def test_walks_that_are_said_to_collect_less_are_refused():
    """A bound below what brute force finds is refused, with whatever numbers it is claimed."""
    refused = 0
    for seed in range(32):
        instance = (laden, towing_mission, towing_and_laden, refuelling)[seed % 4](seed)
        result, certificate = proven(instance)
        if certificate is None or not certificate.walks or not result.objective:
            continue
        (walks,) = certificate.walks
        rng = np.random.default_rng(seed)
        least = min(target.prize for target in instance.targets if target.prize > 0.0)
        less = float(rng.uniform(0.5, 2.0)) * least + certificate.upper_bound - result.objective
        names = instance.names
        for remembered in (walks.neighbourhoods, {name: names for name in names}):
            forged = certificate.replace(
                walks=(walks.replace(most=walks.most - less, neighbourhoods=remembered),),
                upper_bound=max(0.0, certificate.upper_bound - less),
                delta_v_slot_m_s=float(rng.choice([3.0, 20.0, 400.0])),
            )
            verdict = verify(instance, None, forged, connections=0)
            assert not verdict.verified, seed
        refused += 1
    assert refused > 8


def test_services_leave_what_masses_say():
    """What is left after kits, tows and legs is what `check` finds from the masses themselves."""
    kits_left = tows = 0
    for seed in range(120):
        instance = towing_and_laden(seed)
        chaser, rng = instance.chaser, np.random.default_rng(seed)
        if not isinstance(chaser.tank, TankByMass) or chaser.kit_mass_kg == 0.0:
            continue
        legs = legs_for(instance)
        cargo, removals = legs.terms.cargo, [target.removal for target in instance.targets]
        kits = cargo.full.size - 1
        tank = TankLevel(chaser, kits)
        left = float(cargo.begun[kits])
        objects = {target.name: target.mass_kg for target in instance.targets}
        for body, removal in enumerate(removals, start=instance.first_target):
            assert left - SLACK_M_S == pytest.approx(tank.left_m_s, rel=1e-9, abs=1e-7)
            delta_v = 0.3 * float(rng.random()) * max(tank.left_m_s, 0.0)
            tank.burn(delta_v)
            left -= delta_v
            if removal == "tow":
                tank.tow(delta_v_of_tow(instance, body), float(objects[instance.names[body]] or 0))
                left = left_on(cargo, body, kits, left)
                if left < 0.0:
                    assert tank.left_m_s < -SLACK_M_S
                    break
                tows += 1
            elif removal == "kit" and kits and tank.left_m_s > 0.0:
                tank.leave_kit()
                left, kits = left_on(cargo, body, kits, left), kits - 1
                kits_left += 1
    assert kits_left > 20
    assert tows > 20


def left_on(cargo: Cargo, body: int, kits: int, left: float) -> float:
    """What the verifier says is left after one service [m/s]."""
    return float(left_after(cargo, np.array([body]), np.array([kits]), np.array([left]))[0])


def delta_v_of_tow(instance: Instance, body: int) -> float:
    """Of half an ellipse between the circle of an object and the disposal orbit [m/s]."""
    orbit = instance.known_orbits[body]
    assert orbit is not None
    high, low = orbit.semi_major_axis_m, 6378137.0 + instance.mission.disposal.circle_m
    mu, axis = 398600.4418e9, 0.5 * (high + low)
    slower = math.sqrt(mu / high) - math.sqrt(mu * (2.0 / high - 1.0 / axis))
    return slower + math.sqrt(mu * (2.0 / low - 1.0 / axis)) - math.sqrt(mu / low)


@pytest.mark.slow
def test_a_proof_with_heavy_kits_is_verified():
    """So is that of a campaign of launches, with 16 of the rocket bodies of the family."""
    instance = adr_opt.generate("removal", 0, targets=16, chasers=2)
    result, certificate = proven(instance)
    assert result.status == "optimal"
    assert certificate is not None
    assert certificate.walks
    verdict = verify(instance, result.plan, certificate, connections=100)
    assert verdict.reasons == ()
    assert verdict.upper_bound == result.upper_bound


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_proofs_of_the_removal_family_are_verified(seed):
    """The bound before the last packing is verified, and the plan where that bound is its own."""
    instance = adr_opt.generate("removal", seed)
    result = adr_opt.solve(instance, "auto", time_limit=200.0)
    certificate = certificate_of(instance, result)
    assert verify(instance, None, certificate).reasons == ()
    verdict = verify(instance, result.plan, certificate)
    assert verdict.verified == (certificate.upper_bound == pytest.approx(result.upper_bound))
