"""``.oem``: the chaser's ephemeris as a CCSDS Orbit Ephemeris Message (502.0-B-2, section 5)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ...fly.trajectory.axes import Axes, axes_of
from ...fly.trajectory.clock import UtcClock, states_at_labels
from ...fly.trajectory.sampling import Arc, Trajectory
from .kvn import comment, header, metadata, object_name, origin, who

DEGREE = 7
"""Degree of Hermite interpolation: four states. At 60 s it is exact to a micrometre, at 300 s to a
centimetre."""


def to_oem(trajectory: Trajectory, frame: str | None = None, object_id: str | None = None) -> str:
    """The ephemeris in key-value notation.

    One segment for each arc, so that no interpolation runs across a burn: a leg is the run of
    segments whose comments carry its number. States at a burn stand twice: before it at the end of
    one segment, after it at the beginning of the next.

    Where planes drift, the velocities written are the rates of the positions, or interpolation
    would not lead from one to the next; a burn is then a step of these to a part in a thousand.

    ``frame`` is as for :func:`adr_opt.fly.trajectory.axes.axes_of`, ``object_id`` the chaser's, if
    it has any.
    """
    axes = axes_of(trajectory.instance, frame)
    return "\n".join(_lines(trajectory, axes, object_id)) + "\n"


def _lines(trajectory: Trajectory, axes: Axes, object_id: str | None) -> Iterator[str]:
    instance = trajectory.instance
    clock = UtcClock(instance)
    said = [*origin(instance, trajectory.plan, axes), *who(instance, trajectory.chaser)]
    if instance.dynamics == "j2":
        said += ["Velocities are the rates of the positions, the drift of the planes included."]
    yield from header("CCSDS_OEM_VERS", said)
    name = object_name(trajectory.chaser)
    for path, arc in trajectory.arcs():
        yield ""
        which = f"leg {path.number}, {path.leg.origin} to {path.leg.destination}: {arc.phase}"
        yield from segment(clock, which, arc, axes, metadata(instance, axes, name, object_id))


def segment(
    clock: UtcClock, said: str, arc: Arc, axes: Axes, about: Iterable[str], method: str = "HERMITE"
) -> Iterator[str]:
    """One arc, with a comment, metadata of object, frame and times, and how to interpolate it.

    Parameters
    ----------
    clock : UtcClock
    said : str
        The comment.
    arc : Arc
    axes : Axes
        That states are turned to.
    about : iterable of str
        Lines on object, frame and time system.
    method : str
        Of interpolation.
    """
    labels = clock.labels(arc.times_s)
    yield "META_START"
    yield from about
    yield f"START_TIME = {labels[0]}"
    yield f"STOP_TIME = {labels[-1]}"
    yield f"INTERPOLATION = {method}"
    yield f"INTERPOLATION_DEGREE = {DEGREE}"
    yield "META_STOP"
    yield from comment(said)
    positions, velocities = (axes.turned(vectors) for vectors in states_at_labels(arc))
    for label, r, v in zip(labels, positions / 1e3, velocities / 1e3, strict=True):
        yield f"{label} {r[0]:.9f} {r[1]:.9f} {r[2]:.9f} {v[0]:.12f} {v[1]:.12f} {v[2]:.12f}"
