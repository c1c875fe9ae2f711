"""Tows by spirals in true dynamics: where they end, what they take, and what is refused."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from electric_fields import electric

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.common.errors import InputError
from adr_opt.export.flights.refined_oem import write_refined
from adr_opt.export.flights.write import FlightFile
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.refine.bodies import TrueBodies, near_circle, state_of
from adr_opt.fly.refine.ephemeris import tracks
from adr_opt.fly.refine.lessons import Lessons, spirals_excess_m_s
from adr_opt.fly.refine.spiral import SpiralTow, spirals_by_leg, towed_by_spiral
from adr_opt.fly.refine.troubles import strayed
from adr_opt.kernels.orbits import ephemeris
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.mission.problem import problem_of
from adr_opt.plan.cargo import followed
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import RefinedLeg, RefinedPlan, RefinedTow
from adr_opt.plan.tows import leaving_orbits
from adr_opt.problem.drives import drive_of
from adr_opt.problem.instance import Instance

pytestmark = pytest.mark.slow

SEED = 3


@cache
def mission(seed: int = SEED) -> tuple[Instance, Plan]:
    """A drawn mission of low thrust with tows, and a plan."""
    instance = electric(seed, tows=True)
    plan = adr_opt.solve(instance, method="greedy-guarded").plan
    assert plan is not None
    return instance, plan


@cache
def refined() -> RefinedPlan:
    """That plan, refined."""
    return adr_opt.refine(*mission())


def spirals() -> list[tuple[RefinedLeg, RefinedTow]]:
    """Refined legs with a tow, and that."""
    return [(leg, leg.tow) for leg in refined().legs if leg.tow is not None]


def with_tow(leg: RefinedLeg, tow: RefinedTow) -> RefinedPlan:
    """The refined plan with another tow after a leg."""
    legs = [one.replace(tow=tow) if one is leg else one for one in refined().legs]
    return refined().replace(legs=tuple(legs))


def test_legs_and_spirals_are_flown() -> None:
    """Another integrator arrives, releases where it is stated, and stays out of the shadow."""
    instance, plan = mission()
    flight = fly_refined(instance, refined())
    assert flight.holds
    assert len(flight.legs) == len(plan.legs)
    assert any(leg.tow_before is not None for leg in refined().legs)
    for leg, planned, flown in zip(refined().legs, plan.legs, flight.legs, strict=True):
        assert (leg.tow is None) == (planned.tow is None) == (flown.release_off_m is None)
        assert flown.departure_miss_m < 0.1
        if leg.tow is not None:
            assert leg.tow.thrust is not None
            assert flown.tow_miss_m < 0.1
            assert flown.tow_shadow_s == 0.0
            assert flown.tow_propellant_kg == pytest.approx(leg.tow.thrust.propellant_kg, abs=1e-9)


def test_spirals_end_on_the_circle_of_disposal() -> None:
    """Mean elements at the release are those of disposal; the judge's means agree to metres."""
    instance, _ = mission()
    disposal = EARTH_RADIUS_M + instance.circle_m(instance.targets[0])
    flight = fly_refined(instance, refined())
    for leg, tow in spirals():
        mean = near_circle(state_of(tow.released), FIELDS["j2"])
        assert abs(mean[0] - disposal) < 0.1
        assert math.hypot(mean[1], mean[2]) < 1e-6
        flown = flight.legs[refined().legs.index(leg)]
        assert abs(flown.release_off_m or 0.0) < 100.0
        assert flown.release_eccentricity is not None
        assert flown.release_eccentricity < 1e-4


def test_spirals_keep_the_plan_and_the_chaser() -> None:
    """They lie between the service and the planned end, and nodes end as planned."""
    instance, plan = mission()
    drive = drive_of(instance.chasers[0], instance.targets)
    assert drive is not None
    masses = {target.name: target.mass_kg or 0.0 for target in instance.targets}
    for leg, tow in spirals():
        planned = plan.legs[leg.leg - 1].tow
        assert planned is not None
        assert tow.thrust is not None
        assert leg.end_s <= tow.start_s
        assert tow.released.time_s == pytest.approx(planned.end_s, abs=1e-3)
        assert tow.planned_delta_v_m_s == planned.delta_v_m_s <= tow.delta_v_m_s + 1.0
        assert tow.thrust.force_n <= drive.thrust_n
        carried = tow.thrust.mass_kg - masses[leg.destination]
        assert drive.lightest_kg <= carried <= drive.heaviest_kg
        node = near_circle(state_of(tow.released), FIELDS["j2"])[4]
        row = leaving_orbits(instance, drive)[instance.names.index(leg.destination)]
        wanted = ephemeris.node_at(row, tow.released.time_s)
        assert abs(math.remainder(math.degrees(node - wanted), 360.0)) < 0.1


def test_spirals_are_paid_for() -> None:
    """The tank holds what spirals take with chaser and object together, not what was planned."""
    instance, _ = mission()
    flown = [(leg.destination, leg.flown_delta_v_m_s) for leg in refined().legs]
    towing = {leg.destination: tow.delta_v_m_s for leg, tow in spirals()}
    left = followed(instance, instance.chasers[0], flown, towing)[-1].left_m_s
    (tank,) = fly_refined(instance, refined()).tanks
    assert tank.budget_m_s - tank.flown_delta_v_m_s == pytest.approx(left)
    assert tank.planned_delta_v_m_s == pytest.approx(refined().planned_delta_v_m_s)
    assert refined().planned_delta_v_m_s == pytest.approx(mission()[1].delta_v_m_s)


def test_files_are_read_as_written(tmp_path: Path) -> None:
    """A refined plan with spirals is read as it was written; broken spirals are refused."""
    refined().save(tmp_path / "refined.json")
    assert RefinedPlan.load(tmp_path / "refined.json") == refined()
    (_, tow), *_ = spirals()
    assert tow.thrust is not None
    with pytest.raises(ValueError, match="must be two"):
        tow.replace(thrust=None, planned_delta_v_m_s=None)
    with pytest.raises(ValueError, match="planned_delta_v_m_s"):
        tow.replace(planned_delta_v_m_s=None)
    with pytest.raises(ValueError, match="after the release"):
        tow.replace(released=tow.released.replace(time_s=tow.start_s))
    with pytest.raises(ValueError, match="has windows"):
        tow.replace(thrust=tow.thrust.replace(arcs=(tow.thrust.arcs[0].replace(windows_s=()),)))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"force_n": 1.0}, "force_n"),
        ({"mass_kg": 1e4}, "at most"),
        ({"mass_kg": 10.0, "propellant_kg": 1.0}, "at least"),
        ({"propellant_kg": 0.01}, "propellant_kg"),
    ],
)
def test_thrust_that_the_chaser_has_not_is_refused(changes: dict[str, float], said: str) -> None:
    """A force, mass or propellant of a spiral that is not the chaser's is named."""
    (leg, tow), *_ = spirals()
    assert tow.thrust is not None
    other = tow.replace(thrust=tow.thrust.replace(**changes))
    with pytest.raises(InputError, match=said):
        fly_refined(mission()[0], with_tow(leg, other))


def test_a_release_off_the_disposal_orbit_does_not_hold() -> None:
    """A mission that wants another altitude finds objects released off it."""
    instance, _ = mission()
    altitude = instance.circle_m(instance.targets[0])
    higher = instance.replace(
        mission=instance.mission.replace(disposal={"circle_m": altitude + 2e3})
    )
    reference = refined().instance.replace(sha256=higher.sha256)
    flight = fly_refined(higher, refined().replace(instance=reference))
    assert len(flight.off_disposal) == len(spirals())
    assert not flight.strayed
    assert not flight.holds


def spiral_to_fly(seed: int = SEED) -> tuple[TrueBodies, SpiralTow]:
    """The first spiral of a mission before it is refined, and the bodies."""
    instance, plan = mission(seed)
    tow = next(iter(spirals_by_leg(instance, plan).values()))
    return TrueBodies(instance, "j2", [tow.name]), tow


def test_spirals_begin_earlier_where_the_chaser_waits() -> None:
    """A tow that needs more time than planned begins before, and ends on the circle in time."""
    bodies, tow = spiral_to_fly()
    hurried = tow._replace(start_s=0.5 * (tow.start_s + tow.end_s))
    found = towed_by_spiral(bodies, hurried)
    assert tow.ready_s <= found.start_s < hurried.start_s
    assert found.released.time_s == tow.end_s
    mean = near_circle(state_of(found.released), FIELDS["j2"])
    assert abs(mean[0] - tow.radius_m) < 0.1
    assert math.hypot(mean[1], mean[2]) < 1e-6


def test_spirals_without_time_are_refused() -> None:
    """A tow of half its time without a wait before is too short for the thrust."""
    bodies, tow = spiral_to_fly()
    late_s = 0.5 * (tow.start_s + tow.end_s)
    with pytest.raises(ArithmeticError, match="does not suffice"):
        towed_by_spiral(bodies, tow._replace(ready_s=late_s, start_s=late_s))


def test_spirals_with_little_time_stay_eccentric() -> None:
    """Without time for a circle all of the thrust leads to the altitude, and some shape is left."""
    bodies, tow = spiral_to_fly(9)
    late_s = tow.end_s - 0.85 * (tow.end_s - tow.start_s)
    found = towed_by_spiral(bodies, tow._replace(ready_s=late_s, start_s=late_s))
    assert found.thrust is not None
    assert 0.9 < found.thrust.force_n / tow.push.force <= 1.0
    mean = near_circle(state_of(found.released), FIELDS["j2"])
    assert abs(mean[0] - tow.radius_m) < 10.0
    assert 1e-3 < math.hypot(mean[1], mean[2]) < 0.03


def test_spirals_beyond_the_plan_are_charged_to_legs() -> None:
    """A leg that costs its excess more leaves the chaser as light after the planned spiral."""
    masses = {target.name: target.mass_kg or 0.0 for target in mission()[0].targets}
    for leg, tow in spirals():
        object_kg = masses[leg.destination]
        assert tow.thrust is not None
        alone = leg.replace(tow_before=None, after_launch=None)
        lighter = (tow.thrust.mass_kg - object_kg) * math.exp(
            -spirals_excess_m_s(alone, masses) / tow.thrust.exhaust_m_s
        )
        kept = math.exp(-tow.planned_m_s / tow.thrust.exhaust_m_s)
        left = (lighter + object_kg) * kept
        assert left == pytest.approx(tow.thrust.mass_kg - tow.thrust.propellant_kg, abs=1e-9)
        other = {"tow": None, "origin": leg.destination, "tow_before": tow}
        launched = alone.model_copy(update=other)
        assert spirals_excess_m_s(launched, masses) == 0.0
        planned = (tow.thrust.mass_kg * kept - object_kg) * math.exp(
            -spirals_excess_m_s(launched.model_copy(update={"after_launch": True}), masses)
            / tow.thrust.exhaust_m_s
        )
        assert planned + object_kg == pytest.approx(left, abs=1e-9)


def test_hurried_spirals_get_more_time() -> None:
    """A spiral that was not found, or left the orbit eccentric, has more time in the next plan."""
    instance, plan = mission()
    leg, tow = spirals()[0]
    planned = plan.legs[leg.leg - 1]
    assert planned.tow is not None
    mean = np.array([*tow.released.position_m, *tow.released.velocity_m_s])
    mean[3:] *= 1.01
    off = tow.released.replace(velocity_m_s=tuple(mean[3:].tolist()))
    stray = with_tow(leg, tow.replace(released=off))
    assert [one.name for one in strayed(instance, stray)] == [leg.destination]
    assert not tuple(strayed(instance, refined()))
    lost = refined().replace(
        legs=[one for one in refined().legs if one is not leg],
        status="incomplete",
        missing=[{"leg": leg.leg, "reason": "no spiral", "tow": leg.destination}],
    )
    had_s = planned.tow.end_s - planned.end_s
    for known in (stray, lost):
        lessons = Lessons(instance)
        lessons.learn(plan, known)
        stay_s = lessons.corrections.stays_s[leg.destination]
        assert stay_s + planned.tow.end_s - planned.tow.start_s == pytest.approx(1.5 * had_s)
        assert not lessons.corrections.barred_s
        again = problem_of(instance).corrected(lessons.corrections)
        found = adr_opt.solve(again, method="greedy-guarded").plan
        assert found is not None
        assert not adr_opt.check(instance, found)
        for one in found.legs:
            if one.destination == leg.destination and one.tow is not None:
                assert one.tow.end_s - one.end_s > 1.5 * had_s - 1.0


def test_tows_out_of_order_are_refused() -> None:
    """A plan whose tow by low thrust ends before it begins is refused in a sentence."""
    instance, plan = mission()
    (route,) = plan.routes
    legs = [
        leg if leg.tow is None else leg.replace(tow=leg.tow.replace(start_s=leg.tow.end_s + 1.0))
        for leg in route.legs
    ]
    with pytest.raises(InputError, match="by low thrust has no burns"):
        adr_opt.refine(instance, plan.replace(routes=(route.replace(legs=tuple(legs)),)))


def test_the_ephemeris_of_spirals_has_no_gaps() -> None:
    """Arcs of a refined flight with spirals join each other in time and place."""
    arcs = [track.arc for track in tracks(refined(), step_s=600.0)]
    assert sum(arc.phase == "tow" for arc in arcs) == len(spirals())
    for first, second in pairwise(arcs):
        assert second.times_s[0] == pytest.approx(first.times_s[-1], abs=1e-3)
        assert np.linalg.norm(second.positions_m[0] - first.positions_m[-1]) < 10.0


def test_spirals_are_in_no_message_or_script(tmp_path: Path) -> None:
    """An ephemeris and a scene have spirals; messages and scripts are refused in a sentence."""
    path = tmp_path / "flight"
    for format in ("script", "ocm"):
        with pytest.raises(InputError, match=r"spiral of its tow is not written.*write \.oem"):
            write_refined(mission()[0], refined(), path, file=FlightFile(format=format))
        assert not path.exists()
    for format in ("oem", "czml"):
        write_refined(mission()[0], refined(), path, file=FlightFile(format=format))
        assert path.stat().st_size > 0
