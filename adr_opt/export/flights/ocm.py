"""``.ocm``: states, masses and thrust of a flight, as a CCSDS Orbit Comprehensive Message.

502.0-B-3, section 6. Unlike a burn of an OPM, which has one direction, a manoeuvre here is a table
of thrust over time (tables 6-7 and 6-8): low thrust of a leg is one such table, and its impulses
are another one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2, STANDARD_GRAVITY_M_S2
from ...fly.trajectory.axes import Axes
from ...fly.trajectory.clock import UtcClock
from ...fly.trajectory.kepler import Array
from .course import CourseLeg, FlightCourse, ThrustWindow
from .kvn import OBJECT_ID, comment, header, object_name

VERSION = "3.0"


class StateAt(NamedTuple):
    """A state in the frame of the elements [m, m/s] at a time in whole microseconds [s]."""

    time_s: float
    state: Array


def to_ocm(
    course: FlightCourse, axes: Axes, object_id: str | None, starts: Sequence[StateAt]
) -> str:
    """The message in key-value notation.

    Parameters
    ----------
    course : FlightCourse
    axes : Axes
    object_id : str or None
        The chaser's, if it has any.
    starts : sequence of StateAt
        The chaser at the beginning of each leg.
    """
    return "\n".join(_lines(course, axes, object_id, starts)) + "\n"


def _lines(
    course: FlightCourse, axes: Axes, object_id: str | None, starts: Sequence[StateAt]
) -> Iterator[str]:
    clock = UtcClock(course.instance)
    yield from header("CCSDS_OCM_VERS", course.said, VERSION)
    yield from (
        "",
        "META_START",
        f"OBJECT_NAME = {object_name(course.chaser)}",
        f"INTERNATIONAL_DESIGNATOR = {object_id or OBJECT_ID}",
        "TIME_SYSTEM = UTC",
        f"EPOCH_TZERO = {clock.label(starts[0].time_s)}",
        "META_STOP",
    )
    yield from _states(course, axes, clock, starts)
    mass = course.begins_kg(course.legs[0])
    if mass is not None:
        yield from ("", "PHYS_START")
        yield from comment("With propellant and kits, at the beginning of the first leg")
        yield f"WET_MASS = {mass:.6f} [kg]"
        if course.propulsion is not None:
            yield f"DRY_MASS = {course.propulsion.dry_kg:.6f} [kg]"
        yield "PHYS_STOP"
    for leg in course.legs:
        for number, run in enumerate(_runs(clock, leg.windows), start=1):
            yield from _thrust(course, leg, number, run, axes, clock)
        if leg.all_impulses:
            yield from _impulses(course, leg, axes, clock)
    yield from ("", "PERT_START")
    yield f"EQUATORIAL_RADIUS = {EARTH_RADIUS_M / 1e3:.3f} [km]"
    yield f"GM = {MU_M3_S2 / 1e9:.10g} [km**3/s**2]"
    yield "PERT_STOP"


def _states(
    course: FlightCourse, axes: Axes, clock: UtcClock, starts: Iterable[StateAt]
) -> Iterator[str]:
    yield from ("", "TRAJ_START")
    yield from comment(
        "The chaser at the beginning of each leg, where it is docked or has released a towed "
        "object. Thrust and burns below lead from each to the end of its leg; the next one begins "
        "at rest with the target again."
    )
    yield "TRAJ_BASIS = SIMULATED"
    yield "CENTER_NAME = EARTH"
    yield f"TRAJ_REF_FRAME = {axes.frame.name}"
    yield from _frame_epoch("TRAJ", axes, course, clock)
    yield "TRAJ_TYPE = CARTPV"
    for time_s, state in starts:
        r, v = axes.turned(state[:3]) / 1e3, axes.turned(state[3:]) / 1e3
        parts = " ".join([*(f"{part:.9f}" for part in r), *(f"{part:.12f}" for part in v)])
        yield f"{clock.label(time_s)} {parts}"
    yield "TRAJ_STOP"


def _runs(
    clock: UtcClock, windows: Iterable[ThrustWindow]
) -> Iterator[list[tuple[ThrustWindow, list[str]]]]:
    """Windows with their times as labels, parted where one begins as the one before it ends.

    A table has each time once (section 6.2.2.4).
    """
    run: list[tuple[ThrustWindow, list[str]]] = []
    for window in windows:
        labels = clock.labels(window.times_s)
        if run and run[-1][1][-1] >= labels[0]:
            yield run
            run = []
        run.append((window, labels))
    if run:
        yield run


def _thrust(
    course: FlightCourse,
    leg: CourseLeg,
    number: int,
    run: list[tuple[ThrustWindow, list[str]]],
    axes: Axes,
    clock: UtcClock,
) -> Iterator[str]:
    """A table of thrust: each row lasts until the next one, and the last of a window ends it."""
    assert course.propulsion is not None
    impulse_s = course.propulsion.exhaust_m_s / STANDARD_GRAVITY_M_S2
    first, last = run[0][0], run[-1][0]
    yield from ("", "MAN_START")
    yield from comment(
        f"{leg.title}: low thrust, {len(run)} windows, {first.before_kg:.6f} kg before and "
        f"{last.after_kg:.6f} kg after them. Thrust is the mean over the duty cycle, and linear "
        "between rows"
    )
    yield from _about(f"LEG-{leg.number}-THRUST-{number}", "THRUSTER", course, axes, clock)
    yield (
        "MAN_COMPOSITION = TIME_ABSOLUTE, MAN_DURA, DELTA_MASS, THR_X, THR_Y, THR_Z, THR_INTERP, "
        "THR_ISP"
    )
    yield "MAN_UNITS = [s, kg, N, N, N, n/a, s]"
    for window, labels in run:
        spans = np.append(np.diff(window.times_s), 0.0)
        rows = zip(labels, spans, axes.turned(window.forces_n), strict=True)
        for label, span, (x, y, z) in rows:
            yield (
                f"{label} {span:.6f} {-window.flow_kg_s * span:.12f} {x:.14f} {y:.14f} {z:.14f} "
                f"{'ON' if span else 'OFF'} {impulse_s:.9f}"
            )
    yield "MAN_STOP"


def _impulses(course: FlightCourse, leg: CourseLeg, axes: Axes, clock: UtcClock) -> Iterator[str]:
    """A table of the burns of a leg, with their propellant where masses are known."""
    burnt = course.burnt.get(leg.number)
    yield from ("", "MAN_START")
    phases = ", ".join(burn.phase for burn in leg.all_impulses)
    yield from comment(f"{leg.title}: impulses, of the phases {phases}")
    if burnt:
        before = ", ".join(f"{one.before_kg:.6f}" for one in burnt)
        yield from comment(f"Masses before them: {before} kg")
    yield from _about(f"LEG-{leg.number}-IMPULSES", "IMPULSES", course, axes, clock)
    mass, unit = ("DELTA_MASS, ", "kg, ") if burnt else ("", "")
    yield f"MAN_COMPOSITION = TIME_ABSOLUTE, MAN_DURA, {mass}DV_X, DV_Y, DV_Z"
    yield f"MAN_UNITS = [s, {unit}km/s, km/s, km/s]"
    for number, burn in enumerate(leg.all_impulses):
        lost = f"{-burnt[number].lost_kg:.9f} " if burnt else ""
        x, y, z = axes.turned(np.array(burn.delta_v_m_s)) / 1e3
        yield f"{clock.label(burn.time_s)} 0.000000 {lost}{x:.12f} {y:.12f} {z:.12f}"
    yield "MAN_STOP"


def _about(
    name: str, device: str, course: FlightCourse, axes: Axes, clock: UtcClock
) -> Iterator[str]:
    """First lines of a table of manoeuvres."""
    yield f"MAN_ID = {name}"
    yield "MAN_BASIS = PLANNED"
    yield f"MAN_DEVICE_ID = {device}"
    yield "MAN_PURPOSE = ORBIT"
    yield f"MAN_REF_FRAME = {axes.frame.name}"
    yield from _frame_epoch("MAN", axes, course, clock)
    yield "DC_TYPE = CONTINUOUS"


def _frame_epoch(which: str, axes: Axes, course: FlightCourse, clock: UtcClock) -> Iterator[str]:
    """The epoch of the axes, if they have one."""
    if axes.frame.axes_epoch is not None:
        since_s = (axes.frame.axes_epoch - course.instance.epoch).total_seconds()
        yield f"{which}_FRAME_EPOCH = {clock.label(since_s)}"
