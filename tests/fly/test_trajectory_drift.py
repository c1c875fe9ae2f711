"""The flown plan as states over time, where nodes drift."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from drifting_plans import DAY_S, drifting_instance, drifting_plan

from adr_opt.fly.trajectory import body_states, sample
from adr_opt.fly.trajectory.sampling import LONG_STEP_S, STEP_S, Arc, LegPath
from adr_opt.kernels.orbits import columns, ephemeris

DOCKED = ("wait", "service")


def arcs_of_flight(eccentricity: float = 0.0) -> list[tuple[LegPath, Arc]]:
    instance, plan = drifting_instance(eccentricity), drifting_plan(eccentricity)
    return list(sample(instance, plan).arcs())


def node_deg(arc: Arc, at: int) -> float:
    """RAAN of the plane of position and velocity at a sample."""
    normal = np.cross(arc.positions_m[at], arc.velocities_m_s[at])
    return math.degrees(math.atan2(normal[0], -normal[1]))


@pytest.mark.parametrize("eccentricity", [0.0, 0.003])
def test_arcs_follow_each_other(eccentricity: float) -> None:
    """Each arc begins when and where the one before ended, weeks of drift later; docking is cm.

    Between orbits that are eccentric the approach leaves decimetres: their latitudes do not advance
    quite as those of the circles on which it is flown.
    """
    for (_, before), (_, after) in pairwise(arcs_of_flight(eccentricity)):
        step = np.linalg.norm(after.positions_m[0] - before.positions_m[-1])
        docks = before.phase == "approach" and after.phase in DOCKED
        assert after.start_s == pytest.approx(before.end_s, abs=1e-9)
        assert step < ((0.5 if eccentricity else 0.1) if docks else 1e-3)


def test_phases_are_those_of_the_burns() -> None:
    """The short leg phases, the other drifts; docked before the stated arrival the chaser waits."""
    phases: dict[int, list[str]] = {1: [], 2: []}
    for path, arc in arcs_of_flight():
        phases[path.number].append(arc.phase)
    assert phases[1] == [
        "wait",
        "hohmann-1",
        "phasing",
        "co-elliptic",
        "terminal",
        "approach",
        "service",
    ]
    assert phases[2] == [
        "wait",
        "hohmann-1",
        "drift",
        "co-elliptic",
        "terminal",
        "approach",
        "wait",
        "service",
    ]
    leg = drifting_plan().legs[1]
    *_, docked, service = (arc for path, arc in arcs_of_flight() if path.number == 2)
    assert docked.start_s == leg.burns[-1].time_s < leg.arrival_s == docked.end_s
    assert (service.start_s, service.end_s) == (leg.arrival_s, leg.end_s)


def test_burns_are_the_steps_of_the_velocity() -> None:
    """Where an arc meets the next the velocity steps by the burns of that time, by nothing else."""
    met = 0
    for (path, before), (_, after) in pairwise(arcs_of_flight()):
        if before.phase == "service" or after.phase in DOCKED:
            continue
        burned = sum(
            np.array(burn.delta_v_m_s) for burn in path.leg.burns if burn.time_s == after.start_s
        )
        step = after.velocities_m_s[0] - before.velocities_m_s[-1]
        assert np.linalg.norm(step - burned) < 1e-6
        met += 1
    assert met == 10


@pytest.mark.parametrize("eccentricity", [0.0, 0.003])
def test_legs_meet_their_targets(eccentricity: float) -> None:
    """The last sample before the approach is at the stand-off, to a metre, the last of it docked.

    The stand-off is 1 km behind the target, in its orbit; states of bodies are those of the kernel.
    """
    instance = drifting_instance(eccentricity)
    rows = dict(zip(instance.names, instance.orbits(), strict=True))
    approaches = [
        (path, arc) for path, arc in arcs_of_flight(eccentricity) if arc.phase == "approach"
    ]
    assert len(approaches) == 2
    for path, arc in approaches:
        row = rows[path.leg.destination]
        behind = row.copy()
        behind[columns.ARGUMENT_OF_LATITUDE] -= instance.transfer.standoff_m / row[columns.RADIUS]
        goal, velocity = ephemeris.state_at(behind, arc.start_s)
        assert np.linalg.norm(arc.positions_m[0] - goal) < 1.0
        terminal = next(arc for arc in path.arcs if arc.phase == "terminal")
        assert np.linalg.norm(terminal.positions_m[-1] - goal) < 1.0
        assert np.linalg.norm(arc.velocities_m_s[0] - velocity) < 1.0  # its first impulse
        docked = ephemeris.state_at(row, arc.end_s)[0]
        assert np.linalg.norm(arc.positions_m[-1] - docked) < 1.0


def test_states_are_those_of_the_flight() -> None:
    """Every tenth sample is where the other implementation of the mean dynamics gets, to 1 cm."""
    mean = pytest.importorskip("adr_opt.fly.flight.mean_flight")
    pytest.importorskip("boinor")
    instance, motion = drifting_instance(), mean.MeanDynamics()
    circles = dict(zip(instance.names, instance.body_orbits, strict=True))
    seen = set()
    for path, arc in arcs_of_flight():
        leg, seen = path.leg, seen | {arc.phase}
        state = motion.body(circles[leg.origin], leg.burns[0].time_s)
        for burn, after in pairwise(leg.burns):
            state = state[0], state[1] + np.array(burn.delta_v_m_s)
            if burn.time_s == arc.start_s < after.time_s:
                break
            state = motion.coast(state, after.time_s - burn.time_s)
        for at in range(0, arc.times_s.size, max(1, arc.times_s.size // 10)):
            time = float(arc.times_s[at])
            if arc.phase in DOCKED:
                body = leg.origin if time < leg.burns[0].time_s else leg.destination
                found = motion.body(circles[body], time)
            else:
                found = motion.coast(state, time - arc.start_s)
            assert np.linalg.norm(arc.positions_m[at] - found[0]) < 1e-2, arc.phase
            assert np.linalg.norm(arc.velocities_m_s[at] - found[1]) < 1e-5, arc.phase
    assert {"drift", "phasing", "wait", "service"} <= seen


def test_planes_turn_as_they_say() -> None:
    """The node of every arc moves at its rate: by a hundred degrees while the chaser drifts."""
    for _, arc in arcs_of_flight():
        turned = math.degrees(arc.node_rate_rad_s) * (arc.end_s - arc.start_s)
        off = node_deg(arc, -1) - node_deg(arc, 0) - turned
        assert abs(math.remainder(off, 360.0)) < 1e-6
        if arc.phase == "drift":
            assert turned == pytest.approx(-101.7, abs=0.5)


def test_rates_are_those_of_the_positions() -> None:
    """Positions change by ``rates_m_s``, metres per second from the velocities in the plane."""
    instance, plan = drifting_instance(), drifting_plan()
    for _, arc in sample(instance, plan, 20.0).arcs():
        span = (arc.times_s[2:] - arc.times_s[:-2])[:, None]
        measured = (arc.positions_m[2:] - arc.positions_m[:-2]) / span
        # The central difference is short by a sixth of the square of the angle.
        short = (2.0 * math.pi / 6000.0 * span.max() / 2.0) ** 2 / 6.0 * 7500.0
        assert np.linalg.norm(measured - arc.rates_m_s[1:-1], axis=1).max() < 1.2 * short
        apart = np.linalg.norm(arc.rates_m_s - arc.velocities_m_s, axis=1)
        assert apart.min() > 3.0


def test_bodies_drift() -> None:
    """Waiting bodies are on the circles of the kernels at the times asked for."""
    instance = drifting_instance(0.003)
    times = np.linspace(0.0, 60 * DAY_S, 13)
    for name, row in zip(instance.names, instance.orbits(), strict=True):
        positions, velocities = body_states(instance, name, times)
        for time, r, v in zip(times, positions, velocities, strict=True):
            r_0, v_0 = ephemeris.state_at(row, time)
            assert np.linalg.norm(r - r_0) < 1e-3
            assert np.linalg.norm(v - v_0) < 1e-6


def test_weeks_are_sampled_less_often_than_hours() -> None:
    """Unless a step is asked for, arcs of more than a day have a state every five minutes."""
    instance, plan = drifting_instance(), drifting_plan()
    for _, arc in sample(instance, plan).arcs():
        longest = LONG_STEP_S if arc.end_s - arc.start_s > DAY_S else STEP_S
        assert 0.9 * longest < np.diff(arc.times_s).max() <= longest * (1.0 + 1e-9)
    assert sample(instance, plan).step_s == LONG_STEP_S
    finer = sample(instance, plan, 60.0)
    assert max(np.diff(arc.times_s).max() for _, arc in finer.arcs()) <= 60.0 * (1.0 + 1e-9)
    sizes = [sum(arc.times_s.size for _, arc in way) for way in (finer.arcs(), arcs_of_flight())]
    assert sizes[0] > 80_000
    assert sizes[1] < 25_000
