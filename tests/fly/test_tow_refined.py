"""Tows in true dynamics: legs that begin where they lead, what they take, and files of them."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from towed_fields import field

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.common.errors import InputError
from adr_opt.fly.dispersion import sample_flights
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.refine import refine
from adr_opt.fly.refine.ephemeris import tracks
from adr_opt.fly.refine.troubles import beginning
from adr_opt.mission.problem import Problem
from adr_opt.plan.cargo import followed
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.instance import Instance


@cache
def refined(dynamics: str, every: int, freedom: str) -> tuple[Instance, Plan, RefinedPlan]:
    """A plan with tows in true dynamics."""
    instance = field(dynamics, every)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    return instance, plan, refine(instance, plan, freedom=freedom)


REFINED = [
    (dynamics, every, freedom)
    for dynamics in ("two-body", "j2")
    for every in (1, 2)
    for freedom in ("free", "planned")
]


@pytest.mark.parametrize("case", REFINED)
def test_refined_legs_begin_where_tows_lead(case):
    """Flown by another integrator all legs arrive that begin where tows end, and so do the tows."""
    instance, plan, one = refined(*case)
    assert len(plan.lead_ins) >= 2
    flight = fly_refined(instance, one)
    assert flight.holds
    assert flight.worst_miss_m < 0.1
    assert max(leg.departure_miss_m for leg in flight.legs) < 0.1
    for leg, planned, flown in zip(one.legs, plan.legs, flight.legs, strict=True):
        assert (leg.tow is None) == (planned.tow is None) == (flown.tow_miss_m is None)
        before = plan.lead_ins.get(leg.leg)
        assert (leg.tow_before is None) == (before is None)
        if before is not None:
            assert leg.states[0].time_s == pytest.approx(before[-1].time_s, abs=1e-6)
        if leg.tow is not None:
            assert flown.tow_miss_m < 0.1
            assert leg.removal_m_s == pytest.approx(planned.tow.delta_v_m_s)


@pytest.mark.parametrize("case", REFINED)
def test_refined_tows_are_paid_for(case):
    """Tanks and totals hold legs and tows, and with the plan's own burns about what it states."""
    instance, plan, one = refined(*case)
    towing = math.fsum(leg.tow.delta_v_m_s for leg in plan.legs if leg.tow)
    assert one.planned_delta_v_m_s == pytest.approx(plan.delta_v_m_s)
    legs = math.fsum(leg.flown_delta_v_m_s for leg in one.legs)
    assert one.flown_delta_v_m_s == pytest.approx(legs + towing)
    assert one.retargeted_delta_v_m_s == pytest.approx(plan.delta_v_m_s, rel=0.005)
    flight = fly_refined(instance, one)
    assert flight.flown_delta_v_m_s == pytest.approx(one.flown_delta_v_m_s)
    assert math.fsum(tank.flown_delta_v_m_s for tank in flight.tanks) == pytest.approx(
        one.flown_delta_v_m_s
    )
    flown = [(leg.destination, leg.flown_delta_v_m_s) for leg in one.legs]
    left = followed(instance, instance.chaser, flown)[-1].left_m_s
    tank = flight.tanks[-1]
    assert tank.budget_m_s - tank.flown_delta_v_m_s == pytest.approx(left)


@pytest.mark.parametrize("case", REFINED)
def test_objects_are_released_where_they_are_disposed_of(case):
    """They end on circles at the disposal altitude, under J2 up to its short periods."""
    instance, _, one = refined(*case)
    near_m = 1e-3 if instance.dynamics == "two-body" else 15e3
    for leg, tow in ((leg, leg.tow) for leg in one.legs if leg.tow is not None):
        radius = math.hypot(*tow.released.position_m)
        axis = 1.0 / (2.0 / radius - math.hypot(*tow.released.velocity_m_s) ** 2 / MU_M3_S2)
        for length in (radius, axis):
            disposal = instance.circle_m(leg.destination) + EARTH_RADIUS_M
            assert abs(length - disposal) < near_m


def test_the_ephemeris_of_tows_has_no_gaps():
    """Arcs of a refined flight with tows join each other in time and place."""
    _, _, one = refined("j2", 2, "free")
    arcs = [track.arc for track in tracks(one)]
    assert sum(arc.phase == "tow" for arc in arcs) == sum(leg.tow is not None for leg in one.legs)
    for first, second in pairwise(arcs):
        assert second.times_s[0] == pytest.approx(first.times_s[-1], abs=1e-3)
        assert np.linalg.norm(second.positions_m[0] - first.positions_m[-1]) < 10.0


def test_a_refined_file_says_its_tows():
    """A refined plan with tows is read as it is written; spoiled tows are refused in a sentence."""
    _, _, one = refined("j2", 2, "free")
    assert RefinedPlan.from_json(one.to_json()) == one
    towed = next(leg for leg in one.legs if leg.tow is not None)
    first, second = towed.tow.burns
    with pytest.raises(ValueError, match="two in time order"):
        towed.tow.replace(burns=(second, first))
    with pytest.raises(ValueError, match="not that of the second burn"):
        towed.tow.replace(released=towed.tow.released.replace(time_s=first.time_s))
    with pytest.raises(ValueError, match="begins before arrival_s"):
        towed.replace(arrival_s=second.time_s, end_s=second.time_s)
    following = next(leg for leg in one.legs if leg.tow_before is not None)
    first, second = following.tow_before.burns
    late = following.tow_before.replace(
        burns=(first, second.replace(time_s=following.arrival_s)),
        released=following.tow_before.released.replace(time_s=following.arrival_s),
    )
    with pytest.raises(ValueError, match="ends after the first burn"):
        following.replace(tow_before=late)


@pytest.mark.parametrize("field_name", ["tow", "tow_before"])
def test_a_refined_plan_without_its_tows_is_refused(field_name):
    """Whoever leaves a tow out of a refined plan, or adds one, is told so before it is flown."""
    instance, _, one = refined("j2", 2, "free")
    at, lost = next((k, leg) for k, leg in enumerate(one.legs) if getattr(leg, field_name))
    without = lost.replace(**{field_name: None})
    spoiled = one.replace(legs=(*one.legs[:at], without, *one.legs[at + 1 :]))
    with pytest.raises(InputError, match=f"{field_name}: the plan has a tow there"):
        fly_refined(instance, spoiled)
    tow = getattr(lost, field_name)
    other, bare = next((k, leg) for k, leg in enumerate(one.legs) if not getattr(leg, field_name))
    legs = list(one.legs)
    # Its times are those of another leg, which nobody looks at before.
    legs[other] = bare.model_copy(update={field_name: tow})
    spoiled = one.model_copy(update={"legs": tuple(legs)})
    with pytest.raises(InputError, match=f"{field_name}: the plan has no tow there"):
        fly_refined(instance, spoiled)


def test_a_plan_with_tows_is_planned_until_it_holds():
    """Rounds of planning and refining know tows, and what is left of a plan keeps its own."""
    instance = field("j2")
    found = adr_opt.solve_refined(instance, "greedy", rounds=2, time_limit=60.0)
    assert found.holds
    assert fly_refined(instance, found.refined).holds
    _, plan, one = refined("j2", 2, "free")
    broken = one.replace(
        status="incomplete",
        legs=one.legs[:-1],
        missing=({"leg": len(plan.legs), "reason": "lost"},),
    )
    shorter, kept = beginning(Problem(instance), plan, broken)
    assert len(shorter.legs) == len(kept.legs) == len(plan.legs) - 1
    assert adr_opt.check(instance, shorter) == ()
    assert fly_refined(instance, kept).holds
    assert kept.legs[-1].tow is not None
    assert kept.legs[-1].tow.burns[0].time_s == shorter.legs[-1].end_s


def test_flights_with_errors_pay_for_tows():
    """What a flight with errors takes holds the tows, and no leg is late for them alone."""
    instance, _, one = refined("j2", 2, "free")
    found = sample_flights(instance, one, flights=20)
    towing = math.fsum(leg.removal_m_s for leg in one.legs)
    assert found.refined_delta_v_m_s == pytest.approx(one.flown_delta_v_m_s)
    assert found.delta_v_m_s.value > towing + 0.9 * (one.flown_delta_v_m_s - towing)
    assert [tank.refined_delta_v_m_s for tank in found.tanks] == pytest.approx(
        [one.flown_delta_v_m_s]
    )
