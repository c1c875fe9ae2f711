"""Refined plans in other programs' formats: ephemerides, messages of burns, scripts, CZML."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator

from ...common.constants import EARTH_RADIUS_M, J2
from ...common.errors import InputError
from ...common.files import check_writable, write_both, write_text
from ...common.wording import printable
from ...fly.flight.tanks import refined_routes
from ...fly.refine.bodies import Whereabouts
from ...fly.refine.ephemeris import EphemerisTrack, tracks
from ...fly.trajectory.axes import Axes
from ...fly.trajectory.clock import UtcClock
from ...fly.trajectory.sampling import STEP_S
from ...judge.admit import AnyRefined, admit
from ...kernels.orbits.gravity import J3, J4
from ...plan.launched import as_launched
from ...plan.refined_plan import RefinedPlan
from ...plan.routes import chaser_wanted
from ...problem.instance import Instance
from .gmat_thrust import history_path
from .kvn import header, metadata, object_name, who
from .oem import segment
from .refined_czml import RefinedLegs, to_czml, usual_step
from .refined_messages import refined_course, refuse_between_ephemerides, to_gmat, to_ocm, to_opm
from .write import ALL_FORMATS, BY_SUFFIX, TOGETHER, FlightFile, axes_in, check_frame


def write_refined(
    instance: Instance,
    refined: AnyRefined,
    path: str | os.PathLike[str],
    *,
    file: FlightFile = BY_SUFFIX,
    body: str | None = None,
    step_s: float | None = None,
    leg: int | None = None,
    chaser: str | None = None,
) -> tuple[EphemerisTrack, ...]:
    """Write the flight of the chaser, or of a visited body, completely or not at all.

    Parameters
    ----------
    instance : Instance
    refined : RefinedPlan or Admitted
    path : path
    file : FlightFile
        Of the formats "oem", by default, "opm", "ocm", "czml" and "script". Messages of burns and
        scripts hold osculating states of the chaser and its burns; OCM, CZML and scripts low
        thrust, too, scripts in a file beside them. A body is called by default what the instance
        says.
    body, step_s, leg
        As :func:`adr_opt.fly.refine.ephemeris.tracks` takes them.
    chaser : str, optional
        Whose flight; needed where there are several chasers, unless a leg or a body is named, or
        all of them are written as "czml".

    Returns
    -------
    tuple of Track
        What was written, as states over time.

    Raises
    ------
    InputError
        A refined plan of another instance or with violations, an unknown frame or format, a body
        in another format than "oem", low thrust in "opm", legs that do not follow each other in
        messages and scripts, ephemerides that are missing, burns that do not lead from one of them
        to the next, what :func:`adr_opt.fly.refine.ephemeris.tracks` raises, or a file that cannot
        be written.
    MissingExtra
        There is something to turn to the frame, and astropy is not installed.
    """
    refined = admit(instance, refined).plan
    instance = as_launched(instance, refined.planned)
    format, frame, object_id = file.format or "oem", file.frame, file.object_id
    check_frame(frame)
    check_writable(path)
    if format not in ALL_FORMATS:
        raise InputError(f"format = {format!r}: use one of {', '.join(ALL_FORMATS)}")
    axes = axes_in(format, instance, frame)
    if format != "oem" and body is not None:
        raise InputError(f"{body!r} makes no burns, which .{format} would list; write .oem")
    everyone = format in TOGETHER and chaser is None and leg is None
    name = None if everyone else _whose(instance, refined, chaser, leg, body)
    if format == "czml" and step_s is None:
        step_s = usual_step(refined.legs)
    bodies = Whereabouts.of(instance, refined)
    written = tracks(refined, body=body, step_s=step_s, leg=leg, chaser=name, bodies=bodies)
    said = [*_origin(instance, refined, axes), *who(instance, name)]
    if format == "oem":
        called = object_name(name) if body is None else printable(body)
        about = tuple(metadata(instance, axes, called, object_id or _designator(instance, body)))
        text = "\n".join(_lines(instance, said, written, axes, about)) + "\n"
        write_text(path, text)
        return written
    legs = [one for one in refined.legs if leg in (None, one.leg) and name in (None, one.chaser)]
    if format == "opm" and any(one.thrust is not None for one in legs):
        raise InputError(
            "a burn of .opm has a fixed direction, but low thrust is steered; write .ocm or .oem"
        )
    if format == "czml":
        shown = RefinedLegs(refined, legs, bodies)
        write_text(path, to_czml(instance, shown, axes, said, step_s or STEP_S))
        return written
    refuse_between_ephemerides(refined, legs, format)
    course = refined_course(instance, refined, legs, name, said)
    if format == "script":
        beside = None if course.propulsion is None else history_path(path)
        told = None if beside is None else beside.name
        text, history = to_gmat(course, refined, legs, axes, told)
        if beside is None:
            write_text(path, text)
        else:
            write_both(path, text, beside, history)
    else:
        write = to_opm if format == "opm" else to_ocm
        write_text(path, write(course, refined, legs, axes, object_id))
    return written


def _designator(instance: Instance, body: str | None) -> str | None:
    """Catalogue designator of a body, as stated by the instance."""
    known = {station.name: station.object_id for station in instance.stations}
    known |= {target.name: target.object_id for target in instance.targets}
    return None if body is None else known.get(body)


def _whose(
    instance: Instance, refined: RefinedPlan, chaser: str | None, leg: int | None, body: str | None
) -> str | None:
    """The chaser whose flight is to be written; None for an only chaser, or a body."""
    if body is not None and chaser is None and leg is None:
        return None
    routes = refined_routes(instance, refined)
    whose = {leg.leg: its.name for its, legs in routes for leg in legs}
    return chaser_wanted(instance, whose, chaser, leg)


def _lines(
    instance: Instance,
    said: Iterable[str],
    written: tuple[EphemerisTrack, ...],
    axes: Axes,
    about: Iterable[str],
) -> Iterator[str]:
    clock = UtcClock(instance)
    yield from header("CCSDS_OEM_VERS", said)
    for track in written:
        yield ""
        method = "LAGRANGE" if track.reported else "HERMITE"
        yield from segment(clock, track.comment, track.arc, axes, about, method)


def _origin(instance: Instance, refined: RefinedPlan, axes: Axes) -> Iterator[str]:
    yield (
        f"Plan by {refined.plan.method} (seed {refined.plan.seed}), refined, for the instance "
        f"{instance.name}, sha256 {refined.instance.sha256}."
    )
    harmonics = {"j2": f"J2 = {J2:.8e}", "j3": f"J3 = {J3:.8e}", "j4": f"J4 = {J4:.8e}"}
    until = ("two-body", *harmonics).index(refined.gravity)
    terms = ", ".join(list(harmonics.values())[:until])
    yield (
        "Osculating states of numerically integrated motion with GM = 398600.4418 km**3/s**2"
        + (f", R = {EARTH_RADIUS_M / 1e3:.3f} km, {terms}" if terms else "")
        + ("; low thrust, and " if refined.has_thrust else "; ")
        + "impulsive burns."
    )
    if refined.ephemerides is not None:
        yield (
            "Legs begin at and end with states of ephemerides, beside which the chaser is held, "
            f"sha256 {refined.ephemerides.sha256}."
        )
    yield axes.said
