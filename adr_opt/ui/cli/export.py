"""``export``: write the flight of a plan in another program's format."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ...common.errors import InputError
from ...common.wording import counted
from . import param
from .output import emit_json, say
from .parameters import about, admitted_plan, admitted_refined, check_out

if TYPE_CHECKING:
    from ...export.flights.write import FlightFile
    from ...fly.trajectory.axes import Axes
    from ...problem.instance import Instance


@click.command(
    "export", short_help="Write the flight of PLAN as OEM, OPM, OCM, CZML or GMAT script."
)
@param.instance
@param.plan
@param.file("--out", "File to write: .oem, .opm, .ocm, .czml or .script.", required=True)
@click.option(
    "--format",
    "format_",
    type=click.Choice(["oem", "opm", "ocm", "czml", "script"]),
    help="Format, regardless of the file's suffix.",
)
@click.option(
    "--frame",
    type=click.Choice(["EME2000", "GCRF", "ICRF", "TEME"]),
    help="Frame to rotate to, by default GCRF; or the name of the frame if INSTANCE states none, "
    "by default EME2000.",
)
@param.number(
    "--step",
    "S",
    "Longest time between states in .oem and .czml; by default 60, or 300 on arcs longer than a "
    "day.",
    name="step_s",
)
@param.count("--leg", "N", "Only this leg, counting from 1.")
@param.word("--body", "NAME", "For a refined plan: a visited body instead of the chaser.")
@param.word("--chaser", "NAME", "Chaser to write; required if there are several, except for .czml.")
@param.word(
    "--object-id",
    "ID",
    "International designator of the object, like 2026-001A; by default UNKNOWN, or for a --body "
    "that in INSTANCE.",
)
@param.spoken
def command(
    instance_path: str,
    plan_path: str,
    out: str,
    format_: str | None,
    frame: str | None,
    step_s: float | None,
    leg: int | None,
    body: str | None,
    chaser: str | None,
    object_id: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Fly PLAN in the dynamics of INSTANCE and write the flight for other programs.

    A refined plan is written with its osculating states, and may be an OCM file, too. A script of
    low thrust has a second file beside it, of the suffix .thrust. With several chasers, a file
    holds the flight of one; only a CZML file may hold all.
    """
    if step_s is not None and not (step_s > 0.0 and math.isfinite(step_s)):
        raise InputError(f"--step = {step_s:g}: must be a positive number of seconds")
    if object_id is not None and not (object_id.strip() and object_id.isascii()):
        raise InputError(f"--object-id {object_id!r}: give a designator like 2026-001A, in ASCII")
    if object_id is not None and not object_id.isprintable():
        raise InputError(f"--object-id {object_id!r}: must be on one line")

    from ...export.flights.write import TOGETHER, FlightFile, flown, format_of, write_trajectory
    from ...plan.refined_plan import is_refined

    file = FlightFile(format_of(out, format_), frame, object_id)
    check_out(out, instance_path, plan_path)
    if file.format == "script":
        check_out(str(Path(out).with_suffix(".thrust")), instance_path, plan_path)
    if is_refined(plan_path):
        instance, axes, told = _refined(
            instance_path, plan_path, out, file, step_s=step_s, leg=leg, body=body, chaser=chaser
        )
    else:
        if body is not None:
            raise InputError(f"--body {body}: bodies are exported from refined plans only")
        admitted = admitted_plan(instance_path, plan_path)
        instance = admitted.instance
        with about(plan_path):
            written = flown(
                instance, admitted, step_s, leg, chaser, together=file.format in TOGETHER
            )
        axes = write_trajectory(written, out, file)
        arcs = [arc for _, arc in written.arcs()]
        told = {
            **({} if written.chaser is None else {"chaser": written.chaser}),
            "legs": len(written.legs),
            "dynamics": instance.dynamics,
            "arcs": len(arcs),
            "states": sum(arc.times_s.size for arc in arcs),
            "burns": sum(len(path.leg.impulses) for path in written.legs),
            "start_s": written.start_s,
            "end_s": written.end_s,
        }
    if as_json:
        head = {"instance": instance.name, "path": out, "format": file.format}
        emit_json(head | _frame(axes) | told)
    parts = f"{counted(told['legs'], 'leg')}, {counted(told['arcs'], 'arc')}"
    say(f"wrote {out}: {parts}, {_in_frame(axes)}", unless=quiet)
    return 0


def _frame(axes: Axes) -> dict[str, Any]:
    """The frame of the file, for --json."""
    told: dict[str, Any] = axes.frame.model_dump(mode="json")
    told = {"frame": told.pop("name"), **told}
    return told | {"instance_frame": None if axes.own is None else axes.own.name}


def _in_frame(axes: Axes) -> str:
    """The frame of the file, in words."""
    if axes.own is None:
        return f"called {axes.frame}: the instance names no frame"
    turned = "" if axes.frame == axes.own else f", turned from {axes.own}"
    return f"in {axes.frame}{turned}"


def _refined(
    instance_path: str,
    refined_path: str,
    out: str,
    file: FlightFile,
    *,
    step_s: float | None,
    leg: int | None,
    body: str | None,
    chaser: str | None,
) -> tuple[Instance, Axes, dict[str, Any]]:
    """Write a refined plan; returns its part of --json."""
    from ...export.flights.refined_oem import write_refined
    from ...export.flights.write import TOGETHER, axes_in
    from ...plan.routes import several

    admitted = admitted_refined(instance_path, refined_path)
    instance, refined = admitted.instance, admitted.plan
    with about(refined_path):
        written = write_refined(
            instance, admitted, out, file=file, body=body, step_s=step_s, leg=leg, chaser=chaser
        )
    whose = chaser if several(instance) else None
    legs = [one for one in refined.legs if leg in (None, one.leg) and whose in (None, one.chaser)]
    everyone = file.format in TOGETHER and whose is None and leg is None
    told_of = several(instance) and body is None and not everyone
    told = {
        "body": body,
        **({"chaser": legs[0].chaser} if told_of else {}),
        "legs": len(legs),
        "dynamics": refined.gravity,
        "arcs": len(written),
        "states": sum(track.arc.times_s.size for track in written),
        "burns": 0 if body else sum(len(one.impulses) for one in legs),
        "start_s": written[0].arc.start_s,
        "end_s": written[-1].arc.end_s,
    }
    return instance, axes_in(str(file.format), instance, file.frame), told
