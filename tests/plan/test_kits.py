"""Kits, tows, tanks by mass: planners, bounds and `check` against plain enumeration of masses."""

from __future__ import annotations

import numpy as np
import pytest
from against_enumeration import held, optimal
from brute_force import brute_force_campaign
from plans import unjudged
from random_rules import (
    carrying,
    drifting_mission,
    given_field,
    mixed_campaign,
    random_campaign,
    random_mission,
    towing,
)
from seeds import over_kinds

import adr_opt
from adr_opt.common.constants import SLACK_M_S
from adr_opt.fly.flight import fly, fly_refined
from adr_opt.judge.check.tank import TankLevel
from adr_opt.kernels.rules.loads import after_service
from adr_opt.mission.problem import Problem
from adr_opt.plan.cargo import loads_of
from adr_opt.problem.instance import Instance


def drawn(seed: int) -> Instance:
    """One chaser or several, with kits, and tows, by turns under J2 and on given connections."""
    draw = drifting_mission if seed % 4 == 3 else random_mission
    if seed % 5 == 2:
        draw = given_field
    make = (draw, lambda n: random_campaign(n, draw), lambda n: mixed_campaign(n, draw))[seed % 3]
    made = carrying(make(seed), seed)
    return made if seed % 2 or made.given is not None else towing(made, seed)


some_seeds = over_kinds("seeds", drawn=(range(60), 3))


@some_seeds
@pytest.mark.parametrize("method", ["auto", "exact", "greedy", "greedy-guarded"])
def test_plans_pass_and_bounds_hold(method, seeds):
    """What is planned passes `check`, and enumeration knows nothing above what is proven."""
    margins = (0.15, 0.0, 0.5, 0.0, 0.8)
    campaigns = [Problem(drawn(seed), margin=margins[seed % 5]) for seed in seeds]
    assert sum(each.alone is None for each in campaigns) > 0.4 * len(seeds)
    results = held(campaigns, method)
    if method in ("auto", "exact"):
        assert optimal(results) >= 0.8 * len(results) > 0.4 * len(seeds)


def test_what_is_left_is_what_masses_say():
    """ΔV left after legs, services and refuelling is that of the masses, by the rocket equation."""
    rng, drawn = np.random.default_rng(1), adr_opt.generate("tiny", 0)
    targets = tuple(target.replace(removal="kit") for target in drawn.targets)
    for _ in range(500):
        dry, kit = float(rng.uniform(50.0, 2000.0)), float(rng.uniform(0.1, 100.0))
        chaser = drawn.chaser.replace(
            tank={
                "dry_mass_kg": dry,
                "propellant_kg": float(rng.uniform(10.0, 3000.0)),
                "isp_s": float(rng.uniform(50.0, 4000.0)),
            },
            kit_mass_kg=kit,
        )
        instance = drawn.replace(chasers=(chaser,), targets=targets)
        loads = loads_of(instance, chaser, 0.0)
        kits = int(rng.integers(1, loads.full.size))
        tank, left = TankLevel(chaser, kits), float(loads.full[kits])
        while kits:
            assert left - SLACK_M_S == pytest.approx(tank.left_m_s, rel=1e-9, abs=1e-7)
            if rng.random() < 0.2:
                tank.fill()
                left = float(loads.full[kits])
            delta_v = float(rng.uniform(0.0, 0.5)) * tank.left_m_s
            tank.burn(delta_v)
            tank.leave_kit()
            richer, _ = after_service(loads, instance.first_target, kits, left - delta_v + 1e-3)
            left, kits = after_service(loads, instance.first_target, kits, left - delta_v)
            assert richer > left  # who is richer before is so after it


def kit_then_leg() -> tuple[Instance, float]:
    """A heavy kit where the chaser is launched to, and the least ΔV from there to another target.

    Half of a tank is not enough for that, but half of what it is worth with the kit is, once that
    is left behind.
    """
    drawn = adr_opt.generate("tiny", 0, targets=2)
    one, other = drawn.targets
    chaser = drawn.chaser.replace(start="anywhere", end="anywhere")
    instance = drawn.replace(
        stations=(), targets=(one.replace(removal="kit"), other), chasers=(chaser,)
    )
    mission, first = adr_opt.Mission(instance), instance.first_target
    found = mission.timetable.connections(first, first + 1, resolution_m_s=0.0)
    needed = float(found.delta_v[found.departure > mission.rules.service[first]].min())
    exhaust, dry, kit = 3000.0, 100.0, 400.0
    # What halves of tanks are worth, of more and more propellant.
    propellant = np.linspace(1.0, 500.0, 5000)
    ratio = np.sqrt((dry + kit + propellant) / (dry + kit))
    enough = exhaust * np.log(((dry + kit) * ratio - kit) / dry) > needed + 1.0
    tank = {
        "dry_mass_kg": dry,
        "isp_s": exhaust / 9.80665,
        "propellant_kg": float(propellant[enough][0]),
    }
    return instance.replace(chasers=(chaser.replace(tank=tank, kit_mass_kg=kit),)), needed


def test_what_is_kept_back_may_leave_more_than_a_share_of_the_lightest_tank():
    """Bounds allow for what is left after a kit of a tank of which a part is kept back."""
    instance, needed = kit_then_leg()
    assert 0.5 * instance.chaser.tank.delta_v_m_s < needed
    campaign = Problem(instance, margin=0.5)
    for slot in (20.0, 0.5):
        result = adr_opt.solve(campaign, "exact", time_limit=30.0, delta_v_slot_m_s=slot)
        assert result.objective == brute_force_campaign(campaign)[0] == 2.0


def test_masses_that_cannot_be_are_refused():
    """Legs that take more than everything aboard break the tank, in `check` and in `fly`."""
    drawn = adr_opt.generate("tiny", 0)
    chaser = drawn.chaser.replace(
        tank={"dry_mass_kg": 100.0, "propellant_kg": 400.0, "isp_s": 60.0}, kit_mass_kg=60.0
    )
    targets = tuple(target.replace(removal="kit") for target in drawn.targets)
    instance = drawn.replace(chasers=(chaser,), targets=targets)
    plan = adr_opt.solve(instance, "greedy").plan
    (route,) = plan.routes
    assert len(route.legs) > 1
    for delta_v in (3e3, 9e4):
        legs = tuple(leg.replace(delta_v_m_s=delta_v) for leg in route.legs)
        broken = plan.replace(routes=(route.replace(legs=legs),))
        rules = {(found.leg, found.rule) for found in adr_opt.check(instance, broken)}
        assert {(1, "delta-v"), (1, "mass"), (2, "delta-v"), (2, "mass")} <= rules
        (tank,) = fly(instance, unjudged(instance, broken)).tanks
        assert not tank.holds
        assert tank.over_m_s > delta_v


def test_refined_plans_keep_back_what_plans_do():
    """A refined plan has to keep back what its plan does, of tanks as they are when filled."""
    instance, needed = kit_then_leg()
    found = adr_opt.solve_refined(
        instance, "exact", freedom="planned", rounds=1, margin=0.5, time_limit=30.0
    )
    assert found.rounds[0].troubles == ()
    assert found.plan.objective == 2.0
    planned, refined = fly(instance, found.plan), fly_refined(instance, found.refined)
    assert refined.tanks[0].flown_delta_v_m_s == pytest.approx(needed, rel=1e-3)
    assert refined.tanks[0].budget_m_s == pytest.approx(planned.tanks[0].budget_m_s, abs=0.1)
