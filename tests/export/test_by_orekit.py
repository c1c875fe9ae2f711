"""Messages as Orekit reads them: the program that the page on exports names."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path

import by_orekit
import numpy as np
import pytest
from electric_fields import electric

import adr_opt
from adr_opt.export.flights import FlightFile, write_plan
from adr_opt.export.flights.refined_oem import write_refined
from adr_opt.export.flights.thrust_history import thrust_windows
from adr_opt.fly.refine.bodies import moved, state_of
from adr_opt.fly.trajectory.axes import axes_of
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.frame import FRAMES, Frame
from adr_opt.problem.frame_rotation import rotation
from adr_opt.problem.instance import Instance

pytestmark = pytest.mark.slow

Array = np.ndarray
EPOCH = datetime(2025, 2, 27, 6, 30, 15, 250_000, tzinfo=UTC)
TANK = TankByMass(dry_mass_kg=400.0, propellant_kg=900.0, isp_s=310.0)
GCRF = Frame(name="GCRF")


@pytest.fixture(autouse=True)
def _orekit() -> None:
    by_orekit.need()


def teme(epoch: datetime) -> Frame:
    return Frame(name="TEME", axes_epoch=epoch)


@cache
def mission(has_mass: bool = True) -> tuple[Instance, Plan, RefinedPlan]:
    """A tiny field in TEME and two-body motion, its plan, and that refined."""
    instance = adr_opt.generate("tiny", 0).replace(epoch=EPOCH, frame=teme(EPOCH))
    if has_mass:
        instance = instance.replace(chasers=(instance.chaser.replace(tank=TANK),))
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    assert len(plan.legs) > 2
    return instance, plan, adr_opt.refine(instance, plan, gravity="two-body")


@pytest.mark.parametrize("frame", [None, *FRAMES])
def test_orekit_reads_the_states_of_an_oem(frame: str | None, tmp_path: Path) -> None:
    """Each segment has the states of its arc, to a millimetre, in the frame of the name."""
    instance, plan, _ = mission()
    flight = write_plan(instance, plan, tmp_path / "a.oem", file=FlightFile(frame=frame))
    axes = axes_of(instance, frame)
    segments = list(by_orekit.read(tmp_path / "a.oem").getSegments())
    arcs = [arc for _, arc in flight.arcs()]
    for segment, arc in zip(segments, arcs, strict=True):
        assert str(segment.getFrame().getName()) == (frame or "GCRF").replace("ICRF", "GCRF")
        states = list(segment.getCoordinates())
        assert len(states) == arc.times_s.size
        for at in (0, -1):
            read = by_orekit.state(states[at])
            time_s = by_orekit.seconds(states[at].getDate(), instance.epoch)
            assert time_s == pytest.approx(arc.times_s[at], abs=1e-6)
            late = time_s - arc.times_s[at]
            true = axes.turned(arc.positions_m[at] + late * arc.rates_m_s[at])
            assert np.linalg.norm(read[:3] - true) < 1e-3
            assert np.linalg.norm(read[3:] - axes.turned(arc.rates_m_s[at])) < 1e-6


def goal(instance: Instance, one: RefinedPlan, number: int) -> Array:
    """Where the destination of a leg is at the end of its approach, in GCRF."""
    leg = one.legs[number]
    (body,) = (state_of(each) for each in one.bodies if each.name == leg.destination)
    state = moved(body, leg.arrival_s, one.gravity)
    return axes_of(instance).turned(state.reshape(2, 3)).ravel()


def test_orekit_flies_an_opm_to_every_target(tmp_path: Path) -> None:
    """Read and flown by Orekit, each leg ends at its target, and each burn takes mass."""
    instance, _, one = mission()
    for number, leg in enumerate(one.legs):
        write_refined(instance, one, tmp_path / "a.opm", file=FlightFile("opm"), leg=leg.leg)
        read = by_orekit.read(tmp_path / "a.opm")
        assert str(read.getMetadata().getFrame().getName()) == "GCRF"
        start = read.getData().getStateVectorBlock()
        now = by_orekit.seconds(start.getEpoch(), instance.epoch)
        state = by_orekit.state(start.toTimeStampedPVCoordinates())
        burns = list(read.getManeuvers())
        assert len(burns) == len(leg.impulses)
        for burn in burns:
            time_s = by_orekit.seconds(burn.getEpochIgnition(), instance.epoch)
            state, now = by_orekit.coasted(state, time_s - now), time_s
            state[3:] += by_orekit.vector(burn.getDV())
            assert float(burn.getDeltaMass()) < 0.0
        state = by_orekit.coasted(state, leg.arrival_s - now)
        assert np.linalg.norm(state[:3] - goal(instance, one, number)[:3]) < 0.1


@pytest.mark.parametrize("has_mass", [True, False])
def test_orekit_flies_an_ocm_to_every_target(has_mass: bool, tmp_path: Path) -> None:
    """Read and flown by Orekit, the states and tables of burns lead to every target."""
    instance, _, one = mission(has_mass)
    write_refined(instance, one, tmp_path / "a.ocm", file=FlightFile("ocm"))
    data = by_orekit.read(tmp_path / "a.ocm").getSegments().get(0).getData()
    starts = list(data.getTrajectoryBlocks().get(0).getCoordinates())
    blocks = list(data.getManeuverBlocks())
    assert len(starts) == len(blocks) == len(one.legs)
    for number, (leg, start, block) in enumerate(zip(one.legs, starts, blocks, strict=True)):
        now, state = by_orekit.seconds(start.getDate(), instance.epoch), by_orekit.state(start)
        for burn in block.getManeuvers():
            time_s = by_orekit.seconds(burn.getDate(), instance.epoch)
            state, now = by_orekit.coasted(state, time_s - now), time_s
            state[3:] += by_orekit.vector(burn.getDv())
            assert (float(burn.getDeltaMass()) < 0.0) == has_mass
        state = by_orekit.coasted(state, leg.arrival_s - now)
        assert np.linalg.norm(state[:3] - goal(instance, one, number)[:3]) < 0.1


def test_orekit_reads_the_thrust_of_an_ocm(tmp_path: Path) -> None:
    """Rows of low thrust have the forces, masses and specific impulse of the windows."""
    instance = electric(1, targets=6)
    instance = instance.replace(frame=teme(instance.epoch))
    plan = adr_opt.solve(instance, method="greedy-guarded").plan
    one = adr_opt.refine(instance, plan)
    write_refined(instance, one, tmp_path / "a.ocm", file=FlightFile("ocm"), leg=1)
    data = by_orekit.read(tmp_path / "a.ocm").getSegments().get(0).getData()
    blocks = [
        block
        for block in data.getManeuverBlocks()
        if "THRUST" in str(block.getMetadata().getManID())
    ]
    rows = [row for block in blocks for row in block.getManeuvers()]
    windows = thrust_windows(one.legs[0], one.gravity)
    forces = axes_of(instance).turned(np.concatenate([each.forces_n for each in windows]))
    assert len(rows) == len(forces)
    read = np.array([by_orekit.vector(row.getThrust()) for row in rows])
    assert np.abs(read - forces).max() < 1e-9
    lost = sum(float(row.getDeltaMass()) for row in rows)
    assert lost == pytest.approx(sum(each.after_kg - each.before_kg for each in windows))
    last = [row for row in rows if float(row.getDuration()) == 0.0]
    assert len(last) == len(windows)
    exhaust_m_s = 9.80665 * float(rows[0].getThrustIsp())
    assert exhaust_m_s == pytest.approx(one.legs[0].thrust.exhaust_m_s)


def test_gcrf_is_what_orekit_turns_teme_to() -> None:
    """By models of 1976 and 1980, to 0.1 arc seconds; the pole is that of 2010 to one in 1,000."""
    from org.orekit.frames import FramesFactory
    from org.orekit.utils import IERSConventions

    second = np.radians(1.0 / 3600.0)
    for year in (2000, 2010, 2020, 2025):
        time = datetime(year, 2, 27, 6, 30, tzinfo=UTC)
        ours, date = rotation(teme(time), GCRF), by_orekit.date_of(time)
        theirs = by_orekit.to_gcrf(FramesFactory.getTEME(), date)
        assert np.linalg.norm(ours - theirs, 2) < 0.1 * second
        of_date = FramesFactory.getTOD(IERSConventions.IERS_2010, False)
        pole = by_orekit.to_gcrf(of_date, date)[:, 2]
        assert np.linalg.norm(pole - ours[:, 2]) < 1e-3 * second


def test_orekit_takes_teme_for_that_of_each_state(tmp_path: Path) -> None:
    """Why exports are in GCRF: states in TEME of the epoch, as read, are metres off after days."""
    instance, plan, _ = mission()
    write_plan(instance, plan, tmp_path / "a.oem", file=FlightFile(frame="TEME"))
    frame = by_orekit.read(tmp_path / "a.oem").getSegments().get(0).getFrame()
    stated = rotation(teme(EPOCH), GCRF)
    for days, least_m, most_m in ((0.0, 0.0, 2.0), (10.0, 10.0, 100.0)):
        date = by_orekit.date_of(EPOCH + timedelta(days=days))
        off_m = 7.1e6 * np.linalg.norm(by_orekit.to_gcrf(frame, date) - stated, 2)
        assert least_m <= off_m < most_m
