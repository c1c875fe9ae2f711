"""Certificates where masses count: kits, tows, tanks by mass, and stations that run empty."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from brute_force import brute_force, brute_force_campaign
from random_rules import (
    carrying,
    drifting_mission,
    given_field,
    limited,
    mixed_campaign,
    random_campaign,
    random_mission,
    towing,
    towing_mission,
)

import adr_opt
from adr_opt.campaign import Campaign, problem_of
from adr_opt.certificate import Certificate, certificate_of
from adr_opt.chasers import AtStation, TankByMass
from adr_opt.checking.tank import Tank
from adr_opt.connections import Connecting
from adr_opt.errors import InputError
from adr_opt.evidence import Evidence, Walks
from adr_opt.instance import Instance
from adr_opt.kernels.constants import SLACK_M_S
from adr_opt.mission import Mission
from adr_opt.verifying import verify
from adr_opt.verifying.cargo import after_service
from adr_opt.verifying.claim import bound_of, check_names
from adr_opt.verifying.legs import Legs, legs_of
from adr_opt.verifying.rules import kept_apart
from adr_opt.verifying.sampling import sample_connections
from adr_opt.verifying.walks import walks_reach

DAY_S = 86400.0
FEW = 10
"""Connections that are flown again."""


def laden(seed: int) -> Instance:
    """A mission with kits, by turns in two-body motion, under J2 and over given connections."""
    draw = (random_mission, drifting_mission, given_field)[seed % 3]
    return carrying(draw(seed), seed)


def towing_and_laden(seed: int) -> Instance:
    """A mission with tows and kits."""
    return towing(carrying((random_mission, drifting_mission)[seed % 2](seed), seed), seed)


def refuelling(seed: int) -> Instance:
    """A mission of days with kits, by turns with tows, and tanks that have to be filled."""
    drawn = random_mission(seed)
    made = carrying(drawn.replace(stations=drawn.stations or random_mission(0).stations), seed)
    made = made if seed % 4 else towing(made, seed)
    rng, dry_kg, exhaust = np.random.default_rng([15, seed]), 200.0, 3000.0
    ratio = float(np.expm1(rng.uniform(250.0, 600.0) / exhaust))
    chaser = made.chaser.replace(
        start=AtStation(station=made.stations[0].name), available_s=(0.0, None), max_targets=None,
        tank=TankByMass(
            dry_mass_kg=dry_kg, propellant_kg=dry_kg * ratio, isp_s=exhaust / 9.80665
        ),
        kit_mass_kg=dry_kg * float(rng.choice([0.2, 0.5, 1.0])),
    )  # fmt: skip
    mission = made.mission.replace(duration_s=2.5 * DAY_S)
    return made.replace(chasers=(chaser,), mission=mission, keep_out_zones=())


def campaign_with_cargo(seed: int) -> Instance:
    """Several chasers with kits, and every third time tows."""
    made = carrying((random_campaign, mixed_campaign)[seed % 2](seed), seed)
    return made if seed % 3 else towing(made, seed)


every_mission = pytest.mark.parametrize(
    "draw", [laden, towing_mission, towing_and_laden, refuelling]
)


def legs_for(instance: Instance) -> Legs:
    """The legs of the only chaser."""
    return legs_of(instance, kept_apart(instance)[0], Connecting(instance))


def worths_of(instance: Instance, bonus: Fraction) -> list[Fraction]:
    """What bodies are worth, required ones more."""
    worths = [Fraction(each.prize) + bonus * each.required for each in instance.targets]
    return [Fraction(0)] * instance.first_target + worths


@every_mission
def test_whatever_walks_remember_the_best_plan_is_one_of_them(draw):
    """With any multipliers and neighbourhoods, a walk collects what brute force says, or more."""
    asked = 0
    for seed in range(60):
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
        assert walks_reach(legs_for(instance), gains, remembered, most, slot).reached, seed
        asked += 1
    assert asked > 40


@pytest.mark.parametrize("draw", [laden, towing_and_laden])
def test_whatever_the_slot_the_best_plan_is_a_walk(draw):
    """However coarsely labels look ahead past services that make a tank worth more or less."""
    asked = 0
    for seed in range(120):
        instance = draw(seed)
        if instance.chaser.kit_mass_kg == 0.0:
            continue
        prizes, _, _ = brute_force(Mission(instance))
        if not prizes > 0.0 or any(each.required for each in instance.targets):
            continue
        legs, worths = legs_for(instance), worths_of(instance, Fraction(0))
        remembered = np.ones((len(worths), len(worths)), dtype=np.bool_)
        most = Fraction(prizes) - Fraction(1, 10**9)
        for slot in np.geomspace(2.0, 1000.0, 12):
            assert walks_reach(legs, worths, remembered, most, float(slot)).reached, (seed, slot)
        asked += 1
    assert asked > 20


@every_mission
def test_walks_that_remember_all_are_the_plans(draw):
    """Without multipliers and with full memory, no walk collects more than the best plan."""
    decided = 0
    for seed in range(60):
        instance = draw(seed)
        prizes, _, _ = brute_force(Mission(instance))
        if not math.isfinite(prizes) or any(each.required for each in instance.targets):
            continue
        worths = worths_of(instance, Fraction(0))
        remembered = np.ones((len(worths), len(worths)), dtype=np.bool_)
        more = Fraction(prizes) + Fraction(1, 10**4)
        assert not walks_reach(legs_for(instance), worths, remembered, more, 20.0).reached, seed
        decided += prizes < sum(worths)
    assert decided > 20


def proven(instance: Instance) -> tuple[adr_opt.Result, Certificate | None]:
    """What is proven, and its certificate where there is evidence.

    There is none where all sets of a few targets were gone through.
    """
    result = adr_opt.solve(instance, "exact", time_limit=60.0)
    try:
        return result, certificate_of(instance, result)
    except InputError:
        assert result.evidence is None
        return result, None


@every_mission
def test_every_proof_is_verified(draw):
    """Each proof of one chaser that says what it rests on is verified, with the same bound."""
    by_walks = 0
    for seed in range(24):
        instance = draw(seed)
        result, certificate = proven(instance)
        if certificate is None:
            continue
        verdict = verify(instance, result.plan, certificate, connections=FEW)
        assert verdict.reasons == (), seed
        stated = certificate.upper_bound
        assert verdict.upper_bound == pytest.approx(-math.inf if stated is None else stated), seed
        by_walks += bool(certificate.walks)
    assert by_walks > 6


def test_bounds_of_campaigns_are_verified():
    """The bound before the last packing is verified and holds; where it is the last, all is."""
    asked = whole = 0
    for seed in range(30):
        instance = campaign_with_cargo(seed)
        result, certificate = proven(instance)
        if certificate is None:
            continue
        asked += 1
        verdict = verify(instance, result.plan, certificate, connections=FEW)
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
    assert asked > 15
    assert whole > 0.8 * asked


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
            each.replace(prize=float(rng.choice([1.0, 1.5, 2.0])), window_s=(0.0, None),
                         required=False)
            for each in made.targets
        ),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("draw", "seeds", "least_paid"),
    [(running_empty, range(0, 40, 2), 0), (scarce, [*range(12), 30, 43], 3)],
)
def test_bounds_where_stations_run_empty_are_verified(draw, seeds, least_paid):
    """The bound before the last packing is verified and holds, refuellings paid for or not."""
    asked = paid = 0
    for seed in seeds:
        instance = draw(seed)
        _, certificate = proven(instance)
        if certificate is None:
            continue
        verdict = verify(instance, None, certificate, connections=0)
        assert verdict.verified, seed
        assert verdict.upper_bound >= brute_force_campaign(Campaign(instance))[0] - 1e-9, seed
        asked += bool(certificate.walks)
        paid += any(station.name in certificate.multipliers for station in instance.stations)
    assert asked > 6
    assert paid >= least_paid


def test_multipliers_of_stations_count_as_often_as_there_are_refuellings():
    """Who writes and who verifies add up the same, also where a packing has proven less."""
    drawn = adr_opt.generate("tiny", 0)
    instance = drawn.replace(stations=(drawn.stations[0].replace(max_refuellings=3),))
    multipliers = np.zeros(len(instance.names))
    multipliers[0] = 0.5
    walks = Walks((0,), 1.0, np.zeros((multipliers.size, multipliers.size), dtype=np.bool_))
    result = replace(
        adr_opt.solve(instance, "greedy"), upper_bound=1.0,
        evidence=Evidence(multipliers, (walks,), 20.0),
    )  # fmt: skip
    certificate = certificate_of(instance, result)
    assert certificate.upper_bound == bound_of(instance, certificate) == 2.0
    unrounded = certificate.replace(prize_step=None)
    assert bound_of(instance, unrounded) == pytest.approx(2.5, rel=1e-15)
    with pytest.raises(InputError, match=r"'station' is neither a target .* with max_refuellings"):
        check_names(
            drawn,
            certificate.replace(instance=certificate.instance.replace(sha256=drawn.sha256)),
        )


def test_whatever_refuellings_cost_the_best_plan_is_worth_no_more_than_follows():
    """With any multipliers of stations, what the best plan collects is below no bound."""
    asked = 0
    for seed in range(60):
        instance = running_empty(seed)
        prizes, _ = brute_force_campaign(Campaign(instance))
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
        assert walks_reach(legs_for(instance), gains, remembered, most, 20.0).reached, seed
        asked += 1
    assert asked > 20


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
        cargo, removals = legs.cargo, [target.removal for target in instance.targets]
        kits = cargo.full.size - 1
        tank = Tank(chaser, kits)
        left = float(cargo.begun[kits])
        objects = {target.name: target.mass_kg for target in instance.targets}
        for body, removal in enumerate(removals, start=instance.first_target):
            assert left - SLACK_M_S == pytest.approx(tank.left_m_s, rel=1e-9, abs=1e-7)
            delta_v = 0.3 * float(rng.random()) * max(tank.left_m_s, 0.0)
            tank.burn(delta_v)
            left -= delta_v
            if removal == "tow":
                tank.tow(delta_v_of_tow(instance, body), float(objects[instance.names[body]] or 0))
                left = float(after_service(cargo, body, kits, left))
                if left < 0.0:
                    assert tank.left_m_s < -SLACK_M_S
                    break
                tows += 1
            elif removal == "kit" and kits and tank.left_m_s > 0.0:
                tank.leave_kit()
                left, kits = float(after_service(cargo, body, kits, left)), kits - 1
                kits_left += 1
    assert kits_left > 20
    assert tows > 20


def delta_v_of_tow(instance: Instance, body: int) -> float:
    """Of half an ellipse between the circle of an object and the disposal orbit [m/s]."""
    orbit = instance.known_orbits[body]
    assert orbit is not None
    high, low = orbit.semi_major_axis_m, 6378137.0 + float(instance.mission.disposal_altitude_m)
    mu, axis = 398600.4418e9, 0.5 * (high + low)
    slower = math.sqrt(mu / high) - math.sqrt(mu * (2.0 / high - 1.0 / axis))
    return slower + math.sqrt(mu * (2.0 / low - 1.0 / axis)) - math.sqrt(mu / low)


def test_connections_from_where_tows_lead_are_those_of_check():
    """All that are drawn can be flown, and none is missing."""
    looked_at = 0
    for seed in range(24):
        instance = towing_mission(seed)
        sampled = sample_connections(instance, Connecting(instance), 100, seed)
        assert sampled.faults == (), seed
        looked_at += sampled.departures
    assert looked_at > 40


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
