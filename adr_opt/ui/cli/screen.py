"""``screen``: approaches of the objects of a catalogue to a refined plan."""

from __future__ import annotations

import click

from ...common.wording import counted
from . import complete, param
from .output import emit_json, emit_rich, say, say_written
from .parameters import admitted_refined, check_out

SHOWN = 20
"""Number of approaches in the table that is printed."""


@click.command("screen", short_help="Approaches of catalogued objects to a refined plan.")
@param.instance
@click.argument("refined_path", metavar="REFINED", shell_complete=complete.files)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", shell_complete=complete.files)
@param.number(
    "--distance",
    "M",
    "Least distances up to this are reported.",
    "distance_m",
    default=5000.0,
    show_default=True,
)
@param.file("--out", "CSV file of approaches to write.")
@param.skip_bad
@param.as_json
@param.quiet
def command(
    instance_path: str,
    refined_path: str,
    files: tuple[str, ...],
    distance_m: float,
    out: str | None,
    skip_bad: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Find all approaches of the objects in FILE... to the arcs of REFINED.

    Objects move by SGP4. Bodies that a leg leaves or leads to are counted apart.
    """
    from ...analysis.screening import approaches_csv, screen
    from ...common.files import write_text
    from ...sources import catalogue
    from .tables import number_table

    check_out(out, instance_path, refined_path, *files)
    admitted = admitted_refined(instance_path, refined_path)
    found = catalogue.read(files, skip_bad=skip_bad)
    approaches = screen(admitted.instance, admitted, found.records, distance_m=distance_m)
    if out is not None:
        write_text(out, approaches_csv(approaches))
    others = [each for each in approaches if not each.own]
    found_of_others = counted(len(others), "approach", "approaches")
    say(
        f"{counted(len(found.records), 'object')}: {found_of_others} within {distance_m:g} m, and "
        f"{len(approaches) - len(others)} of bodies that are visited",
        unless=quiet,
    )
    say_written(out, quiet=quiet)
    if as_json:
        emit_json(
            {
                "instance": admitted.instance.name,
                "objects": len(found.records),
                "bad_rows": len(found.dropped),
                "distance_m": distance_m,
                "path": out,
                "approaches": [each.to_dict() for each in approaches],
            }
        )
    elif others and not quiet:
        nearest = sorted(others, key=lambda each: each.miss_m)[:SHOWN]
        headings = "leg", "time", "miss [m]", "radial", "along", "cross", "speed [m/s]", "age [d]"
        rows = (
            (
                each.object,
                f"{each.leg}",
                each.epoch[:19],
                *(
                    f"{value:.0f}"
                    for value in (each.miss_m, each.radial_m, each.along_m, each.cross_m)
                ),
                f"{each.speed_m_s:.0f}",
                f"{each.age_days:.1f}",
            )
            for each in nearest
        )
        title = f"The {len(nearest)} nearest approaches of {len(others)}"
        emit_rich(number_table(title, headings, rows, first="object"))
    return 0
