"""``matrix``: sample the timetable into a file that other programs read."""

from __future__ import annotations

import math

import click

from ..errors import InputError
from .output import emit_json, say
from .parameters import check_out, instance_argument, json_option, quiet_option

MOST_BYTES = 2**34
"""Larger matrices are refused before the system runs out of memory."""


@click.command("matrix", short_help="Write ΔV and duration matrices of INSTANCE.")
@instance_argument
@click.option("--every", "every_s", type=float, metavar="S", help="Ready times, S apart, from 0.")
@click.option(
    "--at", "at_s", type=float, multiple=True, metavar="S", help="Ready time; repeatable."
)
@click.option(
    "--quantity",
    type=click.Choice(["delta_v", "duration"]),
    default="delta_v",
    show_default=True,
    help="Weights of .tsp and .vrp; the others hold both.",
)
@click.option("--scale", type=float, help="Weight of one m/s or one second in .tsp and .vrp.")
@click.option(
    "--out", required=True, metavar="FILE", help="File to write: .nc, .npz, .tsp or .vrp."
)
@json_option
@quiet_option
def command(
    instance_path: str,
    every_s: float | None,
    at_s: tuple[float, ...],
    quantity: str,
    scale: float | None,
    out: str,
    as_json: bool,
    quiet: bool,
) -> int:
    """Write ΔV and duration of every transfer of INSTANCE, sampled at ready times."""
    if (every_s is None) == (not at_s):
        raise InputError("give the ready times either with --every S or with --at S")
    if every_s is not None and not (every_s > 0.0 and math.isfinite(every_s)):
        raise InputError(f"--every = {every_s:g}: must be a positive number of seconds")
    for time_s in at_s:
        if not (time_s >= 0.0 and math.isfinite(time_s)):
            raise InputError(f"--at = {time_s:g}: must be a time from 0 on, in seconds")

    import numpy as np

    from ..export import write_matrix
    from ..instance import load

    instance = load(instance_path)
    check_out(out, instance_path)
    departures = np.array(at_s)
    if every_s is not None:
        end_s = instance.mission.duration_s
        size = 16.0 * len(instance.names) ** 2 * (end_s / every_s + 1.0)
        if size > MOST_BYTES:
            raise InputError(
                f"--every = {every_s:g}: the matrices would take {size / 2**30:.3g} GiB, more than "
                f"{MOST_BYTES / 2**30:g}; raise it"
            )
        departures = np.arange(0.0, max(end_s, every_s), every_s)
    write_matrix(instance, out, departures, quantity=quantity, scale=scale)
    if as_json:
        emit_json(
            {
                "instance": instance.name,
                "path": out,
                "quantity": quantity,
                "bodies": list(instance.names),
                "departures_s": departures.tolist(),
            }
        )
    if not quiet:
        say(f"wrote {out}: {departures.size} ready times, {len(instance.names)} bodies")
    return 0
