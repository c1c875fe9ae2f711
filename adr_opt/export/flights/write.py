"""Writing of a flown plan in the format given by the file's suffix."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path

from ...common.errors import InputError
from ...common.files import check_writable, write_text
from ...fly.flight.flyable import refuse_broken_chain
from ...fly.trajectory.axes import Axes, axes_of
from ...fly.trajectory.sampling import Trajectory, sample
from ...judge.admit import AnyPlan, admit
from ...plan.routes import chaser_wanted, owners
from ...problem.frame import FRAMES as FRAMES
from ...problem.instance import Instance
from .czml import to_czml
from .czml_packets import CESIUM
from .gmat import axes_in_gmat, to_gmat
from .oem import to_oem
from .opm import to_opm

FORMATS = ("oem", "opm", "czml", "script")
"""Formats, and with a leading dot the suffixes."""

ALL_FORMATS = ("oem", "opm", "ocm", "czml", "script")
"""Formats including those for refined plans only."""

TOGETHER = ("czml",)
"""Formats that can hold the flights of several chasers."""


@dataclass(frozen=True)
class FlightFile:
    """Settings of a written flight.

    Attributes
    ----------
    format : {"oem", "opm", "ocm", "czml", "script"}, optional
        By default that of the file's suffix; "ocm" is for refined plans.
    frame : {"EME2000", "GCRF", "ICRF", "TEME"}, optional
        By default GCRF, and EME2000 if the instance names no frame. Where it names one, states and
        burns are rotated from it to this one by astropy; otherwise this is only a label. CZML
        always uses Cesium's INERTIAL, the ICRF; GMAT has no TEME.
    object_id : str, optional
        International designator of what flies, for ``oem`` and ``opm``; else UNKNOWN.
    """

    format: str | None = None
    frame: str | None = None
    object_id: str | None = None


BY_SUFFIX = FlightFile()


def write_plan(
    instance: Instance,
    plan: AnyPlan,
    path: str | os.PathLike[str],
    *,
    file: FlightFile = BY_SUFFIX,
    step_s: float | None = None,
    leg: int | None = None,
    chaser: str | None = None,
) -> Trajectory:
    """Fly a plan and write the flight, completely or not at all.

    Parameters
    ----------
    instance : Instance
    plan : Plan or Admitted
    path : path
        Its suffix chooses the format where ``file`` does not.
    file : FlightFile
    step_s : float, optional
        Largest time between two states of ``oem`` and ``czml``; by default that of
        :func:`adr_opt.fly.trajectory.sampling.sample` [s].
    leg : int, optional
        Only this leg, counted from 1.
    chaser : str, optional
        Only the legs of this chaser. Where there are several, all formats but ``czml`` need it, or
        a leg.

    Returns
    -------
    Trajectory
        What was written.

    Raises
    ------
    InputError
        Unknown format, frame or chaser, several chasers and none is named, a plan of another
        instance, with violations, without legs or that cannot be flown, legs that do not follow
        each other, no such leg, a step that is not positive, or a file that cannot be written.
    MissingExtra
        There is something to turn, and astropy is not installed.
    """
    kind = format_of(path, file.format)
    refuse_refined_only(kind)
    check_frame(file.frame)
    check_writable(path)
    trajectory = flown(instance, plan, step_s, leg, chaser, together=kind in TOGETHER)
    write_trajectory(trajectory, path, file)
    return trajectory


def flown(
    instance: Instance,
    plan: AnyPlan,
    step_s: float | None = None,
    leg: int | None = None,
    chaser: str | None = None,
    *,
    together: bool = False,
) -> Trajectory:
    """The flight of a plan, of a chaser or of one leg, which must not be empty.

    With ``together`` it may be that of several chasers.
    """
    plan = admit(instance, plan).plan
    trajectory = sample(instance, plan, step_s)
    if not trajectory.legs:
        raise InputError("the plan has no legs: there is nothing to export")
    whose = owners(instance, plan)
    everyone = together and chaser is None and leg is None
    name = None if everyone else chaser_wanted(instance, whose, chaser, leg)
    if leg is None:
        refuse_broken_chain(instance, plan)
        legs = tuple(path for path in trajectory.legs if name is None or whose[path.number] == name)
        if not legs:
            raise InputError(f"{name!r} has no legs: there is nothing to export")
        return replace(trajectory, legs=legs, chaser=name)
    if not 1 <= leg <= len(trajectory.legs):
        raise InputError(f"leg = {leg}: the plan has the legs 1 to {len(trajectory.legs)}")
    return replace(trajectory, legs=(trajectory.legs[leg - 1],), chaser=name)


def write_trajectory(
    trajectory: Trajectory, path: str | os.PathLike[str], file: FlightFile = BY_SUFFIX
) -> Axes:
    """Write a flight with at least one leg; the parameters are those of :func:`write_plan`.

    Returns
    -------
    Axes
        Those of the file.
    """
    format, frame = format_of(path, file.format), file.frame
    refuse_refined_only(format)
    check_frame(frame)
    axes = axes_in(format, trajectory.instance, frame)
    if format == "oem":
        text = to_oem(trajectory, frame, file.object_id)
    elif format == "opm":
        text = to_opm(trajectory, frame, file.object_id)
    elif format == "czml":
        text = to_czml(trajectory)
    else:
        text = to_gmat(trajectory, frame)
    write_text(path, text)
    return axes


def axes_in(format: str, instance: Instance, frame: str | None) -> Axes:
    """Axes of a file in a format, as requested or by default."""
    if format == "czml":
        return axes_of(instance, CESIUM)
    return axes_in_gmat(instance, frame) if format == "script" else axes_of(instance, frame)


def refuse_refined_only(format: str) -> None:
    """Raise :class:`InputError` for a format of refined plans only."""
    if format == "ocm":
        raise InputError(".ocm is for refined plans; refine the plan, or write .oem or .opm")


def check_frame(frame: str | None) -> None:
    """Raise :class:`InputError` for an unknown frame."""
    if frame is not None and frame not in FRAMES:
        raise InputError(f"frame = {frame!r}: use one of {', '.join(FRAMES)}")


def format_of(path: str | os.PathLike[str], format: str | None = None) -> str:
    """The requested format, by name or else by the file's suffix."""
    if format is not None:
        if format not in ALL_FORMATS:
            raise InputError(f"format = {format!r}: use one of {', '.join(ALL_FORMATS)}")
        return format
    suffix = Path(path).suffix.lower()
    if suffix.removeprefix(".") not in ALL_FORMATS or not suffix:
        raise InputError(
            f"{path}: suffix {suffix!r} is unknown; use one of "
            f"{', '.join('.' + name for name in ALL_FORMATS)}, or name the format"
        )
    return suffix.removeprefix(".")
