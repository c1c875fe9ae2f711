"""``.script``: the mission as a script of NASA's General Mission Analysis Tool (R2020a and later).

In two-body motion the script names the model's gravitational parameter and point-mass gravity, so
that GMAT, whose propagators are numerical, flies the same mission.

Under J2 the plan flies between mean orbits, and GMAT knows osculating states. The script gives GMAT
the mean orbits as such, Brouwer's of short period, and has it fly in the zonal field of degree 2.
What the mean dynamics leave out then shows: GMAT's chaser passes its targets, at less than a
kilometre after a short leg and at hundreds after weeks of drift, and only docking by the script
brings it there.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Callable, Generator, Iterator
from dataclasses import replace
from datetime import datetime

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...common.errors import InputError
from ...common.wording import printable
from ...fly.trajectory.axes import Axes, axes_of
from ...fly.trajectory.bodies import body_states
from ...fly.trajectory.clock import UtcClock
from ...fly.trajectory.kepler import Array
from ...fly.trajectory.sampling import Trajectory
from ...kernels.orbits import ephemeris
from ...problem.frame import FRAMES
from ...problem.instance import Instance
from .course import CourseLeg, FlightCourse, course_of
from .gmat_thrust import (
    decremented,
    fuelled,
    gregorian,
    hardware,
    note,
    powered,
    pushed,
    whole_millisecond,
)
from .kvn import WIDTH

States = Callable[[str | None], Iterator[tuple[str, str]]]

AXES = {"EME2000": "EarthMJ2000Eq", "GCRF": "EarthICRF", "ICRF": "EarthICRF"}
"""GMAT's coordinate systems for frames it supports."""

CHASER = "Chaser"
COMPONENTS = ("X", "Y", "Z", "VX", "VY", "VZ")

SHORTEST_COAST_S = 1e-6

BROUWER = ("SMA", "ECC", "INC", "RAAN", "AOP", "MA")
"""Mean elements of GMAT, with the prefix BrouwerShort."""

WARNING = (
    "The orbits above are mean orbits, which GMAT turns into osculating states, and GMAT flies in "
    "its own field up to J2: the burns are those of the mean dynamics, whose short-period and "
    "second-order terms are missing. At arrivals the chaser is off its target, by some hundred "
    "metres after a short leg and by hundreds of kilometres after weeks of drift; the script then "
    "docks it all the same."
)
"""Warning in scripts under J2."""


def to_gmat(trajectory: Trajectory, frame: str | None = None) -> str:
    """The script: bodies as spacecraft, burns as impulses, coasts by elapsed time.

    The chaser docks as the plan has it: at each arrival it takes over the state of the
    destination. A report file tells, at each arrival and before docking, where both are.

    ``frame`` is as for :func:`adr_opt.fly.trajectory.axes.axes_of`.

    Raises
    ------
    InputError
        GMAT has no such frame, or the first leg leaves a disposal orbit.
    """
    first = trajectory.legs[0].number
    if first in trajectory.plan.lead_ins:
        raise InputError(
            f"leg {first} leaves a disposal orbit, which a script of this leg alone cannot state; "
            "export the whole plan, or write .oem"
        )
    instance = trajectory.instance
    axes = axes_in_gmat(instance, frame)
    course = course_of(trajectory, axes)
    start = whole_millisecond(instance, trajectory.start_s)
    if instance.dynamics == "j2":
        course = replace(course, said=(*course.said, WARNING))

    def state(body: str | None) -> Iterator[tuple[str, str]]:
        return _planned_state(instance, axes, body or course.legs[0].origin, start)

    degree = 2 if instance.dynamics == "j2" else 0
    return script(course, axes, degree, start, state)


def axes_in_gmat(instance: Instance, frame: str | None) -> Axes:
    """Axes of a script; raises :class:`InputError` for frames unknown to GMAT."""
    if frame in FRAMES and frame not in AXES:
        raise InputError(
            f"frame = {frame!r}: GMAT has no such axes; use one of {', '.join(AXES)}, or write .oem"
        )
    return axes_of(instance, frame)


def script(
    course: FlightCourse,
    axes: Axes,
    degree: int,
    start_s: float,
    state: States,
    history: str | None = None,
) -> str:
    """The script of a course.

    Parameters
    ----------
    course : FlightCourse
    axes : Axes
    degree : int
        Of the zonal field that GMAT is to fly in; 0 for the gravity of a point.
    start_s : float
        When it begins, at a whole millisecond of the calendar [s].
    state : callable
        Fields and values of the state of a body then, or of the chaser for None.
    history : str, optional
        Name of the file that :func:`.gmat_thrust.history` is in; required with low thrust.
    """
    if history is not None:
        course = replace(course, said=(*course.said, note(history)))
    return "\n".join(_lines(course, axes, degree, start_s, state, history)) + "\n"


def _lines(
    course: FlightCourse,
    axes: Axes,
    degree: int,
    start_s: float,
    state: States,
    history: str | None,
) -> Iterator[str]:
    instance, system = course.instance, AXES[axes.frame.name]
    ends = {name for leg in course.legs for name in (leg.origin, leg.destination)}
    names = {body: _name(instance, body) for body in instance.names if body in ends}
    for sentence in course.said:
        for line in textwrap.wrap(printable(sentence), WIDTH):
            yield f"% {line}"
    yield from _earth(system)
    for spacecraft, body in [(CHASER, None), *((names[body], body) for body in names)]:
        yield ""
        yield from _spacecraft(instance, system, spacecraft, body, start_s, state)
    if history is not None:
        yield from hardware(course, CHASER, history)
    yield from _propagator(degree)
    if history is not None:
        yield from powered(_model(degree), _forces(degree))
    for leg in course.legs:
        yield from _impulses(course, leg, axes)
    crew = ", ".join([CHASER, *names.values()])
    yield from _views(crew, system)
    now = start_s
    for leg in course.legs:
        now = yield from _leg(course, leg, names[leg.destination], crew, system, now)


def _earth(system: str) -> Iterator[str]:
    yield ""
    yield f"GMAT Earth.Mu = {MU_M3_S2 / 1e9:.10g};"
    yield f"GMAT Earth.EquatorialRadius = {EARTH_RADIUS_M / 1e3:.10g};"
    if system != "EarthMJ2000Eq":
        yield ""
        yield f"Create CoordinateSystem {system};"
        yield f"GMAT {system}.Origin = Earth;"
        yield f"GMAT {system}.Axes = ICRF;"


def _propagator(degree: int) -> Iterator[str]:
    """Propagator settings, so accurate that its steps have no visible effect."""
    yield from _forces(degree)
    yield f"GMAT {_model(degree)}.ErrorControl = RSSStep;"
    yield from (
        "",
        "Create Propagator Fly;",
        f"GMAT Fly.FM = {_model(degree)};",
        "GMAT Fly.Type = RungeKutta89;",
        "GMAT Fly.InitialStepSize = 60;",
        "GMAT Fly.Accuracy = 1e-13;",
        "GMAT Fly.MinStep = 0;",
        "GMAT Fly.MaxStep = 600;",
    )


def _model(degree: int) -> str:
    """Name of the force model."""
    return "Zonal" if degree else "TwoBody"


def _forces(degree: int) -> Iterator[str]:
    """The force model, without its error control."""
    model = _model(degree)
    yield from ("", f"Create ForceModel {model};", f"GMAT {model}.CentralBody = Earth;")
    yield from _gravity(degree)
    yield f"GMAT {model}.Drag = None;"
    yield f"GMAT {model}.SRP = Off;"
    yield f"GMAT {model}.RelativisticCorrection = Off;"


def _gravity(degree: int) -> tuple[str, ...]:
    """Point-mass gravity, or GMAT's own zonal field up to a degree, with its own constants."""
    if not degree:
        return ("GMAT TwoBody.PointMasses = {Earth};",)
    return (
        "GMAT Zonal.PrimaryBodies = {Earth};",
        "GMAT Zonal.PointMasses = {};",
        f"GMAT Zonal.GravityField.Earth.Degree = {degree};",
        "GMAT Zonal.GravityField.Earth.Order = 0;",
        "GMAT Zonal.GravityField.Earth.PotentialFile = 'JGM2.cof';",
        "GMAT Zonal.GravityField.Earth.TideModel = 'None';",
    )


def _impulses(course: FlightCourse, leg: CourseLeg, axes: Axes) -> Iterator[str]:
    """Burns of a leg as GMAT manoeuvres."""
    for number, burn in enumerate(leg.all_impulses, start=1):
        yield ""
        yield f"Create ImpulsiveBurn {_burn(leg, number)};"
        yield f"GMAT {_burn(leg, number)}.CoordinateSystem = {AXES[axes.frame.name]};"
        for element, value in enumerate(axes.turned(np.array(burn.delta_v_m_s)), start=1):
            yield f"GMAT {_burn(leg, number)}.Element{element} = {value / 1e3:.12f};"
        if course.propulsion is None:
            yield f"GMAT {_burn(leg, number)}.DecrementMass = false;"
        else:
            yield from decremented(course.propulsion, _burn(leg, number))


def _views(crew: str, system: str) -> Iterator[str]:
    """Outputs of the mission: a file of arrivals, and a picture."""
    yield from (
        "",
        "Create ReportFile Arrivals;",
        "GMAT Arrivals.Filename = 'arrivals.txt';",
        "GMAT Arrivals.Precision = 16;",
        "GMAT Arrivals.WriteHeaders = true;",
        "",
        "Create OrbitView View;",
        f"GMAT View.Add = {{{crew}, Earth}};",
        f"GMAT View.CoordinateSystem = {system};",
        "",
        "BeginMissionSequence;",
    )


def _leg(
    course: FlightCourse, leg: CourseLeg, goal: str, crew: str, system: str, now: float
) -> Generator[str, None, float]:
    """Coasts, manoeuvres and docking of a leg from a time on [s]; returns its end."""
    yield ""
    yield f"% {printable(f'Leg {leg.number}: {leg.origin} to {leg.destination}')}"
    phase = "wait"
    if course.propulsion is not None:
        yield fuelled(course, leg, CHASER)
    for window in leg.windows:
        now = yield from _coast(leg, phase, crew, now, window.start_s)
        now = yield from pushed(leg, window, crew, CHASER)
        phase = "coast"
    for number, burn in enumerate(leg.impulses, start=1):
        now = yield from _coast(leg, phase, crew, now, burn.time_s)
        yield f"Maneuver '{burn.phase}' {_burn(leg, number)}({CHASER});"
        phase = burn.phase
    now = yield from _coast(leg, "approach", crew, now, leg.arrival_s)
    told = [f"{who}.{system}.{axis}" for who in (CHASER, goal) for axis in COMPONENTS[:3]]
    yield f"Report Arrivals {CHASER}.UTCGregorian {' '.join(told)};"
    for axis in COMPONENTS:
        yield f"GMAT {CHASER}.{system}.{axis} = {goal}.{system}.{axis};"
    now = yield from _coast(leg, "service", crew, now, leg.end_s)
    phase = "wait"
    for number, burn in enumerate(leg.removal, start=1 + len(leg.impulses)):
        now = yield from _coast(leg, phase, crew, now, burn.time_s)
        yield f"Maneuver '{burn.phase}' {_burn(leg, number)}({CHASER});"
        phase = burn.phase
    return now


def _coast(
    leg: CourseLeg, phase: str, crew: str, now: float, until: float
) -> Generator[str, None, float]:
    """A coast between two times [s], unless empty; returns its end."""
    if until - now < SHORTEST_COAST_S:
        return now
    yield (
        f"Propagate 'leg {leg.number}: {phase}' Fly({crew}) "
        f"{{{CHASER}.ElapsedSecs = {until - now:.9f}}};"
    )
    return until


def _spacecraft(
    instance: Instance, system: str, name: str, body: str | None, start_s: float, state: States
) -> Iterator[str]:
    epoch = datetime.fromisoformat(UtcClock(instance).label(start_s))
    yield "% the chaser" if body is None else f"% {printable(body)}"
    yield f"Create Spacecraft {name};"
    yield f"GMAT {name}.DateFormat = UTCGregorian;"
    yield f"GMAT {name}.Epoch = '{gregorian(epoch)}';"
    yield f"GMAT {name}.CoordinateSystem = {system};"
    for field, value in state(body):
        yield f"GMAT {name}.{field} = {value};"


def cartesian(axes: Axes, position_m: Array, velocity_m_s: Array) -> Iterator[tuple[str, str]]:
    """Fields and values of a state given in the frame of the elements."""
    yield "DisplayStateType", "Cartesian"
    values = (*axes.turned(position_m) / 1e3, *axes.turned(velocity_m_s) / 1e3)
    for axis, value in zip(COMPONENTS, values, strict=True):
        yield axis, f"{value:.12f}"


def _planned_state(
    instance: Instance, axes: Axes, body: str, start_s: float
) -> Iterator[tuple[str, str]]:
    """Planned state of a body: on its circle, and under J2 a mean orbit."""
    if instance.dynamics == "j2":
        yield "DisplayStateType", "BrouwerMeanShort"
        values = _mean_elements(instance, axes, body, start_s)
        for element, value in zip(BROUWER, values, strict=True):
            yield f"BrouwerShort{element}", f"{value:.12f}"
        return
    position, velocity = (state[0] for state in body_states(instance, body, start_s))
    yield from cartesian(axes, position, velocity)


def _mean_elements(
    instance: Instance, axes: Axes, body: str, time_s: float
) -> tuple[float, float, float, float, float, float]:
    """The planning circle as mean elements in GMAT's units (km, degrees)."""
    row = instance.orbits()[instance.names.index(body)]
    angles = (
        ephemeris.inclination_at(row, time_s),
        ephemeris.node_at(row, time_s),
        ephemeris.latitude_at(row, time_s),
    )
    turned = angles if axes.matrix is None else _turned(axes, *angles)
    inclination, node, latitude = (math.degrees(angle) for angle in turned)
    radius_km = float(ephemeris.radius_at(row, time_s)) / 1e3
    return radius_km, 0.0, inclination, node % 360.0, 0.0, latitude % 360.0


def _turned(axes: Axes, inclination: float, node: float, latitude: float) -> tuple[float, ...]:
    """Inclination, node and latitude of a point on a circle in other axes [rad]."""
    towards, ahead, normal = axes.turned(np.array(ephemeris.frame(inclination, node)))
    node = math.atan2(normal[0], -normal[1])
    ascending = np.array([math.cos(node), math.sin(node), 0.0])
    shift = math.atan2(ascending @ ahead, ascending @ towards)
    return math.atan2(math.hypot(normal[0], normal[1]), normal[2]), node, latitude - shift


def _burn(leg: CourseLeg, number: int) -> str:
    return f"Leg{leg.number}Burn{number}"


def _name(instance: Instance, body: str) -> str:
    """A valid GMAT name: letters, digits and underscores, unique for every body."""
    slug = re.sub(r"[^A-Za-z0-9]+", "_", body).strip("_")
    number = instance.names.index(body)
    if number < len(instance.stations):
        return "Station" if len(instance.stations) == 1 else f"S{number}_{slug}".rstrip("_")
    if number < instance.first_target:
        return "Start"
    return f"T{number}_{slug}".rstrip("_")
