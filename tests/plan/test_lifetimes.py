"""Lifetimes of released objects: by drag that is flown, as a rule, and in the report."""

from __future__ import annotations

import math

import numpy as np
import pytest
from towed_fields import field

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.judge.check.lifetime import lifetime_years
from adr_opt.plan.lifetimes import ASSUMED_AREA_TO_MASS_M2_KG, lifetimes_years
from adr_opt.problem.air import DRAG_COEFFICIENT, YEAR_S, lifetimes, table
from adr_opt.problem.instance import Instance
from adr_opt.ui.report import tables


@pytest.mark.parametrize(("low_km", "high_km"), [(200.0, 200.0), (180.0, 600.0), (160.0, 3000.0)])
def test_lifetimes_are_those_of_drag_that_is_flown(low_km: float, high_km: float) -> None:
    """Position and velocity integrated in the air come down when both closed forms say so."""
    low, high = (EARTH_RADIUS_M + 1e3 * km for km in (low_km, high_km))
    altitudes, logs = table("mean")
    area = 2.0  # far more than of any stage, so that it is down in days
    axis = 0.5 * (low + high)
    state = np.array([low, 0.0, 0.0, math.sqrt(MU_M3_S2 * (2.0 / low - 1.0 / axis))])

    def rates(state: np.ndarray) -> np.ndarray:
        radius, speed = math.hypot(*state[:2]), math.hypot(*state[2:])
        density = math.exp(np.interp(radius - EARTH_RADIUS_M, altitudes, logs))
        pull = -MU_M3_S2 / radius**3 * state[:2]
        return np.r_[state[2:], pull - 0.5 * DRAG_COEFFICIENT * area * density * speed * state[2:]]

    passed_s, step_s = 0.0, 20.0
    while math.hypot(*state[:2]) > EARTH_RADIUS_M + altitudes[0] and passed_s < 40 * 86400.0:
        one = rates(state)
        two = rates(state + 0.5 * step_s * one)
        three = rates(state + 0.5 * step_s * two)
        four = rates(state + step_s * three)
        state = state + step_s / 6.0 * (one + 2.0 * two + 2.0 * three + four)
        passed_s += step_s
    flown = passed_s / YEAR_S
    (told,) = lifetimes(np.array([[low, high]]), np.array([area]), "mean", 10.0)
    judged = lifetime_years((low, high), area, 10.0)
    revolution = math.tau * math.sqrt(axis**3 / MU_M3_S2) / YEAR_S
    assert told == pytest.approx(flown, rel=0.05, abs=2.0 * revolution)
    assert judged == pytest.approx(told, rel=0.03)


def test_both_forms_agree_on_released_orbits() -> None:
    """Over orbits and areas the judge's integral is within three per cent of the planner's."""
    rng = np.random.default_rng(0)
    for _ in range(12):
        low = rng.uniform(250e3, 600e3)
        shell = np.array([[low, rng.uniform(low, 900e3)]]) + EARTH_RADIUS_M
        area = np.array([rng.uniform(0.003, 0.05)])
        (told,) = lifetimes(shell, area, "mean", 300.0)
        if told < 290.0:
            apsides = float(shell[0, 0]), float(shell[0, 1])
            assert lifetime_years(apsides, float(area[0]), 400.0) == pytest.approx(told, rel=0.03)


def limited(years: float | None, dynamics: str = "j2") -> Instance:
    """A field with tows to a circle of 450 km, and a longest lifetime."""
    instance = field(dynamics)
    return instance.replace(mission=instance.mission.replace(max_lifetime_years=years))


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
def test_objects_that_would_stay_too_long_are_left_out(dynamics: str) -> None:
    """A limit below the lifetime at the circle bars tows, and one above it nothing."""
    free = limited(None, dynamics)
    years = max(lifetimes_years(free, None).values())
    assert years == pytest.approx(min(lifetimes_years(free, None).values()))
    whole = adr_opt.solve(free, "greedy").plan
    assert whole is not None
    within = adr_opt.solve(limited(1.05 * years, dynamics), "greedy").plan
    assert within is not None
    assert within.legs == whole.legs
    tight = limited(0.95 * years, dynamics)
    fewer = adr_opt.solve(tight, "greedy").plan
    assert fewer is not None
    assert all(leg.tow is None for leg in fewer.legs)
    assert any(leg.tow is not None for leg in whole.legs)
    assert adr_opt.check(tight, fewer) == ()
    told = whole.replace(instance=whole.instance.replace(sha256=tight.sha256))
    broken = {one.leg for one in adr_opt.check(tight, told) if one.rule == "lifetime"}
    assert broken == {n for n, leg in enumerate(whole.legs, start=1) if leg.tow is not None}


def test_heavy_objects_come_down_under_control() -> None:
    """Above the mass limit, or of unknown mass, an object is let go to re-enter at once or not."""
    free = limited(None).with_limits(duration_s=2 * 86400.0)
    heavy = max(target.mass_kg for target in free.targets if target.mass_kg is not None)

    def planned(perigee_m: float | None, most_kg: float | None) -> tuple[Instance, adr_opt.Plan]:
        disposal = {"circle_m": 450e3} if perigee_m is None else {"perigee_m": perigee_m}
        mission = free.mission.replace(disposal=disposal, max_uncontrolled_kg=most_kg)
        made = free.replace(mission=mission)
        plan = adr_opt.solve(made, "greedy").plan
        assert plan is not None
        assert adr_opt.check(made, plan) == ()
        return made, plan

    def towed(plan: adr_opt.Plan) -> int:
        return sum(leg.tow is not None for leg in plan.legs)

    _, whole = planned(None, None)
    assert towed(whole) > 0
    assert planned(None, heavy)[1].legs == whole.legs
    tight, fewer = planned(None, 0.99 * heavy)
    assert towed(fewer) == 0
    told = whole.replace(instance=whole.instance.replace(sha256=tight.sha256))
    broken = {one.leg for one in adr_opt.check(tight, told) if one.rule == "uncontrolled"}
    assert broken == {n for n, leg in enumerate(whole.legs, start=1) if leg.tow is not None}
    assert towed(planned(50e3, 0.99 * heavy)[1]) > 0
    assert towed(planned(70e3, 0.99 * heavy)[1]) == 0
    unknown = free.targets[0].replace(removal="kit", mass_kg=None, disposal={"circle_m": 300e3})
    made = free.replace(
        targets=(unknown, *free.targets[1:]), mission=free.mission.replace(max_uncontrolled_kg=1e6)
    )
    plan = adr_opt.solve(made, "greedy").plan
    assert plan is not None
    assert unknown.name not in plan.destinations


def test_a_kit_says_what_it_does() -> None:
    """A kit with an orbit of disposal is held to the limit by that, one without by nothing."""
    instance = field("j2")
    first, *others = instance.targets
    visits = [target.replace(removal="visit") for target in others]
    for disposal, lasts in ((None, None), ({"perigee_m": 60e3}, 0.0), ({"circle_m": 600e3}, 10.0)):
        kit = first.replace(removal="kit", disposal=disposal)
        made = instance.replace(targets=(kit, *visits))
        years = lifetimes_years(made, None)
        assert (made.first_target in years) == (disposal is not None)
        if lasts is not None:
            assert years[made.first_target] >= lasts
            limit = made.replace(mission=made.mission.replace(max_lifetime_years=5.0))
            plan = adr_opt.solve(limit, "greedy").plan
            assert plan is not None
            assert adr_opt.check(limit, plan) == ()
            names = {leg.destination for leg in plan.legs}
            assert (kit.name in names) == (lasts == 0.0)


def test_an_object_of_unknown_area_has_an_assumed_one() -> None:
    """Lifetimes go with the reciprocal of the area over the mass, which a file may state."""
    instance = field("j2")
    (body, years), *_ = lifetimes_years(instance, None).items()
    at = body - instance.first_target
    targets = list(instance.targets)
    targets[at] = targets[at].replace(area_to_mass_m2_kg=2.0 * ASSUMED_AREA_TO_MASS_M2_KG)
    stated = instance.replace(targets=tuple(targets))
    assert lifetimes_years(stated, None)[body] == pytest.approx(0.5 * years, rel=1e-6)


def test_the_report_says_how_long_objects_stay() -> None:
    """The table of legs has a column of years for those that release an object."""
    instance = limited(None)
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    assert "then in orbit, years" in tables.legs(instance, plan)
