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
from collections.abc import Generator, Iterator
from datetime import datetime

import numpy as np

from ..errors import InputError
from ..frame import FRAMES
from ..instance import Instance
from ..kernels import orbits
from ..kernels.constants import EARTH_RADIUS_M, MU_M3_S2
from .axes import USUAL, Axes, axes_of
from .bodies import body_states
from .clock import Clock
from .kvn import WIDTH, origin, plain, who
from .sampling import LegPath, Trajectory

AXES = {"EME2000": "EarthMJ2000Eq", "GCRF": "EarthICRF", "ICRF": "EarthICRF"}
"""Coordinate systems of GMAT for the frames that it has."""

CHASER = "Chaser"
COMPONENTS = ("X", "Y", "Z", "VX", "VY", "VZ")

MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")

SHORTEST_COAST_S = 1e-6

GRAVITY = {
    "two-body": ("GMAT TwoBody.PointMasses = {Earth};",),
    "j2": (
        "GMAT Zonal.PrimaryBodies = {Earth};",
        "GMAT Zonal.PointMasses = {};",
        "GMAT Zonal.GravityField.Earth.Degree = 2;",
        "GMAT Zonal.GravityField.Earth.Order = 0;",
        "GMAT Zonal.GravityField.Earth.PotentialFile = 'JGM2.cof';",
        "GMAT Zonal.GravityField.Earth.TideModel = 'None';",
    ),
}
"""Of which gravity: that of a point, or of GMAT's own field up to J2, with its own constants."""

BROUWER = ("SMA", "ECC", "INC", "RAAN", "AOP", "MA")
"""Mean elements of GMAT, with the prefix BrouwerShort."""

WARNING = (
    "The orbits above are mean orbits, which GMAT turns into osculating states, and GMAT flies in "
    "its own field up to J2: the burns are those of the mean dynamics, whose short-period and "
    "second-order terms are missing. At arrivals the chaser is off its target, by some hundred "
    "metres after a short leg and by hundreds of kilometres after weeks of drift; the script then "
    "docks it all the same."
)
"""What has to be known of a script under J2."""


def to_gmat(trajectory: Trajectory, frame: str | None = None) -> str:
    """The script: bodies of the plan as spacecraft, burns as impulses, coasts by elapsed time.

    The chaser docks as the plan has it: at each arrival it takes over the state of the
    destination. A report file tells, at each arrival and before docking, where both are.

    ``frame`` is as for :func:`.axes.axes_of`; by default, where the instance names one that GMAT
    has not, EME2000.

    Raises
    ------
    InputError
        GMAT has no such frame, or the first leg leaves a disposal orbit.
    """
    first = trajectory.legs[0].number
    if first in trajectory.plan.tows_before:
        raise InputError(
            f"leg {first} leaves a disposal orbit, which a script of it alone does not know; "
            "export the whole plan, or write .oem"
        )
    return "\n".join(_lines(trajectory, axes_in_gmat(trajectory.instance, frame))) + "\n"


def axes_in_gmat(instance: Instance, frame: str | None) -> Axes:
    """The axes of a script; raises :class:`InputError` where GMAT has none for a frame."""
    if frame is None and instance.frame is not None and instance.frame.name not in AXES:
        frame = USUAL
    if frame in FRAMES and frame not in AXES:
        raise InputError(
            f"frame = {frame!r}: GMAT has no such axes; use one of {', '.join(AXES)}, or write .oem"
        )
    return axes_of(instance, frame)


def _lines(trajectory: Trajectory, axes: Axes) -> Iterator[str]:
    instance, system = trajectory.instance, AXES[axes.frame.name]
    ends = {name for path in trajectory.legs for name in (path.leg.origin, path.leg.destination)}
    names = {body: _name(instance, body) for body in instance.names if body in ends}
    start = _whole_millisecond(instance, trajectory.start_s)
    said = [*origin(instance, trajectory.plan, axes), *who(instance, trajectory.chaser)]
    if instance.dynamics == "j2":
        said.append(WARNING)
    for sentence in said:
        for line in textwrap.wrap(plain(sentence), WIDTH):
            yield f"% {line}"
    yield from _earth(system)
    chaser_at = trajectory.legs[0].leg.origin
    for spacecraft, body in [(CHASER, chaser_at), *((names[body], body) for body in names)]:
        yield ""
        yield from _spacecraft(instance, axes, spacecraft, body, start)
    yield from _propagator(instance)
    for path in trajectory.legs:
        yield from _impulses(path, axes)
    crew = ", ".join([CHASER, *names.values()])
    yield from _views(crew, system)
    now = start
    for path in trajectory.legs:
        now = yield from _leg(path, names[path.leg.destination], crew, system, now)


def _earth(system: str) -> Iterator[str]:
    yield ""
    yield f"GMAT Earth.Mu = {MU_M3_S2 / 1e9:.10g};"
    yield f"GMAT Earth.EquatorialRadius = {EARTH_RADIUS_M / 1e3:.10g};"
    if system != "EarthMJ2000Eq":
        yield ""
        yield f"Create CoordinateSystem {system};"
        yield f"GMAT {system}.Origin = Earth;"
        yield f"GMAT {system}.Axes = ICRF;"


def _propagator(instance: Instance) -> Iterator[str]:
    """How GMAT is to fly: so exactly that nothing of its steps shows."""
    model = "Zonal" if instance.dynamics == "j2" else "TwoBody"
    yield from ("", f"Create ForceModel {model};", f"GMAT {model}.CentralBody = Earth;")
    yield from GRAVITY[instance.dynamics]
    yield f"GMAT {model}.Drag = None;"
    yield f"GMAT {model}.SRP = Off;"
    yield f"GMAT {model}.RelativisticCorrection = Off;"
    yield f"GMAT {model}.ErrorControl = RSSStep;"
    yield from (
        "",
        "Create Propagator Fly;",
        f"GMAT Fly.FM = {model};",
        "GMAT Fly.Type = RungeKutta89;",
        "GMAT Fly.InitialStepSize = 60;",
        "GMAT Fly.Accuracy = 1e-13;",
        "GMAT Fly.MinStep = 0;",
        "GMAT Fly.MaxStep = 600;",
    )


def _impulses(path: LegPath, axes: Axes) -> Iterator[str]:
    """The burns of a leg, to be made by its manoeuvres."""
    for number, burn in enumerate(path.leg.all_burns, start=1):
        yield ""
        yield f"Create ImpulsiveBurn {_burn(path, number)};"
        yield f"GMAT {_burn(path, number)}.CoordinateSystem = {AXES[axes.frame.name]};"
        for element, value in enumerate(axes.turned(np.array(burn.delta_v_m_s)), start=1):
            yield f"GMAT {_burn(path, number)}.Element{element} = {value / 1e3:.12f};"
        yield f"GMAT {_burn(path, number)}.DecrementMass = false;"


def _views(crew: str, system: str) -> Iterator[str]:
    """What is to be seen of the mission: a file of arrivals, and a picture."""
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
    path: LegPath, goal: str, crew: str, system: str, now: float
) -> Generator[str, None, float]:
    """Coasts and manoeuvres of a leg from a time on [s], and docking; returns when it is over."""
    yield ""
    yield f"% {plain(_title(path))}"
    phase = "wait"
    for number, burn in enumerate(path.leg.burns, start=1):
        now = yield from _coast(path, phase, crew, now, burn.time_s)
        yield f"Maneuver '{burn.phase}' {_burn(path, number)}({CHASER});"
        phase = burn.phase
    now = yield from _coast(path, "approach", crew, now, path.leg.arrival_s)
    told = [f"{who}.{system}.{axis}" for who in (CHASER, goal) for axis in COMPONENTS[:3]]
    yield f"Report Arrivals {CHASER}.UTCGregorian {' '.join(told)};"
    for axis in COMPONENTS:
        yield f"GMAT {CHASER}.{system}.{axis} = {goal}.{system}.{axis};"
    now = yield from _coast(path, "service", crew, now, path.leg.end_s)
    tow = () if path.leg.tow is None else path.leg.tow.burns
    phase = "wait"
    for number, burn in enumerate(tow, start=1 + len(path.leg.burns)):
        now = yield from _coast(path, phase, crew, now, burn.time_s)
        yield f"Maneuver '{burn.phase}' {_burn(path, number)}({CHASER});"
        phase = burn.phase
    return now


def _coast(
    path: LegPath, phase: str, crew: str, now: float, until: float
) -> Generator[str, None, float]:
    """A coast from one time to another [s], unless it is none; returns when it is over."""
    if until - now < SHORTEST_COAST_S:
        return now
    yield (
        f"Propagate 'leg {path.number}: {phase}' Fly({crew}) "
        f"{{{CHASER}.ElapsedSecs = {until - now:.9f}}};"
    )
    return until


def _spacecraft(
    instance: Instance, axes: Axes, spacecraft: str, body: str, start_s: float
) -> Iterator[str]:
    epoch = datetime.fromisoformat(Clock(instance).label(start_s))
    yield f"% {plain(body)}" if spacecraft != CHASER else "% the chaser"
    yield f"Create Spacecraft {spacecraft};"
    yield f"GMAT {spacecraft}.DateFormat = UTCGregorian;"
    yield f"GMAT {spacecraft}.Epoch = '{_gregorian(epoch)}';"
    yield f"GMAT {spacecraft}.CoordinateSystem = {AXES[axes.frame.name]};"
    if instance.dynamics == "j2":
        yield f"GMAT {spacecraft}.DisplayStateType = BrouwerMeanShort;"
        for element, value in zip(
            BROUWER, _mean_elements(instance, axes, body, start_s), strict=True
        ):
            yield f"GMAT {spacecraft}.BrouwerShort{element} = {value:.12f};"
        return
    yield f"GMAT {spacecraft}.DisplayStateType = Cartesian;"
    position, velocity = (
        axes.turned(state[0]) / 1e3 for state in body_states(instance, body, start_s)
    )
    for axis, value in zip(COMPONENTS, (*position, *velocity), strict=True):
        yield f"GMAT {spacecraft}.{axis} = {value:.12f};"


def _mean_elements(
    instance: Instance, axes: Axes, body: str, time_s: float
) -> tuple[float, float, float, float, float, float]:
    """The circle that is planned with, as mean elements in GMAT's units (km, degrees)."""
    orbit = instance.body_orbits[instance.names.index(body)]
    row = orbit.row(instance.oblateness_m2)
    angles = row[orbits.INCLINATION], orbits.node_at(row, time_s), orbits.latitude_at(row, time_s)
    if axes.matrix is not None:
        angles = _turned(axes, *angles)
    inclination, node, latitude = (math.degrees(angle) for angle in angles)
    return row[orbits.RADIUS] / 1e3, 0.0, inclination, node % 360.0, 0.0, latitude % 360.0


def _turned(axes: Axes, inclination: float, node: float, latitude: float) -> tuple[float, ...]:
    """Inclination, node and latitude of a place on a circle in other axes [rad]."""
    towards, ahead, normal = axes.turned(np.array(orbits.frame(inclination, node)))
    node = math.atan2(normal[0], -normal[1])
    ascending = np.array([math.cos(node), math.sin(node), 0.0])
    shift = math.atan2(ascending @ ahead, ascending @ towards)
    return math.atan2(math.hypot(normal[0], normal[1]), normal[2]), node, latitude - shift


def _whole_millisecond(instance: Instance, time_s: float) -> float:
    """The nearest time at which the calendar shows whole milliseconds: GMAT reads no finer."""
    beyond_s = instance.epoch.microsecond % 1000 / 1e6
    return round((time_s + beyond_s) * 1e3) / 1e3 - beyond_s


def _gregorian(time: datetime) -> str:
    """A time as GMAT writes it, in English whatever the locale."""
    month = MONTHS[time.month - 1]
    return (
        f"{time.day:02d} {month} {time.year:04d} {time.hour:02d}:{time.minute:02d}:"
        f"{time.second:02d}.{time.microsecond // 1000:03d}"
    )


def _title(path: LegPath) -> str:
    return f"Leg {path.number}: {path.leg.origin} to {path.leg.destination}"


def _burn(path: LegPath, number: int) -> str:
    return f"Leg{path.number}Burn{number}"


def _name(instance: Instance, body: str) -> str:
    """A name that GMAT takes: letters, digits and underscores, different for every body."""
    slug = re.sub(r"[^A-Za-z0-9]+", "_", body).strip("_")
    number = instance.names.index(body)
    if number < len(instance.stations):
        return "Station" if len(instance.stations) == 1 else f"S{number}_{slug}".rstrip("_")
    if number < instance.first_target:
        return "Start"
    return f"T{number}_{slug}".rstrip("_")
