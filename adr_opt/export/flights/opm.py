"""``.opm``: initial state and burns of the chaser, as a CCSDS Orbit Parameter Message.

502.0-B, section 3. One state and any number of manoeuvres are all that the format can say. Where
masses are known the message is of version 2.0; else of 3.0, the first one that allows a manoeuvre
without a change of mass.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from ...fly.trajectory.axes import Axes, axes_of
from ...fly.trajectory.clock import UtcClock, states_at_labels
from ...fly.trajectory.kepler import Array
from ...fly.trajectory.sampling import Trajectory
from .course import FlightCourse, course_of
from .kvn import comment, header, metadata, object_name

MASS_KG = 1000.0
"""Placeholder mass: the format requires one with manoeuvres, but a tank in m/s has none."""

LEAST_KG = 5e-10
"""Least change of mass that is visible in the file."""


def to_opm(trajectory: Trajectory, frame: str | None = None, object_id: str | None = None) -> str:
    """Initial state and all burns in key-value notation.

    When propagated, it drifts by what the burns leave: the few centimetres and tenths of a
    millimetre per second that an approach leaves are carried through service, where the plan has
    the chaser docked, and add up to decimetres over a week. A message of one leg has none of
    that.
    """
    axes, first = axes_of(trajectory.instance, frame), trajectory.legs[0].arcs[0]
    about = []
    if trajectory.instance.dynamics == "j2":
        about = [
            "It is a mean state: its velocity is that within the plane, to which the burns add. "
            "Propagated as an osculating state, it deviates from the plan"
        ]
    position, _ = states_at_labels(first)
    state = np.concatenate([position[0], first.velocities_m_s[0]])
    return message(course_of(trajectory, axes), axes, object_id, first.start_s, state, about)


def message(
    course: FlightCourse,
    axes: Axes,
    object_id: str | None,
    start_s: float,
    state: Array,
    about: Iterable[str] = (),
) -> str:
    """The message of a course.

    Parameters
    ----------
    course : FlightCourse
    axes : Axes
    object_id : str or None
        The chaser's, if it has any.
    start_s : float
        When it begins, in whole microseconds [s].
    state : (6,) float64
        Of the chaser then, in the frame of the elements [m, m/s].
    about : iterable of str
        More sentences on it.
    """
    return "\n".join(_lines(course, axes, object_id, start_s, state, about)) + "\n"


def _lines(
    course: FlightCourse,
    axes: Axes,
    object_id: str | None,
    start_s: float,
    state: Array,
    about: Iterable[str],
) -> Iterator[str]:
    clock = UtcClock(course.instance)
    burnt = [one for leg in course.legs for one in course.burnt.get(leg.number, ())]
    every_mass_shows = bool(burnt) and all(one.lost_kg > LEAST_KG for one in burnt)
    yield from header("CCSDS_OPM_VERS", course.said, "2.0" if every_mass_shows else "3.0")
    yield ""
    yield from metadata(course.instance, axes, object_name(course.chaser), object_id)
    yield ""
    yield from comment(f"State at the beginning of leg {course.legs[0].number}")
    for sentence in about:
        yield from comment(sentence)
    yield f"EPOCH = {clock.label(start_s)}"
    position, velocity = axes.turned(state[:3]) / 1e3, axes.turned(state[3:]) / 1e3
    for axis, value in zip("XYZ", position, strict=True):
        yield f"{axis} = {value:.9f} [km]"
    for axis, value in zip("XYZ", velocity, strict=True):
        yield f"{axis}_DOT = {value:.12f} [km/s]"
    yield ""
    if burnt:
        yield from comment(
            "With propellant and kits. Changes between manoeuvres, by refuelling, kits left behind "
            "or a towed object, are in their comments"
        )
    else:
        yield from comment("The mass is a placeholder required by the format: the plan states none")
    yield f"MASS = {burnt[0].before_kg if burnt else MASS_KG:.6f} [kg]"
    for leg in course.legs:
        masses = course.burnt.get(leg.number, (None,) * len(leg.all_impulses))
        for burn, mass in zip(leg.all_impulses, masses, strict=True):
            yield ""
            weighs = "" if mass is None else f", {mass.before_kg:.6f} kg before it"
            yield from comment(f"{leg.title}: {burn.phase}{weighs}")
            yield f"MAN_EPOCH_IGNITION = {clock.label(burn.time_s)}"
            yield "MAN_DURATION = 0.000 [s]"
            yield f"MAN_DELTA_MASS = {0.0 if mass is None else -mass.lost_kg:.9f} [kg]"
            yield f"MAN_REF_FRAME = {axes.frame.name}"
            for number, part in enumerate(axes.turned(np.array(burn.delta_v_m_s)), start=1):
                yield f"MAN_DV_{number} = {part / 1e3:.12f} [km/s]"
