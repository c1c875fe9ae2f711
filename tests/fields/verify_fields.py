"""Fields whose proofs are verified, and what of them enumeration and the verifier are asked."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
from brute_force import brute_force, brute_force_campaign
from random_rules import (
    DAY_S,
    carrying,
    drifting_mission,
    filled,
    given_field,
    mixed_campaign,
    priced,
    random_campaign,
    random_mission,
    towing,
)

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.judge.verify.legs import Legs, legs_of
from adr_opt.judge.verify.rules import kept_apart
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.legs.connections import Connections
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.problem import problem_of
from adr_opt.plan.certificate import Certificate
from adr_opt.problem.chasers import AtStation, TankByMass
from adr_opt.problem.instance import Instance

FEW = 10
"""Connections that are flown again where that is not what is tested."""


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
        start=AtStation(station=made.stations[0].name),
        available_s=(0.0, None),
        max_targets=None,
        tank=TankByMass(dry_mass_kg=dry_kg, propellant_kg=dry_kg * ratio, isp_s=exhaust / 9.80665),
        kit_mass_kg=dry_kg * float(rng.choice([0.2, 0.5, 1.0])),
    )
    mission = made.mission.replace(duration_s=2.5 * DAY_S)
    return made.replace(chasers=(chaser,), mission=mission, keep_out_zones=())


def campaign_with_cargo(seed: int) -> Instance:
    """Several chasers with kits, and every third time tows."""
    made = carrying((random_campaign, mixed_campaign)[seed % 2](seed), seed)
    return made if seed % 3 else towing(made, seed)


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


def legs_for(instance: Instance) -> Legs:
    """The legs of the only chaser."""
    return legs_of(instance, kept_apart(instance)[0], ConnectionFinder(instance))


def worths_of(instance: Instance, bonus: Fraction) -> list[Fraction]:
    """Worths of bodies, with a bonus for required ones."""
    worths = [Fraction(each.greatest_prize) + bonus * each.required for each in instance.targets]
    return [Fraction(0)] * instance.first_target + worths


def proven(instance: Instance, method: str = "exact") -> tuple[adr_opt.Result, Certificate | None]:
    """The proof, and its certificate after a round trip through text, if there is evidence.

    There is none where all sets of a few targets were gone through.
    """
    result = adr_opt.solve(instance, method, time_limit=60.0)
    try:
        certificate = certificate_of(instance, result)
    except InputError:
        assert result.evidence is None
        return result, None
    assert Certificate.from_json(certificate.to_json()) == certificate
    return result, certificate


def most_collected(instance: Instance) -> float:
    """The most prizes of any plan, of one chaser or of several together, by enumeration."""
    problem = problem_of(instance)
    if problem.alone is None:
        return brute_force_campaign(problem)[0]
    return brute_force(problem.alone)[0]


class Spoilt(ConnectionFinder):
    """Connections some of which are missing, or cheaper than they are."""

    def __init__(self, instance: Instance, missing: float, cheaper_m_s: float) -> None:
        super().__init__(instance)
        self._missing, self._cheaper = missing, cheaper_m_s

    def of_pair(self, i: int, j: int, resolution_m_s: float) -> Connections:
        """The remaining connections of a pair."""
        found = super().of_pair(i, j, resolution_m_s)
        kept = np.random.default_rng([i, j]).random(found.departure.size) >= self._missing
        return replace(found.at(kept), delta_v=found.delta_v[kept] - self._cheaper)
