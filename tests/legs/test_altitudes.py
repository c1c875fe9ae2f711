"""Limits of altitude at the radii of each time: what is left out, and what `check` says of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from seeds import over_seeds
from towed_fields import field

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.judge.check.altitude import Heights
from adr_opt.judge.check.tow import released_between, towed_bodies
from adr_opt.judge.check.violation import MOST_RELEASE_OFF_M
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.legs.families.ends import SPARE_S, AltitudeLimits, altitude_limits
from adr_opt.plan.tows import removals_of
from adr_opt.problem.instance import Instance


def sinking(seed: int, dynamics: str = "j2") -> Instance:
    """A tiny field of which some bodies sink, and some have low perigees."""
    rng = np.random.default_rng(seed)
    drawn = adr_opt.generate("tiny", seed)
    targets = [
        target.replace(
            orbit=target.orbit.replace(
                eccentricity=float(rng.choice([0.0, rng.uniform(0.0, 0.01)])),
                argument_of_perigee_deg=float(rng.uniform(0.0, 360.0)),
            ),
            decay_m_per_day=float(rng.choice([0.0, rng.uniform(-1e4, 5e4)]))
            if dynamics == "j2"
            else None,
        )
        for target in drawn.targets
    ]
    lowest = min(target.orbit.semi_major_axis_m for target in targets) - EARTH_RADIUS_M
    transfer = drawn.transfer.replace(min_altitude_m=lowest - float(rng.uniform(1e3, 6e4)))
    return drawn.replace(targets=tuple(targets), dynamics=dynamics, transfer=transfer)


@over_seeds(range(200), gate=20)
def test_limits_are_those_of_the_judge(*, seed: int) -> None:
    """Until the last arrival and departure the judge finds a body high enough, not long after."""
    instance = sinking(seed)
    heights, limits = Heights(instance), altitude_limits(instance, None)
    for body, name in enumerate(instance.names):
        low_m, least_m = heights.perigee_m(name, 0.0), heights.least_m(name)
        last_s = float(limits.leave_by[body])
        assert (last_s == -math.inf) == (low_m < least_m)
        if math.isfinite(last_s):
            assert heights.perigee_m(name, last_s) >= least_m
            assert heights.perigee_m(name, last_s + SPARE_S + 60.0) < least_m
        elif last_s > 0.0:
            assert heights.perigee_m(name, instance.mission.duration_s) >= least_m


@pytest.mark.parametrize("dynamics", ["j2", "two-body"])
@over_seeds(range(24), gate=3)
def test_no_plan_is_made_that_check_refuses(dynamics: str, *, seed: int) -> None:
    """Whatever sinks or is eccentric, plans of several methods have no violation."""
    instance = sinking(seed, dynamics)
    for method in ("greedy", "auto"):
        plan = adr_opt.solve(instance, method=method).plan
        assert plan is not None
        assert adr_opt.check(instance, plan) == ()


def test_a_leg_to_a_body_that_is_too_low_by_then_is_refused() -> None:
    """A plan that was made without looking at decay breaks the rule of altitudes, leg by leg."""
    instance = adr_opt.generate("tiny", 0).replace(dynamics="j2")
    sinks = tuple(target.replace(decay_m_per_day=2e4) for target in instance.targets)
    deep = instance.replace(targets=sinks, transfer=instance.transfer.replace(min_altitude_m=200e3))
    plan = adr_opt.solve(deep, method="greedy").plan
    assert plan is not None
    assert adr_opt.check(deep, plan) == ()
    last = plan.legs[-1]
    limit = Heights(deep).perigee_m(last.destination, last.end_s) + 1e3
    shallow = deep.replace(transfer=deep.transfer.replace(min_altitude_m=limit))
    told = plan.replace(instance=plan.instance.replace(sha256=shallow.sha256))
    heights = Heights(shallow)
    low = {
        number
        for number, leg in enumerate(plan.legs, start=1)
        if heights.perigee_m(leg.destination, leg.end_s) < heights.least_m(leg.destination) - 10.0
    }
    assert low
    found = {one.leg for one in adr_opt.check(shallow, told) if one.rule == "altitude"}
    assert low <= found


@over_seeds(range(40), gate=4)
def test_connections_are_the_best_of_those_in_time(*, seed: int) -> None:
    """What leaves or arrives too late is left out, and hides nothing that is in time."""
    rng = np.random.default_rng(seed)
    instance = adr_opt.generate("tiny", seed).replace(dynamics="j2")
    every, some = ConnectionFinder(instance), ConnectionFinder(instance)
    end = instance.mission.duration_s
    bodies = len(instance.names)
    arrive, leave = (rng.uniform(0.2, 1.0, bodies) * end for _ in range(2))
    some.ends.altitudes = AltitudeLimits(arrive, leave)
    resolution = instance.transfer.delta_v_resolution_m_s
    i, j = (int(body) for body in rng.choice(bodies, 2, replace=False))
    all_of, left = every.find(i, j, resolution), some.find(i, j, resolution)
    assert (left.departure <= leave[i]).all()
    assert (left.arrival <= arrive[j]).all()
    may = (all_of.departure <= leave[i]) & (all_of.arrival <= arrive[j])
    for departure, arrival, delta_v in zip(
        all_of.departure[may], all_of.arrival[may], all_of.delta_v[may], strict=True
    ):
        as_good = (left.departure >= departure - 1e-3) & (left.arrival <= arrival + 10.0)
        assert (as_good & (left.delta_v <= delta_v + resolution + 1e-6)).any()


@over_seeds(range(40), gate=4)
def test_tows_end_near_their_circle(*, seed: int) -> None:
    """What is towed is released within 10 km of its circle, wherever the tow begins; else left."""
    rng = np.random.default_rng(seed)
    instance = field(("two-body", "j2")[seed % 2], 1)
    instance = instance.replace(
        targets=tuple(
            target.replace(
                orbit=target.orbit.replace(
                    eccentricity=float(rng.uniform(0.0, 0.0025)),
                    argument_of_perigee_deg=float(rng.uniform(0.0, 360.0)),
                )
            )
            for target in instance.targets
        )
    )
    limits, tows = altitude_limits(instance, None), removals_of(instance, None)
    towed = towed_bodies(instance, instance.orbits(), None)
    for body, target in enumerate(instance.targets, start=instance.first_target):
        off = []
        for start_s in rng.uniform(0.0, instance.mission.duration_s, 12):
            times = start_s, start_s + tows[body].time_s
            apsides = released_between(towed[target.name], times, instance.oblateness_m2)
            off += [abs(radius - tows[body].radius_m) for radius in apsides]
        if limits.arrive_by[body] > 0.0:
            assert max(off) <= MOST_RELEASE_OFF_M
        else:
            assert target.orbit.eccentricity > 1.2e-3
    plan = adr_opt.solve(instance, method="greedy").plan
    assert plan is not None
    assert adr_opt.check(instance, plan) == ()
    assert all(limits.arrive_by[instance.names.index(leg.destination)] > 0.0 for leg in plan.legs)


def test_an_object_let_go_near_the_ground_is_seen() -> None:
    """Burns between circles leave an eccentric object as eccentric, which the judge computes."""
    instance = field("two-body", 1)
    first = instance.targets[0]
    orbit = first.orbit.replace(semi_major_axis_m=EARTH_RADIUS_M + 750e3, eccentricity=0.056)
    eccentric = instance.replace(targets=(first.replace(orbit=orbit), *instance.targets[1:]))
    towed = towed_bodies(eccentric, eccentric.orbits(), None)[first.name]
    low, high = released_between(towed, (0.0, towed.time_s), 0.0)
    assert low < EARTH_RADIUS_M + 100e3
    assert high > EARTH_RADIUS_M + 750e3
    plan = adr_opt.solve(eccentric, method="greedy").plan
    assert plan is not None
    (left,) = (one for one in plan.unvisited if one.target == first.name)
    assert left.reason == "no-transfer"


def test_circles_that_stay_know_no_limit() -> None:
    """Where nothing sinks and all is round no time is limited, however low the bodies are."""
    instance = adr_opt.generate("nominal", 0)
    low = instance.replace(transfer=instance.transfer.replace(min_altitude_m=1500e3))
    for one in (instance, low, low.replace(dynamics="j2")):
        limits = altitude_limits(one, None)
        assert np.isposinf(limits.arrive_by).all()
        assert np.isposinf(limits.leave_by).all()
