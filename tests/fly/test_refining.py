"""Refined plans: legs that meet their stand-offs in another integrator, with the least ΔV."""

from __future__ import annotations

import json
import math
from functools import cache

import numpy as np
import pytest
from drifting_plans import drifting_instance, drifting_plan
from fields import eccentric
from plans import solved, unjudged, with_legs
from seeds import first_of

import adr_opt
from adr_opt.common.constants import MU_M3_S2
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.refine.bodies import TrueBodies, moved, state_at_epoch
from adr_opt.fly.refine.leg import LegEnds, close, fly
from adr_opt.fly.refine.one_leg import first_of_approach, planned_angles
from adr_opt.judge.admit import admit
from adr_opt.kernels.orbits import coast
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.plan.plan import Burn, Plan
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import SequenceSettings


@cache
def mission(seed: int, dynamics: str = "j2", eccentricity: float = 0.0) -> tuple[Instance, Plan]:
    """A tiny mission and a plan; with e > 0 perigees and shapes differ from target to target."""
    instance = adr_opt.generate("tiny", seed).replace(dynamics=dynamics)
    if eccentricity:
        instance = eccentric(instance, eccentricity, seed).with_limits(delta_v_m_s=5000.0)
    return instance, solved(instance)


@cache
def refined(seed: int = 0, dynamics: str = "j2", freedom: str = "free") -> RefinedPlan:
    """Such a plan, refined."""
    return adr_opt.refine(*mission(seed, dynamics), freedom=freedom)


def assert_holds(instance: Instance, plan: Plan, one: RefinedPlan) -> None:
    """All legs are there and arrive in the other integrator, with the ΔV that is stated."""
    assert one.status == "complete"
    assert [leg.leg for leg in one.legs] == list(range(1, len(plan.legs) + 1))
    flight = fly_refined(instance, one)
    assert flight.strayed == ()
    assert flight.worst_miss_m < 0.1
    assert flight.worst_miss_m_s < 1e-4
    assert max(leg.departure_miss_m for leg in flight.legs) < 0.1
    for leg, planned, flown in zip(one.legs, plan.legs, flight.legs, strict=True):
        total = sum(float(np.linalg.norm(burn.delta_v_m_s)) for burn in leg.burns)
        assert leg.flown_delta_v_m_s == pytest.approx(total, abs=1e-9)
        assert flown.flown_delta_v_m_s == pytest.approx(total, abs=1e-9)
        assert leg.planned_delta_v_m_s == planned.delta_v_m_s
        assert leg.flown_delta_v_m_s <= leg.retargeted_delta_v_m_s * (1.0 + 1e-9)


@pytest.mark.parametrize("freedom", ["free", "planned"])
@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
@pytest.mark.parametrize("seed", first_of(range(3), gate=2))
def test_refined_legs_meet_their_stand_offs(seed: int, dynamics: str, freedom: str) -> None:
    """Flown by SciPy every leg is at its stand-off and its target, at rest, by far within 1 m."""
    instance, plan = mission(seed, dynamics)
    assert_holds(instance, plan, refined(seed, dynamics, freedom))


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
@pytest.mark.parametrize("seed", range(2))
def test_eccentric_orbits_are_met_where_they_are(seed: int, dynamics: str) -> None:
    """With e up to 0.02 legs meet the true orbits, not the circles that were planned with."""
    instance, plan = mission(seed, dynamics, 0.02)
    one = adr_opt.refine(instance, plan)
    assert_holds(instance, plan, one)
    standoff = next(state for state in one.legs[0].states if state.event == "stand-off")
    axis = instance.body_orbits[instance.names.index(one.legs[0].destination)].semi_major_axis_m
    assert abs(np.linalg.norm(standoff.position_m) - axis) > 1e4


@pytest.mark.parametrize("gravity", ["j3", "j4"])
def test_higher_harmonics_hold_too(gravity: str) -> None:
    """In a field of more harmonics than were planned with, legs arrive at about the same cost."""
    instance, plan = mission(1)
    one = adr_opt.refine(instance, plan, gravity=gravity)
    assert one.gravity == gravity
    assert_holds(instance, plan, one)
    assert one.flown_delta_v_m_s == pytest.approx(refined(1).flown_delta_v_m_s, rel=0.01)


@pytest.mark.parametrize("eccentricity", [0.0, pytest.param(0.003, marks=pytest.mark.slow)])
def test_weeks_of_drift_are_met(eccentricity: float) -> None:
    """A leg that drifts for weeks arrives, with about the ΔV of its plan."""
    instance, plan = drifting_instance(eccentricity), drifting_plan(eccentricity)
    one = adr_opt.refine(instance, plan)
    assert_holds(instance, plan, one)
    drift = one.legs[1]
    assert drift.kind == "drift"
    assert drift.flown_delta_v_m_s == pytest.approx(plan.legs[1].delta_v_m_s, rel=0.05)


def test_revolutions_are_counted() -> None:
    """A drift that begins a little too strong, and would gain revolutions, is led back to its own.

    By the place alone it would be led to the target as well, but on a lap of its own.
    """
    instance, plan = drifting_instance(), drifting_plan()
    leg = plan.legs[1]
    bodies = TrueBodies(instance, "j2", (leg.origin, leg.destination))
    own = [burn for burn in leg.burns if burn.phase != "approach"]
    times = np.array([burn.time_s for burn in own])
    impulses = np.array([burn.delta_v_m_s for burn in own])
    end = next(burn.time_s for burn in leg.burns if burn.phase == "approach")
    angle, _ = planned_angles(instance, leg)
    course = LegEnds(
        bodies.state(leg.origin, times[0]),
        bodies.following(leg.destination, end, 1000.0),
        times[0],
        end,
        angle,
        "j2",
    )
    impulses[0] *= 1.2
    strayed = fly(course, times, impulses)
    # The nearest lap is another one.
    assert abs(strayed.miss[5]) > 0.6 * math.tau
    found = close(course, times, impulses)
    flown = coast.fly(course.start, times, found.impulses, end, FIELDS["j2"], False)[2]
    assert flown == pytest.approx(angle, abs=0.1)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.slow
def test_whole_plans_cost_what_was_planned_or_less(seed: int) -> None:
    """On circles under J2 the plan's own burns cost within 3 % of the plan; free ones cost less."""
    instance = adr_opt.generate("nominal", seed, targets=12).replace(dynamics="j2")
    plan = solved(instance)
    own = adr_opt.refine(instance, plan, freedom="planned")
    assert own.flown_delta_v_m_s == pytest.approx(plan.delta_v_m_s, rel=0.03)
    free = adr_opt.refine(instance, plan)
    assert free.flown_delta_v_m_s < 0.95 * plan.delta_v_m_s
    lowest = instance.transfer.min_altitude_m
    for leg, kept in zip(free.legs, own.legs, strict=True):
        assert leg.lowest_altitude_m >= min(lowest, kept.lowest_altitude_m) - 1.0


def test_burns_of_the_plan_keep_their_times_and_phases() -> None:
    """With the plan's own burns, each has its time and phase, and a vector that is near."""
    _, plan = mission(0)
    for leg, planned in zip(refined(0, "j2", "planned").legs, plan.legs, strict=True):
        own = [burn for burn in leg.burns if burn.phase != "approach"]
        kept = [burn for burn in planned.burns if burn.phase != "approach"]
        assert [(burn.time_s, burn.phase) for burn in own] == [
            (burn.time_s, burn.phase) for burn in kept
        ]
        for burn, other in zip(own, kept, strict=True):
            apart = np.subtract(burn.delta_v_m_s, other.delta_v_m_s)
            assert np.linalg.norm(apart) < 0.05 * planned.delta_v_m_s + 5.0


def test_states_are_those_of_the_events() -> None:
    """Departure, each burn, stand-off and arrival stand in time order, with the burns in them."""
    for leg in refined().legs:
        events = [state.event for state in leg.states]
        assert events[0] == "departure"
        assert events[-1] == "arrival"
        assert events.count("burn") == len(leg.burns)
        times = [state.time_s for state in leg.states]
        assert times == sorted(times)
        at = {state.event: state.time_s for state in leg.states}
        assert at["stand-off"] == leg.standoff_s
        assert at["arrival"] == leg.arrival_s
        first = leg.burns[0]
        if first.time_s == leg.states[0].time_s:
            gained = np.subtract(leg.states[1].velocity_m_s, leg.states[0].velocity_m_s)
            assert np.allclose(gained, first.delta_v_m_s, atol=1e-9)


def test_zones_keep_the_burns_of_the_plan() -> None:
    """Where there are keep-out zones the plan's own burns are kept, and free ones refused."""
    instance = adr_opt.generate("tiny", 1, zones=4)
    plan = solved(instance)
    assert adr_opt.refine(instance, plan).freedom == "planned"
    with pytest.raises(adr_opt.InputError, match="keep-out zones"):
        adr_opt.refine(instance, plan, freedom="free")


def test_what_is_done_is_kept() -> None:
    """Told that it is enough, refining returns the legs it has and names the others."""
    instance, plan = mission(0)
    some = adr_opt.refine(instance, plan, jobs=1, enough=lambda: True)
    assert some.status == "incomplete"
    assert {leg.leg for leg in some.legs} | {one.leg for one in some.missing} == set(
        range(1, len(plan.legs) + 1)
    )
    assert {one.reason for one in some.missing} == {"interrupted"}
    flight = fly_refined(instance, some)
    assert flight.missing == tuple(one.leg for one in some.missing)
    assert not flight.holds


def test_a_leg_without_a_trajectory_is_missing() -> None:
    """Burns that lead into the Earth leave their leg out with a reason, and the others hold."""
    instance, plan = mission(0)
    leg = plan.legs[0]
    velocity = np.array(leg.burns[0].delta_v_m_s)
    against = -6000.0 * velocity / np.linalg.norm(velocity)
    burns = (leg.burns[0].replace(delta_v_m_s=tuple(against.tolist())), *leg.burns[1:])
    one = adr_opt.refine(
        instance, unjudged(instance, with_legs(plan, (leg.replace(burns=burns), *plan.legs[1:])))
    )
    assert [missing.leg for missing in one.missing] == [1]
    assert [leg.leg for leg in one.legs] == list(range(2, len(plan.legs) + 1))
    assert fly_refined(instance, unjudged(instance, one)).strayed == ()


def test_progress_is_told() -> None:
    """The report begins with none and ends with all legs."""
    heard: list[tuple[int, int]] = []
    instance, plan = mission(0)
    adr_opt.refine(instance, plan, jobs=2, report=lambda done, total: heard.append((done, total)))
    assert heard[0] == (0, len(plan.legs))
    assert heard[-1] == (len(plan.legs), len(plan.legs))
    assert heard == sorted(heard)


def test_the_number_of_threads_changes_nothing() -> None:
    """One thread and three give the same legs."""
    instance, plan = mission(1)
    one, three = (adr_opt.refine(instance, plan, jobs=jobs) for jobs in (1, 3))
    assert one.legs == three.legs


def test_files_hold_all_of_it(tmp_path) -> None:
    """Saved and loaded it is the same; tampered with, one sentence says where."""
    one = refined()
    one.save(tmp_path / "refined.json")
    assert adr_opt.load_refined(tmp_path / "refined.json") == one
    content = json.loads(one.to_json())
    for change, named in (
        (lambda c: c["legs"][0].update(flown_delta_v_m_s=1.0), "legs[0]: field flown_delta_v_m_s"),
        (lambda c: c["legs"][0]["burns"].reverse(), "not in time order"),
        (lambda c: c.update(status="incomplete"), "status"),
        (lambda c: c["bodies"].clear(), "field bodies"),
        (lambda c: c["legs"].reverse(), "order of their numbers"),
        (lambda c: c.update(gravity="moon"), "field gravity"),
    ):
        spoiled = json.loads(json.dumps(content))
        change(spoiled)
        (tmp_path / "spoiled.json").write_text(json.dumps(spoiled), encoding="utf-8")
        with pytest.raises(adr_opt.InputError) as error:
            adr_opt.load_refined(tmp_path / "spoiled.json")
        assert named in str(error.value)


def test_strangers_are_refused() -> None:
    """Another instance, an unknown word or a broken chain is one sentence."""
    instance, plan = mission(0)
    other = adr_opt.generate("tiny", 2)
    for call in (lambda: adr_opt.refine(other, plan), lambda: fly_refined(other, refined())):
        with pytest.raises(adr_opt.InputError, match="belongs to the instance"):
            call()
    with pytest.raises(adr_opt.InputError, match="gravity = 'moon': use one of two-body"):
        adr_opt.refine(instance, plan, gravity="moon")
    with pytest.raises(adr_opt.InputError, match="freedom = 'some'"):
        adr_opt.refine(instance, plan, freedom="some")
    with pytest.raises(adr_opt.InputError, match="jobs = -1"):
        adr_opt.refine(instance, plan, jobs=-1)
    with pytest.raises(adr_opt.InputError, match="put the legs in order"):
        adr_opt.refine(instance, unjudged(instance, with_legs(plan, plan.legs[::-1])))


def test_an_empty_plan_is_refined_and_flown() -> None:
    """A plan without legs has nothing to refine, and misses nothing."""
    instance, plan = mission(0)
    one = adr_opt.refine(instance, unjudged(instance, with_legs(plan, ())))
    assert (one.status, one.legs) == ("complete", ())
    assert not fly_refined(instance, unjudged(instance, one)).strayed


@pytest.mark.parametrize("seed", range(40))
def test_an_approach_on_an_ellipse_begins_in_the_plane(seed: int) -> None:
    """Planes that differ by a metre are closed on the way, not by what the approach begins with."""
    random = np.random.default_rng(seed)
    orbit = Orbit(
        semi_major_axis_m=7.2e6,
        eccentricity=random.uniform(0.001, 0.03),
        inclination_deg=80.0,
        raan_deg=random.uniform(0.0, 360.0),
        argument_of_perigee_deg=random.uniform(0.0, 360.0),
        true_anomaly_deg=random.uniform(0.0, 360.0),
    )
    target = state_at_epoch(orbit, "two-body", 0.0)
    half_s = math.pi * math.sqrt(orbit.semi_major_axis_m**3 / MU_M3_S2)
    normal = np.cross(target[:3], target[3:])
    normal /= np.linalg.norm(normal)
    goal = moved(target, half_s, "two-body")
    goal[:3] += random.uniform(-1.0, 1.0) * normal
    behind = moved(target, -1000.0 / math.hypot(*target[3:]), "two-body")
    last = LegEnds(behind, goal, 0.0, half_s, math.pi, "two-body")
    size_m_s = 250.0 * math.pi / half_s
    outward = target[:3] / np.linalg.norm(target[:3])
    burns = tuple(
        Burn(time_s=time_s, delta_v_m_s=tuple(size_m_s * sign * outward), phase="approach")
        for time_s, sign in ((0.0, -1.0), (half_s, 1.0))
    )
    begins = first_of_approach(last, SequenceSettings(), burns)
    assert abs(begins @ normal) < 0.01 * size_m_s
    assert np.linalg.norm(begins) < 1.2 * size_m_s


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
@pytest.mark.parametrize("seed", [6000, 6002, 6006])
def test_refined_safety_ellipses_are_safe_in_their_own_field(seed: int, dynamics: str) -> None:
    """A safety ellipse refined in a field keeps out of the target there, with any burn missed."""
    instance = eccentric(adr_opt.generate("tiny", seed), 0.01, seed)
    safe = instance.transfer.replace(approach="safety-ellipse")
    instance = instance.replace(dynamics=dynamics, transfer=safe)
    plan = solved(instance)
    assert plan.legs
    admit(instance, adr_opt.refine(instance, plan))
