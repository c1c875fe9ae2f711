"""``matrix``: write the timetable, sampled or whole, in another program's format."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import click

from ...common.errors import InputError
from ...common.wording import counted
from . import param
from .output import emit_json, say
from .parameters import check_out

if TYPE_CHECKING:
    from ...legs.matrices import FloatArray
    from ...problem.instance import Instance

MOST_BYTES = 2**34
"""Size above which matrices are refused, before memory runs out."""


@click.command("matrix", short_help="Write ΔV and duration matrices of INSTANCE.")
@param.instance
@param.number("--every", "S", "Ready times at this interval, from 0.", name="every_s")
@param.number("--at", "S", "Ready time; repeatable.", name="at_s", multiple=True)
@click.option(
    "--quantity",
    type=click.Choice(["delta_v", "duration"]),
    default="delta_v",
    show_default=True,
    help="Weights in .tsp, .vrp and .oplib; other formats hold both.",
)
@param.word(
    "--choose",
    "HOW",
    "Transfer chosen at a ready time among all departures: 'earliest', 'cheapest', or by the value "
    "of an hour in m/s; by default 75 m/s, with service in time.",
)
@click.option(
    "--scale", type=float, help="Weight of one m/s or one second in .tsp, .vrp and .oplib."
)
@param.file(
    "--out",
    "File to write. Matrices at ready times: .nc, .npz; at one: .tsp, .vrp, .oplib. "
    "Every departure, without ready times: .parquet, .lp, .mps.",
    required=True,
)
@param.spoken
def command(
    instance_path: str,
    every_s: float | None,
    at_s: tuple[float, ...],
    quantity: str,
    choose: str | None,
    scale: float | None,
    out: str,
    as_json: bool,
    quiet: bool,
) -> int:
    """Write ΔV and duration of every transfer of INSTANCE: at ready times, or at all events."""
    if every_s is not None and at_s:
        raise InputError("give the ready times either with --every S or with --at S")
    if every_s is not None and not (every_s > 0.0 and math.isfinite(every_s)):
        raise InputError(f"--every = {every_s:g}: must be a positive number of seconds")
    for time_s in at_s:
        if not (time_s >= 0.0 and math.isfinite(time_s)):
            raise InputError(f"--at = {time_s:g}: must be a time from 0 on, in seconds")

    from ...export.tables import write_matrix, write_timetable
    from ...export.tables.write import suffix_of, whole_suffixes
    from ...legs.connections import weights_of
    from ...problem.instance import load
    from .bars import percent_bar, wanted

    if choose is not None:
        weights_of(choose)
    suffix = suffix_of(out)
    is_whole = suffix in whole_suffixes()
    has_times = every_s is not None or bool(at_s)
    if is_whole and has_times:
        raise InputError(
            f"{out}: a {suffix} file holds every connection; leave out --every and --at"
        )
    if is_whole and choose is not None:
        raise InputError(f"{out}: a {suffix} file holds every connection; leave out --choose")
    if not is_whole and not has_times:
        raise InputError("give the ready times either with --every S or with --at S")

    instance = load(instance_path)
    check_out(out, instance_path)
    if not quiet:
        _announce(instance)
    written: dict[str, Any] = {"instance": instance.name, "path": out}
    with percent_bar(wanted(as_json, quiet), "timetable") as building:
        if is_whole:
            write_timetable(instance, out, building=building)
            what = "every connection"
        else:
            departures = _departures(instance, every_s, at_s)
            write_matrix(
                instance,
                out,
                departures,
                quantity=quantity,
                scale=scale,
                choose=choose,
                building=building,
            )
            what = counted(departures.size, "ready time")
    if not is_whole:
        written |= {"quantity": quantity, "choose": choose, "departures_s": departures.tolist()}
    if as_json:
        emit_json(written | {"bodies": list(instance.names)})
    say(f"wrote {out}: {what}, {counted(len(instance.names), 'body', 'bodies')}", unless=quiet)
    return 0


def _announce(instance: Instance) -> None:
    """Announce the size of a large timetable."""
    from ...legs.connection_finder import estimate

    size = estimate(instance)
    if size.is_large:
        say(f"building {size}")


def _departures(instance: Instance, every_s: float | None, at_s: tuple[float, ...]) -> FloatArray:
    """The requested ready times [s]."""
    import numpy as np

    end_s = instance.mission.duration_s
    if every_s is None:
        if max(at_s) > end_s:
            raise InputError(f"--at = {max(at_s):g}: the mission ends at {end_s:g} s")
        return np.array(at_s)
    size = 16.0 * len(instance.names) ** 2 * (end_s / every_s + 1.0)
    if size > MOST_BYTES:
        raise InputError(
            f"--every = {every_s:g}: the matrices would take {size / 2**30:.3g} GiB, more than "
            f"{MOST_BYTES / 2**30:g}; raise it"
        )
    return np.arange(0.0, max(end_s, every_s), every_s)
