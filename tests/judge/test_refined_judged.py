"""Refined plans are judged by another flight: what is right passes, and what is edited is seen."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from electric_fields import electric
from plans import unjudged
from pydantic import ValidationError
from refined_edits import edited
from seeds import over_kinds
from towed_fields import field

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.refine.bodies import moved
from adr_opt.judge.admit import admit
from adr_opt.judge.check.violation import Violation
from adr_opt.judge.refined import check_refined
from adr_opt.judge.refined.flight import MOST_RELEASE_OFF_M
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import RefinedLeg, RefinedPlan, RefinedTow, reference
from adr_opt.problem.instance import Instance

Case = tuple[Instance, Plan, RefinedPlan]
Kind = tuple[Callable[[int], Instance], str | None]

KINDS: dict[str, Kind] = {
    "own-burns": (lambda seed: adr_opt.generate("tiny", seed), "planned"),
    "j2": (lambda seed: adr_opt.generate("tiny", seed).replace(dynamics="j2"), "planned"),
    "free": (lambda seed: adr_opt.generate("tiny", seed).replace(dynamics="j2"), "free"),
    "tows": (lambda seed: field(("two-body", "j2")[seed % 2], 1 + seed // 2 % 2), "planned"),
    "clouds": (
        lambda seed: adr_opt.generate("cloud", seed, targets=8).replace(dynamics="j2"),
        "free",
    ),
    "chasers": (lambda seed: adr_opt.generate("campaign", seed, targets=9, chasers=2), "planned"),
    "zones": (lambda seed: adr_opt.generate("tiny", seed, zones=3), "planned"),
    "drifts": (lambda seed: adr_opt.generate("rocket-bodies", seed, targets=4), "free"),
    "low-thrust": (lambda seed: electric(seed), None),
    "spirals": (lambda seed: electric(seed, tows=True), None),
}


@cache
def case(kind: str, seed: int) -> Case:
    """A field of a kind, a plan and its refinement."""
    draw, freedom = KINDS[kind]
    instance = draw(seed)
    plan = adr_opt.solve(instance, method="greedy-guarded").plan
    assert plan is not None
    refined = adr_opt.refine(instance, plan, freedom=freedom, jobs=1)
    return instance, plan, refined


@over_kinds(
    "kind, seeds",
    own=("own-burns", range(24), 2),
    j2=("j2", range(24), 2),
    free=("free", range(24), 1),
    tows=("tows", range(8), 2),
    clouds=("clouds", range(24), 0),
    chasers=("chasers", range(24), 1),
    zones=("zones", range(24), 1),
    drifts=("drifts", range(4), 0),
    low=("low-thrust", range(4), 0),
    spirals=("spirals", range(4), 0),
)
def test_nothing_is_found_in_what_was_refined(kind: str, seeds: range) -> None:
    """Of a plan as it was refined only what flights say as well is found: tanks that break."""
    for seed in seeds:
        instance, plan, refined = case(kind, seed)
        found = check_refined(instance, plan, refined)
        flight = fly_refined(instance, refined)
        assert {one.rule for one in found} <= {"delta-v", "missing"}, (kind, seed, found)
        assert any(one.rule == "delta-v" for one in found) == bool(flight.broken_tanks)
        assert bool(found) == (not flight.holds)


def off(instance: Instance, refined: RefinedPlan) -> float:
    """How far states are from where an integrator of another kind leads from the bodies [m].

    The worse of positions, and of velocities times a thousand seconds.
    """
    bodies = {one.name: np.array([*one.position_m, *one.velocity_m_s]) for one in refined.bodies}
    tows = [
        (name, tow)
        for leg in refined.legs
        for name, tow in ((leg.origin, leg.tow_before), (leg.destination, leg.tow))
        if tow is not None
    ]
    worst = max(_off(leg, bodies, refined) for leg in refined.legs)
    return max(worst, *(_released_off(tow, bodies[name], refined) for name, tow in tows), 0.0)


def _released_off(tow: RefinedTow, body: np.ndarray, refined: RefinedPlan) -> float:
    state, now = moved(body, tow.start_s, refined.gravity), tow.start_s
    for burn in tow.burns:
        state, now = moved(state, burn.time_s - now, refined.gravity), burn.time_s
        state[3:] += burn.delta_v_m_s
    told = tow.released
    return _apart(state, np.array([*told.position_m, *told.velocity_m_s]))


def _off(leg: RefinedLeg, bodies: dict[str, np.ndarray], refined: RefinedPlan) -> float:
    gravity = refined.gravity
    stated = [np.array([*one.position_m, *one.velocity_m_s]) for one in leg.states]
    state, now = stated[0], leg.states[0].time_s
    worst = 0.0
    if leg.tow_before is None:
        worst = _apart(state, moved(bodies[leg.origin], now, gravity))
    burns = [*leg.burns]
    for one, told in zip(leg.states[1:], stated[1:], strict=True):
        state, now = moved(state, one.time_s - now, gravity), one.time_s
        if one.event == "burn":
            state[3:] += burns.pop(0).delta_v_m_s
        worst = max(worst, _apart(state, told))
    return max(worst, _apart(state, moved(bodies[leg.destination], now, gravity)))


def _apart(one: np.ndarray, other: np.ndarray) -> float:
    return max(math.dist(one[:3], other[:3]), 1e3 * math.dist(one[3:], other[3:]))


WITHIN = (
    "moved_state",
    "moved_body",
    "changed_burn",
    "later_burn",
    "later_state",
    "other_time",
    "other_tow",
)
"""Edits that may be smaller than tolerances."""


@over_kinds("numbers", edits=(range(2000), 112))
def test_every_edit_is_noticed(numbers: range) -> None:
    """An edit at random is refused, or noticed, or leaves every state within 10 m and 1 cm/s."""
    kinds = ("own-burns", "j2", "tows", "chasers")
    noticed = 0
    for number in numbers:
        instance, plan, refined = case(kinds[number // 32 % 4], number // 128 % 2)
        name, content = edited(refined.to_dict(), number)
        if content == refined.to_dict():
            continue
        try:
            changed = RefinedPlan.model_validate(content)
        except ValidationError:
            continue
        if check_refined(instance, plan, changed):
            noticed += 1
            continue
        assert name in WITHIN
        assert off(instance, changed) <= 10.0 + 1e-3, (number, name)
    assert noticed > 0.7 * len(numbers)


def rules(instance: Instance, plan: Plan, refined: RefinedPlan) -> set[str]:
    """Rules that a refined plan breaks."""
    return {violation.rule for violation in check_refined(instance, plan, refined)}


def test_another_plan_or_instance_is_named() -> None:
    """A refined plan of another instance, or of another plan, is told as such, and nothing else."""
    instance, plan, refined = case("own-burns", 0)
    other = adr_opt.generate("tiny", 1)
    (found,) = check_refined(other, plan, refined)
    assert found.rule == "instance"
    assert "belongs to the instance" in found.message
    (found,) = check_refined(instance, plan.replace(seed=7), refined)
    assert found.rule == "plan"


def test_a_refined_plan_of_a_plan_that_is_not_legal_is_refused() -> None:
    """A leg that is lost from a refined plan and from the plan that it holds is missed."""
    instance, plan, refined = case("own-burns", 0)
    (route,) = plan.routes
    shorter = plan.replace(routes=(route.replace(legs=route.legs[:1] + route.legs[2:]),))
    legs = tuple(
        leg.replace(leg=number)
        for number, leg in enumerate((refined.legs[0], *refined.legs[2:]), start=1)
    )
    on = {name for leg in legs for name in (leg.origin, leg.destination)}
    bodies = tuple(body for body in refined.bodies if body.name in on)
    edited_file = refined.replace(legs=legs, bodies=bodies).made_of(shorter)
    found = admit(instance, edited_file, unjudged=True).violations
    assert "chain" in {violation.rule for violation in found}


def test_states_at_the_centre_of_the_earth_are_violations() -> None:
    """A body or a leg at the centre of the Earth is a violation, and no internal error."""
    instance, plan, refined = case("own-burns", 0)
    nowhere = (0.0, 0.0, 0.0)
    body = refined.bodies[0].replace(position_m=nowhere)
    state = refined.legs[0].states[0].replace(position_m=nowhere)
    leg = refined.legs[0].replace(states=(state, *refined.legs[0].states[1:]))
    assert "body" in rules(instance, plan, refined.replace(bodies=(body, *refined.bodies[1:])))
    assert "state" in rules(instance, plan, refined.replace(legs=(leg, *refined.legs[1:])))


def test_a_tank_that_flown_legs_break_is_found() -> None:
    """With less in the tank than flown legs take, the leg that lacks it is named."""
    instance, plan, refined = case("j2", 0)
    spent = refined.legs[0].flown_delta_v_m_s
    less = instance.replace(chasers=(instance.chaser.replace(tank={"delta_v_m_s": spent - 1.0}),))
    told = plan.replace(instance=plan.instance.replace(sha256=less.sha256))
    again = refined.replace(instance=told.instance, plan=reference(told))
    assert Violation(1, "delta-v", "") in [
        Violation(one.leg, one.rule, "") for one in check_refined(less, told, again)
    ]


def test_a_leg_that_comes_down_is_missing() -> None:
    """A leg that would pass below the limit of altitude is found, and never handed out refined."""
    instance, plan, refined = case("own-burns", 1)
    lowest = min(
        math.hypot(*one.position_m) - EARTH_RADIUS_M for leg in refined.legs for one in leg.states
    )
    higher = instance.replace(transfer=instance.transfer.replace(min_altitude_m=lowest + 1e3))
    told = plan.replace(instance=plan.instance.replace(sha256=higher.sha256))
    again = refined.replace(instance=told.instance, plan=reference(told))
    low = {one.leg for one in check_refined(higher, told, again) if one.rule == "altitude"}
    assert low
    made = adr_opt.refine(higher, unjudged(higher, told), freedom="planned", jobs=1)
    assert {one.leg for one in made.missing} == low
    assert all("below the limit" in one.reason for one in made.missing)


def test_a_release_off_the_circle_is_found() -> None:
    """An object that is let go more than 10 km off the circle of disposal breaks a rule."""
    instance, plan, refined = case("tows", 0)
    circle = instance.circle_m(instance.targets[0]) + MOST_RELEASE_OFF_M + 500.0
    other = instance.replace(mission=instance.mission.replace(disposal={"circle_m": circle}))
    told = plan.replace(instance=plan.instance.replace(sha256=other.sha256))
    again = refined.replace(instance=told.instance, plan=reference(told))
    assert "release" in rules(other, told, again)
    assert "release" not in rules(instance, plan, refined)


def test_ephemerides_that_are_not_there_are_said(tmp_path) -> None:
    """A plan that claims other ephemerides than the instance has is told so."""
    instance, plan, refined = case("own-burns", 0)
    legs = tuple(leg.replace(holding_delta_v_m_s=0.0) for leg in refined.legs)
    onto = refined.replace(ephemerides={"kind": "elements", "sha256": "0" * 64}, legs=legs)
    assert rules(instance, plan, onto) == {"ephemerides"}
