"""Launches follow the order of the file where an interval is given, and no order where none is."""

from __future__ import annotations

import numpy as np
import pytest
from against_enumeration import compared
from brute_force import brute_force_campaign
from random_rules import carrying, drifting_mission, filled, mixed_campaign, random_campaign
from seeds import over_kinds
from verify_fields import FEW, proven

import adr_opt
from adr_opt import verify
from adr_opt.mission.problem import Problem
from adr_opt.problem.chasers import Tank
from adr_opt.problem.instance import Instance


def out_of_order(apart_s: float | None = None) -> Instance:
    """A target that closes after 50 s, and one of two launches that comes only after 100 s."""
    drawn = adr_opt.generate("tiny", 0, targets=2)
    first, second = drawn.targets
    chaser = drawn.chaser.replace(start="anywhere", tank=Tank(delta_v_m_s=0.0), end="anywhere")
    mission = drawn.mission.replace(
        service_revolutions=None, service_s=10.0, launch_separation_s=apart_s
    )
    return drawn.replace(
        targets=(first.replace(window_s=(0.0, 50.0)), second),
        stations=(),
        mission=mission,
        chasers=(
            chaser.replace(name="late", available_s=(100.0, None)),
            chaser.replace(name="early"),
        ),
    )


def turned(instance: Instance) -> Instance:
    """The same with its chasers in the opposite order."""
    return instance.replace(chasers=instance.chasers[::-1])


@pytest.mark.parametrize("method", ["auto", "exact", "greedy", "ortools"])
@pytest.mark.parametrize("change", [lambda instance: instance, turned])
def test_a_launch_waits_for_no_other_without_an_interval(method, change) -> None:
    """A chaser that is launched early gets there in time, whatever stands before it."""
    instance = change(out_of_order())
    result = adr_opt.solve(instance, method, time_limit=30.0, iterations=20)
    assert result.objective == 2.0
    assert adr_opt.check(instance, result.plan) == ()


@pytest.mark.parametrize(("apart_s", "both"), [(0.0, 1.0), (20.0, 1.0), (None, 2.0)])
def test_an_interval_of_zero_is_an_order(apart_s, both) -> None:
    """An interval, of 0 s as well, makes launches follow the file; turned, they lie apart."""
    instance = out_of_order(apart_s)
    assert brute_force_campaign(Problem(instance))[0] == both
    assert adr_opt.solve(instance, "exact", time_limit=30.0).objective == both
    free = adr_opt.solve(out_of_order(), "exact", time_limit=30.0).plan
    stated = free.replace(instance=free.instance.replace(sha256=instance.sha256))
    broken = [violation.rule for violation in adr_opt.check(instance, stated)]
    assert broken == ([] if apart_s is None else ["ready", "departure"])
    assert adr_opt.solve(turned(instance), "exact", time_limit=30.0).objective == 2.0


def launched(seed: int, draw) -> Instance:
    """A campaign of which most chasers are launched, each from a time of its own."""
    rng = np.random.default_rng([31, seed])
    make = (random_campaign, mixed_campaign)[seed % 2]
    made = make(seed) if draw is None else make(seed, draw)
    if seed % 3 == 0:
        made = carrying(made, seed)
    chasers = []
    for chaser in made.chasers:
        if rng.random() < 0.9:
            until_s = chaser.available_s[1]
            since_s = float(rng.uniform(0.0, 0.5)) * made.mission.duration_s
            chaser = chaser.replace(
                start="anywhere",
                tank=filled(chaser.tank),
                available_s=(since_s if until_s is None else min(since_s, until_s), until_s),
            )
        chasers.append(chaser)
    if len(chasers) > 2 and rng.random() < 0.5:  # two of one kind
        chasers[1] = chasers[0].replace(name=chasers[1].name)
    return made.replace(chasers=tuple(chasers))


@over_kinds("draw, seeds", two_body=(None, range(60), 3), j2=(drifting_mission, range(60), 2))
def test_the_order_of_chasers_and_stations_is_of_no_account(draw, seeds) -> None:
    """The optimum and its proof are the same for any order of chasers and of stations."""
    moved = 0
    for seed in seeds:
        instance = launched(seed, draw)
        other = turned(instance).replace(stations=instance.stations[::-1])
        moved += [*other.launches.values()] != [*instance.launches.values()]
        best, least = brute_force_campaign(Problem(instance))
        assert brute_force_campaign(Problem(other)) == pytest.approx((best, least)), seed
        for each in (instance, other):
            result, certificate = proven(each)
            compared(Problem(each), result, seed)
            if certificate is not None:
                assert verify(each, result.plan, certificate, connections=FEW).reasons == (), seed
    assert moved > 0.4 * len(seeds)
