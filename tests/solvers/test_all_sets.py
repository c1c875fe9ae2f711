"""Tiny campaigns of which searches find no plan: it is found, or that there is none is proven."""

from __future__ import annotations

import math

import pytest
from brute_force import brute_force_campaign
from drawn_expenses import drawn
from random_rules import given_field, random_mission, towing_mission
from seeds import over_kinds
from two_chasers import campaign as two_chasers

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.plan.station_limits import StationLimits
from adr_opt.problem.chasers import AtStation
from adr_opt.problem.instance import Instance
from solvers.columns.cheapest_routes import cheapest_routes


@pytest.mark.parametrize("method", ["auto", "exact"])
@pytest.mark.parametrize(("draw", "seed"), [(random_mission, 135), (given_field, 495)])
def test_a_plan_is_found_where_chasers_must_fly_for_little(method, draw, seed) -> None:
    """Where all must get to an end, for no prizes or past stations with limits, plans are found."""
    instance = drawn(seed, draw)
    prizes, _ = brute_force_campaign(Problem(instance))
    plan = adr_opt.solve(instance, method, time_limit=30.0, iterations=8).plan
    assert plan is not None
    assert adr_opt.check(instance, plan) == ()
    assert (plan.status, plan.objective) == ("optimal", pytest.approx(prizes))


@over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(100, 130), 12),
    given=(given_field, range(105, 135), 6),
)
def test_that_there_is_no_plan_is_proven(draw, seeds: range) -> None:
    """Campaigns of few targets without a plan are called infeasible, and no others are."""
    infeasible = feasible = 0
    for seed in seeds:
        instance = drawn(seed, draw)
        prizes, _ = brute_force_campaign(Problem(instance))
        result = adr_opt.solve(instance, "exact", time_limit=30.0, iterations=4)
        by_weight = any(station.max_propellant_kg is not None for station in instance.stations)
        if math.isfinite(prizes):
            assert result.plan is not None or by_weight, seed
            assert result.status != "infeasible", seed
            feasible += 1
        elif not by_weight:
            assert result.status == "infeasible", seed
            infeasible += 1
    assert min(feasible, infeasible) >= len(seeds) / 10


def test_no_route_takes_more_than_a_chaser_can() -> None:
    """Of more targets than a chaser may service, or has kits for, there is no cheapest route."""
    drawn_field = adr_opt.generate("tiny", 2, targets=4).with_limits(duration_s=3 * 86400.0)
    field = drawn_field.replace(
        targets=tuple(target.replace(removal="kit") for target in drawn_field.targets)
    )
    light = field.replace(chasers=(field.chaser.replace(kits=2),))
    few = field.replace(chasers=(field.chaser.replace(max_targets=2),))
    first = field.first_target
    for instance, three in ((field, True), (light, False), (few, False)):
        mission = Mission(instance)
        for count, some in ((2, True), (3, three)):
            targets = frozenset(range(first, first + count))
            assert bool(cheapest_routes(mission, targets, lambda: False)) == some


def test_the_mission_of_the_only_chaser_is_planned_by_all_its_rules() -> None:
    """A Mission is no way past kits, tows and limits of stations: its plan is the instance's."""
    towing = towing_mission(1)
    assert Problem(towing).alone is None
    alone = adr_opt.generate("tiny", 0)
    limited = alone.replace(stations=(alone.stations[0].replace(max_refuellings=1),))
    for instance in (towing, limited):
        for method in ("greedy", "exact"):
            given, own = (
                adr_opt.solve(each, method, time_limit=60.0, iterations=3)
                for each in (Mission(instance), instance)
            )
            assert given.plan is not None
            assert adr_opt.check(instance, given.plan) == ()
            assert given.routes == own.routes
        with pytest.raises(InputError, match="does not follow "):
            adr_opt.solve(Mission(instance), "beam", time_limit=60.0)
        with pytest.raises(InputError, match="does not follow "):
            adr_opt.bound(Mission(instance), "lagrangian", time_limit=60.0)
    assert adr_opt.solve(Mission(alone), "greedy").plan is not None


def test_greedy_plans_refuel_at_the_end_within_limits() -> None:
    """Who has to end at a station, and is filled up there, takes no more than it has for all."""
    instance = two_chasers()
    tank = {"dry_mass_kg": 500.0, "propellant_kg": 300.0, "isp_s": 300.0}
    home = instance.chasers[0].replace(
        tank=tank, end=AtStation(station=instance.stations[0].name), max_targets=1
    )
    chasers = (home, home.replace(name="another"))
    plenty = instance.replace(chasers=chasers)
    taken = StationLimits(with_propellant(plenty, 1e6))
    plan = adr_opt.solve(plenty, "greedy-guarded").plan
    kilograms = [
        taken.use(chaser, [(leg.destination, leg.delta_v_m_s) for leg in route.legs])[0]
        for chaser, route in zip(chasers, plan.routes, strict=True)
    ]
    assert min(kilograms) > 0.0
    scarce = with_propellant(plenty, 0.9 * math.fsum(kilograms))
    short = adr_opt.solve(scarce, "greedy-guarded").plan
    assert adr_opt.check(scarce, short) == ()
    assert 0.0 < short.objective < plan.objective


def with_propellant(instance: Instance, kilograms: float) -> Instance:
    """The same with so much propellant at the first station."""
    station = instance.stations[0].replace(max_propellant_kg=kilograms)
    return instance.replace(stations=(station, *instance.stations[1:]))
