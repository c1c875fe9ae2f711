"""A refined plan as a CCSDS Orbit Ephemeris Message: one object a message."""

from __future__ import annotations

import os
from collections.abc import Iterator
from datetime import UTC, datetime

from ..files import check_writable, write_text
from ..flight.flyable import refuse_foreign
from ..flight.tanks import refined_routes
from ..instance import Instance
from ..kernels.constants import EARTH_RADIUS_M, J2
from ..kernels.gravity import J3, J4
from ..routes import chaser_wanted
from ..trajectory.axes import Axes, axes_of
from ..trajectory.clock import Clock
from ..trajectory.kvn import ORIGINATOR, comment, metadata, object_name, plain, who
from ..trajectory.oem import segment
from ..trajectory.write import check_frame
from .ephemeris import Track, tracks
from .plan import RefinedPlan


def write_refined(
    instance: Instance,
    refined: RefinedPlan,
    path: str | os.PathLike[str],
    *,
    frame: str | None = None,
    body: str | None = None,
    step_s: float | None = None,
    leg: int | None = None,
    chaser: str | None = None,
) -> tuple[Track, ...]:
    """Write the flight of the chaser, or of a visited body, whole or not at all.

    Parameters
    ----------
    instance : Instance
    refined : RefinedPlan
    path : path
    frame : {"EME2000", "GCRF", "ICRF", "TEME"}, optional
        As for :func:`.trajectory.write_plan`.
    body, step_s, leg
        As :func:`.ephemeris.tracks` takes them.
    chaser : str, optional
        Whose flight; needed where there are several chasers, unless a leg or a body is named.

    Returns
    -------
    tuple of Track
        What was written.

    Raises
    ------
    InputError
        A refined plan of another instance, an unknown frame, what :func:`.ephemeris.tracks`
        raises, or a file that cannot be written.
    """
    refuse_foreign(instance, refined)
    check_frame(frame)
    check_writable(path)
    axes = axes_of(instance, frame)
    name = _whose(instance, refined, chaser, leg, body)
    written = tracks(refined, body=body, step_s=step_s, leg=leg, chaser=name)
    called = object_name(name) if body is None else plain(body)
    write_text(path, "\n".join(_lines(instance, refined, called, name, written, axes)) + "\n")
    return written


def _whose(
    instance: Instance, refined: RefinedPlan, chaser: str | None, leg: int | None, body: str | None
) -> str | None:
    """Whose flight is to be written; None for the only chaser's, or for a body's."""
    if body is not None and chaser is None and leg is None:
        return None
    routes = refined_routes(instance, refined)
    whose = {leg.leg: its.name for its, legs in routes for leg in legs}
    return chaser_wanted(instance, whose, chaser, leg)


def _lines(
    instance: Instance,
    refined: RefinedPlan,
    name: str,
    chaser: str | None,
    written: tuple[Track, ...],
    axes: Axes,
) -> Iterator[str]:
    clock = Clock(instance)
    yield "CCSDS_OEM_VERS = 2.0"
    for sentence in (*_origin(instance, refined, axes), *who(instance, chaser)):
        yield from comment(sentence)
    yield f"CREATION_DATE = {datetime.now(UTC):%Y-%m-%dT%H:%M:%S}"
    yield f"ORIGINATOR = {ORIGINATOR}"
    for track in written:
        yield ""
        yield from segment(clock, track.comment, track.arc, axes, metadata(instance, axes, name))


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
        + "; impulsive burns."
    )
    yield axes.said
