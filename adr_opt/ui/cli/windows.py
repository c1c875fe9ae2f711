"""``windows``: capture windows of targets, from sunlight, the Sun's angle and ground contacts."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ...common.errors import InputError
from . import param
from .output import emit_json, emit_rich, say, say_written
from .parameters import check_outs

if TYPE_CHECKING:
    from ...analysis.windows.conditions import States
    from ...analysis.windows.intervals import Array
    from ...problem.instance import Instance


@click.command("windows", short_help="Find capture windows of targets: light, Sun, contacts.")
@param.instance
@param.flag("--light", "Capture only in full sunlight.")
@param.number(
    "--sun-angle",
    "DEG",
    "Least angle of the Sun from the velocity, along which a chaser approaches.",
    "sun_angle_deg",
    default=0.0,
)
@param.many(
    "--contact",
    "NAME",
    "Ground stations, public or of --stations, separated by commas: one of them must see the "
    "target; repeatable.",
    "contacts",
)
@param.file("--stations", "CSV file: name,latitude_deg,longitude_deg,altitude_m.")
@param.number(
    "--mask", "DEG", "Least elevation of a contact.", "mask_deg", default=5.0, show_default=True
)
@param.many("--within", "FILE", "CSV file of further windows; repeatable.")
@param.number("--margin", "S", "Margin cut off both ends of windows.", "margin_s", default=0.0)
@param.number("--capture", "S", "Duration of a capture, within a window.", "capture_s", default=0.0)
@param.flag("--ephemerides", "Use the ephemerides beside INSTANCE.")
@param.file("--out", "CSV file of windows to write: target,opens_s,closes_s.")
@param.file("--into", "Instance to write with these windows, beside their file --out.")
@param.spoken
def command(
    instance_path: str,
    light: bool,
    sun_angle_deg: float,
    contacts: tuple[str, ...],
    stations: str | None,
    mask_deg: float,
    within: tuple[str, ...],
    margin_s: float,
    capture_s: float,
    ephemerides: bool,
    out: str | None,
    into: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Find when each target of INSTANCE may be captured.

    All conditions have to hold at once, and for the whole of a capture.
    """
    from ...analysis.windows import STATIONS, CaptureConditions, read_stations, windows_of
    from ...analysis.windows.intervals import common, lasting
    from ...problem.capture_windows import file_of, read_windows
    from ...problem.instance import load
    from .tables import number_table

    if not 0.0 <= capture_s < math.inf:
        raise InputError(f"--capture = {capture_s:g}: must be at least 0")
    instance = load(instance_path)
    check_outs((out, into), instance_path, *within, stations)
    if into is not None and (out is None or Path(out).parent != Path(into).parent):
        raise InputError("--into: give --out as well, a file in the same folder")
    known = STATIONS | ({} if stations is None else read_stations(stations))
    contacts = tuple(name.strip() for each in contacts for name in each.split(","))
    for name in contacts:
        if name not in known:
            raise InputError(f"--contact {name}: no such station; use one of: {', '.join(known)}")
    given: dict[str, Array] = {}
    for path in within:
        intervals_of = read_windows(path).intervals
        strange = intervals_of.keys() - {target.name for target in instance.targets}
        if strange:
            raise InputError(f"{path}: {min(strange)!r} is not a target of {instance.name!r}")
        for name, intervals in intervals_of.items():
            given[name] = common(given[name], intervals) if name in given else intervals
    conditions = CaptureConditions(
        light, sun_angle_deg, tuple(known[name] for name in contacts), mask_deg, given, margin_s
    )
    found = windows_of(instance, conditions, _reported(instance) if ephemerides else None)
    found = {name: lasting(intervals, capture_s) for name, intervals in found.items()}
    rows = {name: _figures(intervals, instance) for name, intervals in found.items()}
    windows = file_of(found)
    if out is not None:
        windows.write(out)
    if out is not None and into is not None:
        instance.with_windows(windows, Path(out).name, capture_s or None).save(into)
    for name, row in rows.items():
        if not row["windows"]:
            say(f"{name!r} can never be captured, for {capture_s:g} s at a time", unless=quiet)
    say_written(out, into, quiet=quiet)
    if as_json:
        emit_json({"instance": instance.name, "path": out, "targets": rows})
    elif not quiet:
        headings = "windows", "open [%]", "longest [s]"
        texts = (
            (name, f"{row['windows']}", f"{100.0 * row['share']:.1f}", f"{row['longest_s']:.0f}")
            for name, row in rows.items()
        )
        emit_rich(number_table("When targets may be captured", headings, texts, first="target"))
    return 0


def _figures(intervals: Array, instance: Instance) -> dict[str, float]:
    """Number of windows, their share of the mission, and the longest."""
    lengths = intervals[:, 1] - intervals[:, 0]
    share = float(lengths.sum()) / max(instance.mission.duration_s, 1e-300)
    return {"windows": len(intervals), "share": share, "longest_s": float(lengths.max(initial=0.0))}


def _reported(instance: Instance) -> States:
    """Motion of targets by the ephemerides beside an instance."""
    from ...sources.ephemerides import ephemerides_of

    known = ephemerides_of(instance)

    def states(name: str, times: Array) -> tuple[Array, Array]:
        found = known.of(name).state(times)
        return found[:, :3], found[:, 3:]

    return states
