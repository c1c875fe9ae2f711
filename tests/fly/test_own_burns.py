"""The plan's own burns in true dynamics: at their times, cheap, and near what the plan says."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from fields import eccentric

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.fly.refine.bodies import TrueBodies
from adr_opt.fly.refine.leg import FlownImpulses, LegEnds, close, residual
from adr_opt.fly.refine.one_leg import planned_angles
from adr_opt.fly.refine.own_burns import cheapest_near
from adr_opt.plan.plan import Plan

Case = tuple[LegEnds, FlownImpulses, np.ndarray]


@cache
def cases(shape: str) -> tuple[Case, ...]:
    """Transfers of a plan: their course, the closed burns of the plan, and those as planned."""
    instance = {
        "ellipses": lambda: eccentric(adr_opt.generate("tiny", 0).replace(dynamics="j2"), 0.02, 0),
        "circles": lambda: adr_opt.generate("tiny", 0),
    }[shape]()
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert isinstance(plan, Plan)
    bodies = TrueBodies(instance, instance.dynamics, instance.names)
    found = []
    for leg in plan.legs:
        burns = [burn for burn in leg.burns if burn.phase != "approach"]
        standoff = next(burn.time_s for burn in leg.burns if burn.phase == "approach")
        rule = instance.transfer
        course = LegEnds(
            bodies.state(leg.origin, burns[0].time_s),
            bodies.following(leg.destination, standoff, rule.standoff_m),
            burns[0].time_s,
            standoff,
            planned_angles(instance, leg)[0],
            instance.dynamics,
            EARTH_RADIUS_M + rule.min_altitude_m,
            EARTH_RADIUS_M + rule.max_altitude_m,
        )
        times = np.array([burn.time_s for burn in burns])
        planned = np.array([burn.delta_v_m_s for burn in burns])
        found.append((course, close(course, times, planned), planned))
    return tuple(found)


def sizes(impulses: np.ndarray) -> float:
    """Σ |u| [m/s]."""
    return float(np.linalg.norm(impulses, axis=1).sum())


@pytest.mark.parametrize("weight", [0.3, 2.0 / 3.0, 1.0, 3.0])
def test_burns_become_better_and_meet_the_goal(weight: float) -> None:
    """ΔV and weighted changes together never grow, times stay, and the goal is met."""
    gained = 0.0
    for course, closed, planned in cases("ellipses"):
        found = cheapest_near(course, closed, planned, weight)
        assert np.array_equal(found.times, closed.times)
        position, speed = residual(course, found)
        assert position < 0.01
        assert speed < 1e-5
        before = sizes(closed.impulses) + weight * sizes(closed.impulses - planned)
        after = sizes(found.impulses) + weight * sizes(found.impulses - planned)
        assert after <= before + 1e-9
        gained += before - after
        low, high = found.reach_m
        assert low >= min(course.lowest_m, closed.reach_m[0]) - 1e-6
        assert high <= max(course.highest_m, closed.reach_m[1]) + 1e-6
    assert gained > 20.0


def test_no_burns_nearby_are_better() -> None:
    """Moved along the goal, to first order, burns are better by no more than the tolerance."""
    weight, rng = 2.0 / 3.0, np.random.default_rng(0)
    for course, closed, planned in cases("ellipses"):
        found = cheapest_near(course, closed, planned, weight)
        count = found.times.size
        rows = found.effects.transpose(1, 0, 2).reshape(6, 3 * count)
        rows = rows / np.linalg.norm(rows, axis=1)[:, None]
        free = np.linalg.svd(rows)[2][6:]
        best = sizes(found.impulses) + weight * sizes(found.impulses - planned)
        for _ in range(200):
            step = (rng.standard_normal(free.shape[0]) @ free).reshape(count, 3)
            step *= rng.choice([0.1, 1.0, 10.0]) / np.linalg.norm(step)
            moved = found.impulses + step
            there = sizes(moved) + weight * sizes(moved - planned)
            assert there >= best * (1.0 - 3e-3)


def test_what_needs_no_change_is_not_changed() -> None:
    """Between circles, in two-body motion, burns stay the plan's where changes count in full."""
    for course, closed, planned in cases("circles"):
        found = cheapest_near(course, closed, planned, 1.0)
        assert sizes(found.impulses - planned) <= sizes(closed.impulses - planned) + 0.05


def test_the_less_changes_count_the_cheaper_the_burns() -> None:
    """From hardly counted to dear: ΔV grows with the weight, and changes become less."""
    found = [
        [cheapest_near(*case, weight) for case in cases("ellipses")]
        for weight in (0.001, 2.0 / 3.0, 10.0)
    ]
    spent = [sum(one.delta_v_m_s for one in row) for row in found]
    changed = [
        sum(sizes(one.impulses - case[2]) for one, case in zip(row, cases("ellipses"), strict=True))
        for row in found
    ]
    assert spent[0] < 0.95 * spent[1] < 0.95 * spent[2]
    assert changed[0] > 1.05 * changed[1] > 1.05 * changed[2]
