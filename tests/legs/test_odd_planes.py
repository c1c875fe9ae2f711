"""Planes whose drift is a special case: polar, equatorial, retrograde, alike; and long drifts."""

from __future__ import annotations

import math

import numpy as np
import pytest

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.fly.flight import fly
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import MissionSettings
from adr_opt.problem.transfer_sizes import transfers_for
from adr_opt.sources.generator import EPOCH

PLANES = {
    "polar": (90.0, 90.0, 90.0, 90.0),
    "nearly polar": (90.0, 90.0 + 1e-9, 90.0 - 1e-6, 90.03),
    "equatorial": (0.0, 0.0, 0.0, 0.0),
    "nearly equatorial": (0.0, 1e-9, 1e-4, 0.5),
    "retrograde": (98.0, 98.5, 97.5, 98.2),
    "backwards": (180.0, 180.0, 179.5, 179.9),
    "both sides of the pole": (88.0, 92.0, 89.5, 90.5),
    "critical": (63.4349488, 63.4349488, 63.0, 116.5650512),
    "opposite": (30.0, 150.0, 30.5, 30.2),
}
"""Inclinations of a station and three targets [deg]."""


def orbit(altitude_km: float, inclination_deg: float, raan_deg: float) -> Orbit:
    """A circle, somewhere on which the body is at t = 0."""
    return Orbit(
        semi_major_axis_m=6378137.0 + 1e3 * altitude_km,
        eccentricity=0.0,
        inclination_deg=inclination_deg,
        raan_deg=raan_deg,
        argument_of_perigee_deg=0.0,
        true_anomaly_deg=(7.0 * altitude_km) % 360.0,
    )


def mission(
    inclinations: tuple[float, ...],
    altitudes_km: tuple[float, ...] = (750.0, 780.0, 820.0, 700.0),
    nodes: tuple[float, ...] = (0.0, 4.0, -6.0, 20.0),
    days: float = 60.0,
) -> Instance:
    """A station and targets in some planes, for so many days under J2."""
    home, *orbits = map(orbit, altitudes_km, inclinations, nodes)
    return Instance(
        name="odd planes",
        epoch=EPOCH,
        dynamics="j2",
        stations=(Station(name="station", orbit=home),),
        targets=tuple(
            Target(name=f"target {number}", orbit=there) for number, there in enumerate(orbits)
        ),
        chasers=(
            Chaser(name="chaser", start=AtStation(station="station"), tank=Tank(delta_v_m_s=3e3)),
        ),
        mission=MissionSettings(duration_s=days * DAY_S),
        transfer=transfers_for(days * DAY_S),
    )


def connections(instance: Instance) -> list[np.ndarray]:
    """Departures, arrivals and ΔV of all pairs."""
    table = adr_opt.Timetable(instance)
    bodies = range(len(instance.names))
    found = [table.connections(i, j) for i in bodies for j in bodies]
    return [array for one in found for array in (one.departure, one.arrival, one.delta_v)]


@pytest.mark.parametrize("planes", PLANES)
@pytest.mark.slow
def test_special_planes_are_planned_proven_and_flown(planes: str) -> None:
    """A plan among them passes the check, meets its targets in flight, and no bound is below it."""
    instance = mission(PLANES[planes])
    assert all(np.all(np.isfinite(array)) for array in connections(instance))
    result = adr_opt.solve(instance, "beam", time_limit=60.0, width=50)
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    bound = adr_opt.bound(instance, "lagrangian", time_limit=60.0, iterations=20)
    assert bound.upper_bound >= result.objective
    if result.plan.legs:
        assert fly(instance, result.plan).worst_miss_m < 1.0
    if planes not in ("opposite", "critical"):
        assert result.objective >= 1.0


def test_planes_that_never_meet_are_left_alone() -> None:
    """With equal rates and a small tank there is no way between two planes, and a plan says so."""
    alike = mission((71.0,) * 4, (840.0,) * 4, (0.0, 90.0, 180.0, 270.0))
    poor = alike.with_limits(delta_v_m_s=200.0)
    assert all(array.size == 0 for array in connections(poor))
    result = adr_opt.solve(poor, "exact", time_limit=60.0)
    assert (result.objective, result.status) == (0.0, "optimal")
    assert result.plan is not None
    assert {entry.reason for entry in result.plan.unvisited} <= {"no-transfer", "delta-v"}
    # A drift orbit is another matter: it has a rate of its own.
    rich = alike.replace(
        mission=alike.mission.replace(duration_s=730.0 * DAY_S),
        transfer=transfers_for(730.0 * DAY_S),
    )
    found = adr_opt.Timetable(rich).connections("station", "target 0")
    assert found.delta_v.min() < 1000.0
    assert np.all(found.revolutions[found.delta_v < 1000.0] == -1)


def test_equal_orbits_are_reached_whenever_one_likes() -> None:
    """Two bodies on one circle, half a turn apart: phasing is all that it takes."""
    instance = mission((98.0,) * 4, (750.0, 750.0, 750.1, 749.0), (10.0,) * 4)
    found = adr_opt.Timetable(instance).connections("station", "target 0")
    assert found.departure.size > 0
    assert found.delta_v.min() < 60.0
    result = adr_opt.solve(instance, "beam", time_limit=60.0, width=50)
    assert result.objective == 3.0
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()


@pytest.mark.parametrize("factor", [1.0 + 1e-9, 2.0, 1e3, math.inf])
def test_drifts_beyond_the_mission_are_as_good_as_none(factor: float) -> None:
    """A longest drift that the mission cannot hold changes nothing; infinity is refused."""
    instance = mission(PLANES["retrograde"], days=40.0)
    longest = instance.transfer.max_drift_s * factor
    if math.isinf(factor):
        with pytest.raises(adr_opt.InputError, match="max_drift_s"):
            instance.transfer.replace(max_drift_s=longest)
        return
    longer = instance.replace(transfer=instance.transfer.replace(max_drift_s=longest))
    for ours, theirs in zip(connections(instance), connections(longer), strict=True):
        assert np.array_equal(ours, theirs)


def test_a_grid_coarser_than_the_mission_has_no_long_transfers() -> None:
    """One step that is longer than the mission leaves short transfers alone."""
    instance = mission(PLANES["retrograde"], days=20.0)
    coarse = instance.replace(transfer=instance.transfer.replace(drift_step_s=21.0 * DAY_S))
    short = instance.replace(transfer=instance.transfer.replace(max_drift_s=0.0))
    for ours, theirs in zip(connections(coarse), connections(short), strict=True):
        assert np.array_equal(ours, theirs)
