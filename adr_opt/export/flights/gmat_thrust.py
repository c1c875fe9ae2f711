"""Low thrust in GMAT's terms: a tank, and a file of the history of thrust beside the script.

A ``FiniteBurn`` has one direction in one set of axes, and the law of steering another one at every
place. So thrust is a ``ThrustHistoryFile``: force and mass flow at points of time, in the inertial
axes of the script, and linear between. Each window is a ``ThrustSegment``. The script turns thrust
on and off after propagations of the exact length; segments last a little longer, since they begin
at whole milliseconds and no step may end outside of them.
"""

from __future__ import annotations

import math
import os
from collections.abc import Generator, Iterator
from datetime import datetime
from pathlib import Path

import numpy as np

from ...common.constants import STANDARD_GRAVITY_M_S2
from ...common.errors import InputError
from ...fly.trajectory.axes import Axes
from ...fly.trajectory.clock import UtcClock
from ...problem.instance import Instance
from .course import CourseLeg, FlightCourse, Propulsion, ThrustWindow
from .thrust_history import STEP_S

MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


def whole_millisecond(instance: Instance, time_s: float) -> float:
    """Nearest time with whole milliseconds in the calendar, the resolution of GMAT."""
    beyond_s = instance.epoch.microsecond % 1000 / 1e6
    return round((time_s + beyond_s) * 1e3) / 1e3 - beyond_s


def gregorian(time: datetime) -> str:
    """A time in GMAT's format, in English whatever the locale."""
    month = MONTHS[time.month - 1]
    return (
        f"{time.day:02d} {month} {time.year:04d} {time.hour:02d}:{time.minute:02d}:"
        f"{time.second:02d}.{time.microsecond // 1000:03d}"
    )


TANK, HISTORY, MODEL, PROPAGATOR = "Propellant", "Thrust", "Powered", "Push"

BEYOND_S = 2e-3
"""Margin whose half separates at least the ends of a segment from those of its window [s]."""

DENSITY_KG_M3 = 1000.0

NOTE = (
    "Thrust is in the file {file}, beside this one; start GMAT from their folder, or write that "
    "file's path into Thrust.FileName. At the beginning of each leg the chaser is as heavy as "
    "planned; kits aboard count as propellant."
)


def history_path(script: str | os.PathLike[str]) -> Path:
    """Path of a script's thrust history: beside it, with the suffix ``.thrust``.

    Raises
    ------
    InputError
        The script has that suffix itself, or a name that scripts cannot quote.
    """
    path = Path(script).with_suffix(".thrust")
    if path == Path(script) or not path.name.isascii() or "'" in path.name:
        raise InputError(
            f"{script}: thrust would be written to {path.name}, beside the script; choose a name "
            "in ASCII, with another suffix and without quotation marks"
        )
    return path


def note(file: str) -> str:
    """A sentence on the second file."""
    return NOTE.format(file=file)


def hardware(course: FlightCourse, chaser: str, file: str) -> Iterator[str]:
    """Tank and history of a course with low thrust; ``file`` has the history."""
    assert course.propulsion is not None
    heaviest = max(course.begins_kg(leg) or 0.0 for leg in course.legs)
    room = math.ceil(2.0 * heaviest / DENSITY_KG_M3)
    yield from (
        "",
        f"Create ChemicalTank {TANK};",
        f"GMAT {TANK}.AllowNegativeFuelMass = false;",
        f"GMAT {TANK}.FuelMass = {_fuel(course, course.legs[0]):.9f};",
        f"GMAT {TANK}.FuelDensity = {DENSITY_KG_M3:g};",
        f"GMAT {TANK}.Volume = {room};",
        f"GMAT {TANK}.PressureModel = PressureRegulated;",
        f"GMAT {chaser}.DryMass = {course.propulsion.dry_kg:.9f};",
        f"GMAT {chaser}.Tanks = {{{TANK}}};",
    )
    names = [name for name, _ in _segments(course)]
    for name in names:
        yield ""
        yield f"Create ThrustSegment {name};"
        yield f"GMAT {name}.MassSource = {{{TANK}}};"
    yield ""
    yield f"Create ThrustHistoryFile {HISTORY};"
    yield f"GMAT {HISTORY}.AddThrustSegment = {{{', '.join(names)}}};"
    yield f"GMAT {HISTORY}.FileName = '{file}';"


def powered(model: str, gravity: Iterator[str]) -> Iterator[str]:
    """A propagator for windows, in the field of another model.

    Its steps are those of the history. Longer ones, of whatever control of errors, run across the
    kinks of a force that is linear piece by piece, and that adds up to kilometres in a leg.
    """
    for line in gravity:
        yield line.replace(model, MODEL)
    yield f"GMAT {MODEL}.ErrorControl = None;"
    yield from (
        "",
        f"Create Propagator {PROPAGATOR};",
        f"GMAT {PROPAGATOR}.FM = {MODEL};",
        f"GMAT {PROPAGATOR}.Type = RungeKutta89;",
        f"GMAT {PROPAGATOR}.InitialStepSize = {STEP_S:g};",
        f"GMAT {PROPAGATOR}.MinStep = 0;",
        f"GMAT {PROPAGATOR}.MaxStep = {STEP_S:g};",
    )


def decremented(propulsion: Propulsion, burn: str) -> Iterator[str]:
    """Commands that subtract the propellant of an impulse."""
    yield f"GMAT {burn}.DecrementMass = true;"
    yield f"GMAT {burn}.Tank = {{{TANK}}};"
    yield f"GMAT {burn}.Isp = {propulsion.exhaust_m_s / STANDARD_GRAVITY_M_S2:.12g};"
    yield f"GMAT {burn}.GravitationalAccel = {STANDARD_GRAVITY_M_S2:g};"


def fuelled(course: FlightCourse, leg: CourseLeg, chaser: str) -> str:
    """Command that sets the mass at the beginning of a leg."""
    return f"GMAT {chaser}.{TANK}.FuelMass = {_fuel(course, leg):.9f};"


def pushed(
    leg: CourseLeg, window: ThrustWindow, crew: str, chaser: str
) -> Generator[str, None, float]:
    """Thrust for a window, from its beginning; returns its end [s]."""
    yield f"BeginFileThrust {HISTORY}({chaser});"
    yield (
        f"Propagate 'leg {leg.number}: thrust' {PROPAGATOR}({crew}) "
        f"{{{chaser}.ElapsedSecs = {window.end_s - window.start_s:.9f}}};"
    )
    yield f"EndFileThrust {HISTORY}({chaser});"
    return window.end_s


def history(course: FlightCourse, axes: Axes, system: str) -> str:
    """The second file: for each window, time, force [N] and mass flow [kg/s]."""
    return "\n".join(_history(course, axes, system)) + "\n"


def _history(course: FlightCourse, axes: Axes, system: str) -> Iterator[str]:
    clock = UtcClock(course.instance)
    for name, window in _segments(course):
        begin = whole_millisecond(course.instance, window.start_s - 0.75 * BEYOND_S)
        times, forces = window.times_s - begin, axes.turned(window.forces_n)
        times = np.r_[0.0, times, times[-1] + 0.75 * BEYOND_S]
        yield f"BeginThrust {{{name}}}"
        yield f"Start_Epoch = {gregorian(datetime.fromisoformat(clock.label(begin)))}"
        yield f"Thrust_Vector_Coordinate_System = {system}"
        yield "Thrust_Vector_Interpolation_Method = Linear"
        yield "Mass_Flow_Rate_Interpolation_Method = Linear"
        yield "ModelThrustAndMassRate"
        for time, (x, y, z) in zip(times, forces[[0, *range(len(forces)), -1]], strict=True):
            yield f"{time:.9f} {x:.14f} {y:.14f} {z:.14f} {window.flow_kg_s:.16e}"
        yield f"EndThrust {{{name}}}"


def _segments(course: FlightCourse) -> Iterator[tuple[str, ThrustWindow]]:
    """All windows with their names."""
    for leg in course.legs:
        for number, window in enumerate(leg.windows, start=1):
            yield f"Leg{leg.number}Window{number}", window


def _fuel(course: FlightCourse, leg: CourseLeg) -> float:
    """Mass beyond the dry mass at the beginning of a leg [kg]."""
    assert course.propulsion is not None
    return (course.begins_kg(leg) or 0.0) - course.propulsion.dry_kg
