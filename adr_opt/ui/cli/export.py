"""``export``: write the flight of a plan in a format of other programs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import click

from ...common.errors import InputError
from ...common.wording import counted
from .output import emit_json, say
from .parameters import check_out, instance_argument, json_option, plan_argument, quiet_option

if TYPE_CHECKING:
    from ...export.flights.write import FlightFile
    from ...fly.trajectory.axes import Axes


@click.command("export", short_help="Write the flight of PLAN as OEM, OPM, CZML or GMAT script.")
@instance_argument
@plan_argument
@click.option(
    "--out", required=True, metavar="FILE", help="File to write: .oem, .opm, .czml or .script."
)
@click.option(
    "--format",
    "format_",
    type=click.Choice(["oem", "opm", "czml", "script"]),
    help="Whatever the suffix of the file.",
)
@click.option(
    "--frame",
    type=click.Choice(["EME2000", "GCRF", "ICRF", "TEME"]),
    help="Turn all to this frame from that of INSTANCE; where it names none, call it so. By "
    "default its own, else EME2000.",
)
@click.option(
    "--step",
    "step_s",
    type=float,
    metavar="S",
    help="Longest time between two states of .oem and .czml; by default 60, and 300 on arcs of "
    "more than a day.",
)
@click.option("--leg", type=int, metavar="N", help="Only this leg, counted from 1.")
@click.option(
    "--body", metavar="NAME", help="Of a refined plan: this visited body instead of the chaser."
)
@click.option(
    "--chaser", metavar="NAME", help="Whose flight; needed where there are several, but for .czml."
)
@click.option(
    "--object-id",
    metavar="ID",
    help="International designator of what is written, like 2026-001A; else UNKNOWN, or that "
    "which INSTANCE has of a --body.",
)
@json_option
@quiet_option
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

    Of a refined plan, an OEM, OPM or script file of its osculating states is written. Where there
    are several chasers, a file holds the flight of one of them, but that a CZML file may hold all.
    """
    if step_s is not None and not (step_s > 0.0 and math.isfinite(step_s)):
        raise InputError(f"--step = {step_s:g}: must be a positive number of seconds")
    if object_id is not None and not (object_id.strip() and object_id.isascii()):
        raise InputError(f"--object-id {object_id!r}: give a designator like 2026-001A, in ASCII")
    if object_id is not None and not object_id.isprintable():
        raise InputError(f"--object-id {object_id!r}: give it in one line")

    from ...export.flights.write import (
        TOGETHER,
        FlightFile,
        flown,
        format_of,
        write_trajectory,
    )
    from ...plan.plan import load_plan
    from ...plan.refined_plan import is_refined
    from ...problem.instance import load

    format_ = format_of(out, format_)
    check_out(out, instance_path, plan_path)
    if is_refined(plan_path):
        return _refined(
            instance_path, plan_path, out, FlightFile(format_, frame, object_id), step_s, leg,
            body, chaser, as_json, quiet,
        )  # fmt: skip
    if body is not None:
        raise InputError(f"--body {body}: only of a refined plan bodies are exported")
    instance, plan = load(instance_path), load_plan(plan_path)
    try:
        written = flown(instance, plan, step_s, leg, chaser, together=format_ in TOGETHER)
    except InputError as error:
        raise InputError(f"{plan_path}: {error}") from None
    axes = write_trajectory(written, out, FlightFile(format_, frame, object_id))
    arcs = [arc for _, arc in written.arcs()]
    if as_json:
        emit_json(
            {
                "instance": instance.name,
                "path": out,
                "format": format_,
                **_frame(axes),
                **({} if written.chaser is None else {"chaser": written.chaser}),
                "legs": len(written.legs),
                "dynamics": instance.dynamics,
                "arcs": len(arcs),
                "states": sum(arc.times_s.size for arc in arcs),
                "burns": sum(len(path.leg.burns) for path in written.legs),
                "start_s": written.start_s,
                "end_s": written.end_s,
            }
        )
    if not quiet:
        legs, parts = counted(len(written.legs), "leg"), counted(len(arcs), "arc")
        say(f"wrote {out}: {legs}, {parts}, {_in_frame(axes)}")
    return 0


def _frame(axes: Axes) -> dict[str, Any]:
    """What --json says of the frame of the file."""
    told: dict[str, Any] = axes.frame.model_dump(mode="json")
    told = {"frame": told.pop("name"), **told}
    return told | {"instance_frame": None if axes.own is None else axes.own.name}


def _in_frame(axes: Axes) -> str:
    """The same in words."""
    if axes.own is None:
        return f"called {axes.frame}: the instance names no frame"
    turned = "" if axes.frame == axes.own else f", turned from {axes.own}"
    return f"in {axes.frame}{turned}"


def _refined(
    instance_path: str,
    refined_path: str,
    out: str,
    file: FlightFile,
    step_s: float | None,
    leg: int | None,
    body: str | None,
    chaser: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """The same for a refined plan."""
    from ...export.flights.refined_oem import write_refined
    from ...export.flights.write import axes_in
    from ...fly.refine import load_refined
    from ...plan.routes import several
    from ...problem.instance import load

    if file.format == "czml":
        raise InputError(
            f"{out}: a refined plan is written as .oem, .opm or .script; name such a file"
        )
    instance, refined = load(instance_path), load_refined(refined_path)
    try:
        written = write_refined(
            instance, refined, out, file=file, body=body, step_s=step_s, leg=leg, chaser=chaser
        )
    except InputError as error:
        raise InputError(f"{refined_path}: {error}") from None
    axes = axes_in(str(file.format), instance, file.frame)
    whose = chaser if several(instance) else None
    legs = [one for one in refined.legs if leg in (None, one.leg) and whose in (None, one.chaser)]
    if as_json:
        emit_json(
            {
                "instance": instance.name,
                "path": out,
                "format": file.format,
                **_frame(axes),
                "body": body,
                **({"chaser": legs[0].chaser} if several(instance) and body is None else {}),
                "legs": len(legs),
                "dynamics": refined.gravity,
                "arcs": len(written),
                "states": sum(track.arc.times_s.size for track in written),
                "burns": 0 if body else sum(len(one.burns) for one in legs),
                "start_s": written[0].arc.start_s,
                "end_s": written[-1].arc.end_s,
            }
        )
    if not quiet:
        parts = f"{counted(len(legs), 'leg')}, {counted(len(written), 'arc')}"
        say(f"wrote {out}: {parts}, {_in_frame(axes)}")
    return 0
