"""Refined legs of low thrust: flown by another integrator with its own thrust."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli
from electric_fields import electric
from plans import moved_to, unjudged
from seeds import over_seeds

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.export.flights.refined_oem import write_refined
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.refine.bodies import state_of
from adr_opt.fly.refine.lessons import Lessons
from adr_opt.fly.refine.thrust_record import thrust_states
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.plan.refined_thrust import RefinedThrust
from adr_opt.problem.drives import drive_of
from adr_opt.problem.instance import Instance


@cache
def mission(seed: int) -> tuple[Instance, Plan]:
    """A drawn mission of low thrust, and a plan."""
    instance = electric(seed, targets=3)
    plan = adr_opt.solve(instance, method="greedy-guarded").plan
    assert plan is not None
    return instance, plan


@cache
def refined(seed: int) -> RefinedPlan:
    """That plan, refined."""
    return adr_opt.refine(*mission(seed))


def with_thrust(plan: RefinedPlan, **changes: object) -> RefinedPlan:
    """A refined plan with other thrust on its first leg."""
    first, *others = plan.legs
    assert first.thrust is not None
    return plan.replace(legs=(first.replace(thrust=first.thrust.replace(**changes)), *others))


@over_seeds([1, 3], gate=1)
def test_legs_arrive(seed: int) -> None:
    """Legs of weeks arrive in the other integrator, in sunlight and with the propellant stated."""
    instance, plan = mission(seed)
    flight = fly_refined(instance, refined(seed))
    assert flight.holds
    assert len(flight.legs) == len(plan.legs) > 1
    for flown, leg in zip(flight.legs, refined(seed).legs, strict=True):
        assert leg.thrust is not None
        assert flown.shadow_s == 0.0
        assert flown.standoff_miss_m < 0.1
        assert flown.flown_delta_v_m_s == pytest.approx(leg.flown_delta_v_m_s, abs=1e-6)
        assert flown.flown_propellant_kg == pytest.approx(leg.thrust.propellant_kg, abs=1e-9)


@over_seeds([1, 3], gate=1)
def test_legs_keep_the_plan_and_the_chaser(seed: int) -> None:
    """Legs keep the plan's times, and thrust no more than the chaser can."""
    instance, plan = mission(seed)
    drive = drive_of(instance.chasers[0], instance.targets)
    assert drive is not None
    for leg, made in zip(plan.legs, refined(seed).legs, strict=True):
        assert leg.manoeuvres is not None
        assert made.thrust is not None
        assert made.states[0].time_s == leg.departure_s
        assert made.standoff_s == leg.manoeuvres[1].end_s
        assert made.arrival_s == leg.arrival_s
        assert {burn.phase for burn in made.burns} == {"approach"}
        assert made.thrust.force_n <= drive.thrust_n
        assert made.thrust.mass_kg <= (leg.mass_class_kg or drive.heaviest_kg) + 1e-9
        assert made.vented_kg == leg.vented_kg
        spent = drive.exhaust_m_s * math.log(
            made.thrust.mass_kg / (made.thrust.mass_kg - made.thrust.propellant_kg)
        )
        assert spent == pytest.approx(made.flown_delta_v_m_s, abs=1e-6)


def test_files_are_read_as_written(tmp_path: Path) -> None:
    """A refined plan of low thrust is read as it was written."""
    refined(1).save(tmp_path / "refined.json")
    assert RefinedPlan.load(tmp_path / "refined.json") == refined(1)


def test_states_along_a_leg_end_at_the_stand_off() -> None:
    """States along a leg begin docked and end at the stand-off of the file."""
    for leg in refined(1).legs:
        times = np.linspace(leg.states[0].time_s, leg.standoff_s, 100)
        assert leg.thrust is not None
        begin = state_of(leg.states[0])
        found = thrust_states(leg.thrust, begin, leg.states[0].time_s, times, "j2")
        for state, event in ((found[0], leg.states[0]), (found[-1], leg.states[1])):
            assert math.dist(state[:3], event.position_m) < 0.1
            assert math.dist(state[3:], event.velocity_m_s) < 1e-4


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"force_n": 1.0}, "force_n"),
        ({"exhaust_m_s": 2e4}, "exhaust_m_s"),
        ({"mass_kg": 1e3}, "mass_kg"),
        ({"propellant_kg": 0.01}, "propellant_kg"),
    ],
)
def test_thrust_that_the_chaser_has_not_is_refused(changes: dict[str, float], said: str) -> None:
    """A force, speed of exhaust, mass or propellant that is not the chaser's is named."""
    with pytest.raises(InputError, match=said):
        fly_refined(mission(1)[0], with_thrust(refined(1), **changes))


def test_less_thrust_than_stated_is_refused() -> None:
    """Windows that do not make the ΔV that is stated are refused."""
    thrust = refined(1).legs[0].thrust
    assert thrust is not None
    first, second = thrust.arcs
    shorter = first.replace(windows_s=first.windows_s[1:])
    with pytest.raises(InputError, match="windows make"):
        fly_refined(mission(1)[0], with_thrust(refined(1), arcs=(shorter, second)))


def test_windows_out_of_order_are_refused() -> None:
    """Windows and arcs out of time order are refused on reading."""
    thrust = refined(1).legs[0].thrust
    assert thrust is not None
    with pytest.raises(InputError, match="time order"):
        thrust.replace(arcs=thrust.arcs[::-1])
    with pytest.raises(InputError, match="time order"):
        thrust.arcs[0].replace(windows_s=thrust.arcs[0].windows_s[::-1])


def test_another_epoch_brings_thrust_into_the_shadow() -> None:
    """Thrust in the shadow is found: in other months it is for hours, and legs do not hold."""
    instance, _ = mission(1)
    dark = []
    for month in (1, 4, 7, 10):
        later = instance.replace(epoch=instance.epoch.replace(month=month, day=1))
        flight = fly_refined(later, unjudged(later, moved_to(later, refined(1))))
        dark.append(sum(leg.shadow_s or 0.0 for leg in flight.legs))
        assert not flight.strayed
        assert flight.holds == (max(leg.shadow_s or 0.0 for leg in flight.legs) <= 1.0)
    assert max(dark) > 3600.0


def test_legs_without_arcs_are_refused() -> None:
    """Plans whose legs of low thrust lack arcs, or have them out of order, are not refined."""
    instance, plan = mission(1)
    (route,) = plan.routes
    first, *others = route.legs
    assert first.manoeuvres is not None
    for arcs, said in ((None, "two arcs"), (first.manoeuvres[::-1], "not in time order")):
        broken = route.replace(legs=(first.replace(manoeuvres=arcs), *others))
        with pytest.raises(InputError, match=said):
            adr_opt.refine(instance, unjudged(instance, plan.replace(routes=(broken,))))


@pytest.mark.slow
def test_legs_without_time_are_missing() -> None:
    """A leg that its chaser has no time for is missing, with a reason."""
    instance, plan = mission(1)
    (route,) = plan.routes
    first, *others = route.legs
    assert first.manoeuvres is not None
    late = first.departure_s, first.departure_s + 0.1 * DAY_S
    arcs = tuple(
        arc.replace(start_s=start, end_s=start + 0.05 * DAY_S)
        for arc, start in zip(first.manoeuvres, (late[0], late[0] + 0.05 * DAY_S), strict=True)
    )
    hurried = first.replace(manoeuvres=arcs, arrival_s=late[1] + 3000.0)
    found = adr_opt.refine(
        instance, unjudged(instance, plan.replace(routes=(route.replace(legs=(hurried, *others)),)))
    )
    assert [missing.leg for missing in found.missing] == [1]
    assert "in time" in found.missing[0].reason


def test_lost_legs_bar_those_within_their_times() -> None:
    """After a leg that was not found no connection of its pair lies within its times, others do."""
    instance, plan = mission(1)
    lost = refined(1).replace(
        legs=refined(1).legs[1:], status="incomplete", missing=[{"leg": 1, "reason": "no way"}]
    )
    lessons = Lessons(instance)
    lessons.learn(plan, lost)
    first = plan.legs[0]
    key = first.origin, first.destination, first.kind
    assert lessons.corrections.barred_s == {key: ((first.departure_s, first.arrival_s),)}
    assert not lessons.corrections.stays_s
    assert "no transfer within 1 time when none can be flown" in str(lessons.corrections)
    finder = ConnectionFinder(instance)
    i, j = (instance.names.index(name) for name in key[:2])
    every, some = (one.found(i, j) for one in (finder, finder.corrected(lessons.corrections)))
    within = (every.departure >= first.departure_s) & (every.arrival <= first.arrival_s)
    assert within.any()
    assert not within.all()
    assert some.departure.size == every.departure.size - within.sum()
    assert not ((some.departure >= first.departure_s) & (some.arrival <= first.arrival_s)).any()


def test_a_tank_that_breaks_is_planned_again() -> None:
    """Where the flown legs break a tank, the mission ends with a plan that does not."""
    instance = electric(0, tows=True).with_limits(propellant_kg=1.85)
    found = adr_opt.solve_refined(instance, "greedy-guarded")
    assert "is over by" in found.rounds[0].troubles[0]
    assert len(found.rounds) > 1
    assert found.holds
    assert found.plan is not None
    assert found.refined is not None
    assert not adr_opt.check(instance, found.plan)
    assert fly_refined(instance, found.refined).holds


def test_an_ephemeris_has_all_of_the_flight(tmp_path: Path) -> None:
    """The ephemeris covers each leg."""
    instance, _ = mission(1)
    tracks = write_refined(instance, refined(1), tmp_path / "a.oem", step_s=600.0)
    assert sum("low thrust" in track.comment for track in tracks) == len(refined(1).legs)
    for one, after in pairwise(tracks):
        assert one.arc.end_s <= after.arc.start_s + 1e-6
        apart = math.dist(one.arc.positions_m[-1], after.arc.positions_m[0])
        assert after.arc.start_s > one.arc.end_s + 1.0 or apart < 1.0


def test_commands(cli: Cli, tmp_path: Path) -> None:
    """``fly`` of an unrefined plan, and errors on a refined one, end with status 2."""
    instance, plan = mission(1)
    paths = [str(tmp_path / name) for name in ("i.json", "p.json", "r.json")]
    instance.save(paths[0])
    plan.save(paths[1])
    refined(1).save(paths[2])
    assert cli("fly", paths[0], paths[2]).status == 0
    page = tmp_path / "page.html"
    assert cli("report", *paths[:2], "--refined", paths[2], "--fly", "--out", page).status == 0
    assert "Refined legs" in page.read_text()
    for words, said in (
        (("fly", paths[0], paths[1]), "refine the plan"),
        (("fly", paths[0], paths[2], "--samples", "10"), "with errors"),
        (("export", paths[0], paths[1], "--out", str(tmp_path / "a.oem")), "refine the plan"),
    ):
        done = cli(*words)
        assert done.status == 2
        assert said in done.err


def test_a_thrust_of_nothing_is_refused() -> None:
    """Steering of five zeros points nowhere."""
    thrust = refined(1).legs[0].thrust
    assert isinstance(thrust, RefinedThrust)
    with pytest.raises(InputError, match="steering"):
        thrust.arcs[0].replace(steering=(0.0, 0.0, 0.0, 0.0, 0.0))
