"""``worth``: worth of removing each object of a catalogue, in fragment-years."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import click

from ...common.errors import InputError
from ...common.wording import counted
from . import param
from .output import emit_json, emit_rich, say, say_written
from .parameters import check_outs

if TYPE_CHECKING:
    from rich.table import Table

    from ...sources.catalogue import ElementSet
    from ...sources.worth import Bodies, Satcat


@click.command("worth", short_help="Rate the removal of each object, as prizes for 'import'.")
@param.files
@param.file("--out", "CSV file of prizes to write: object,prize,mass.", required=True)
@param.satcat
@param.measures
@click.option("--years", type=float, default=50.0, show_default=True, help="Horizon, at most 200.")
@param.activity
@param.count(
    "--candidates", "N", "Number of objects with prizes; 0 for all.", default=200, show_default=True
)
@param.count("--falling", "N", "Let prizes fall yearly for N years, after which they are 0.")
@param.number("--unit", "U", "Unit of prizes [fragment-years]; by default a power of ten.")
@param.file("--details", "CSV file to write with all data on the candidates.", "details")
@param.file("--pairs", "JSON file of worths alone and of pairs, for 'tradeoff --worth'.", "pairs")
@param.page
@param.exclude
@param.cores(default=0)
@param.skip_bad
@param.spoken
def command(
    files: tuple[str, ...],
    out: str,
    satcat_path: str | None,
    table_path: str | None,
    years: float,
    activity: str,
    candidates: int,
    falling: int | None,
    unit: float | None,
    details: str | None,
    pairs: str | None,
    page_path: str | None,
    exclude: tuple[str, ...],
    jobs: int,
    skip_bad: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Rate the removal of each object in FILE... by the fragment-years that it avoids.

    Encounters of all pairs of objects, fragments by the NASA standard breakup model, and the time
    that they stay. Prizes add up: no set avoids less than the sum of its prizes.
    """
    from ...common.files import write_text
    from ...sources import catalogue, worth
    from ...sources.worth.worth import check_years
    from ...sources.worth.worth_file import check_count
    from ..report.plain import check_page, write_page
    from ..report.worth import worth_page
    from .bars import counting_bar, wanted

    read = (*files, satcat_path, table_path)
    check_outs((out, details, pairs, page_path), *read)
    check_page(page_path)
    check_years(years)
    if any(not pattern.strip() for pattern in exclude):
        raise InputError("--exclude '': give a part of a name or a pattern")
    if candidates < 0:
        raise InputError(f"--candidates {candidates}: must be at least 0, for all objects")
    if falling is not None and not 0 < falling < years:
        raise InputError(
            f"--falling {falling}: must be at least 1, and less than the {years:g} years of the "
            "horizon"
        )
    if pairs is not None:
        check_count(candidates)
    if jobs < 0:
        raise InputError(f"--jobs {jobs}: must be at least 0, for all cores")
    if unit is not None and not unit > 0.0:
        raise InputError(f"--unit {unit:g}: must be positive")
    satcat = None if satcat_path is None else worth.read_satcat(satcat_path)
    found = catalogue.read(files, skip_bad=skip_bad)
    bodies, notes = measured_bodies(found.records, satcat, satcat_path, table_path, exclude)
    with counting_bar(wanted(as_json, quiet), "encounters") as show:
        made = worth.worth_of(bodies, years, activity, jobs, show)
    later = [
        worth.worth_of(bodies, years, activity, jobs, since_years=float(year))
        for year in range(1, (falling or 0) + 1)
    ]
    prizes = worth.prizes_of(made, candidates, unit, jobs, later=later)
    told = worth.answer(prizes, satcat) | {
        "path": out,
        "bad_rows": len(found.dropped),
        "falling_years": falling or 0,
    }
    page = None if page_path is None else worth_page(prizes, told)
    paired = None if pairs is None else worth.pairs_json(prizes)
    write_text(out, prizes.prizes_csv())
    if details is not None:
        write_text(details, prizes.details_csv())
    if pairs is not None and paired is not None:
        write_text(pairs, paired)
    if page_path is not None and page is not None:
        write_page(page_path, page)
    for note in notes:
        say(note, unless=quiet)
    say_written(out, details, pairs, page_path, quiet=quiet)
    if as_json:
        emit_json(told)
    else:
        _tell(told, quiet)
        emit_rich(_table(told))
    return 0


def _tell(told: dict[str, Any], quiet: bool) -> None:
    from ...sources.worth.answer import figure

    masses = ", ".join(f"{source} {count}" for source, count in sorted(told["masses"].items()))
    say(f"{counted(told['objects'], 'object')}; masses: {masses}", unless=quiet)
    left = told["left_out"] | ({"bad rows": told["bad_rows"]} if told["bad_rows"] else {})
    if left:
        say(
            "left out: " + ", ".join(f"{reason} {count}" for reason, count in left.items()),
            unless=quiet,
        )
    say(
        f"all pairs: {figure(told['total'])} fragment-years in {told['years']:g} years, "
        f"{told['catastrophic_per_year']:.2g} catastrophic collisions a year; prizes in units of "
        f"{told['unit']['value']:g} fragment-years",
        unless=quiet,
    )
    for each in told["sets"]:
        say(
            f"removing {each['size']} as a set takes {each['share']:.1%} off, "
            f"{figure(each['worth'])} fragment-years; alone they sum to "
            f"{figure(each['sum_alone'])}",
            unless=quiet,
        )


def _table(told: dict[str, Any]) -> Table:
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    table.add_column("object")
    for heading in ("prize", "alone", "floor"):
        table.add_column(heading, justify="right")
    table.add_column("reason")
    for each in told["best"]:
        table.add_row(
            each["name"],
            f"{each['prize']:.0f}",
            f"{each['worth_alone']:.4g}",
            f"{each['floor']:.4g}",
            each["reason"],
        )
    return table


FEW = 0.5
"""Share of objects found in the satcat below which another date is suspected."""


def measured_bodies(
    records: Sequence[ElementSet],
    satcat: Satcat | None,
    satcat_path: str | None,
    table_path: str | None,
    excluded: Collection[str],
) -> tuple[Bodies, list[str]]:
    """Orbits, masses and sizes, and notes: rows without an object, masses that are defaults.

    Raises
    ------
    InputError
        As for :func:`adr_opt.sources.worth.read_measures`.
    """
    from ...sources import worth

    table = None if table_path is None else worth.read_measures(table_path, records)
    bodies = worth.bodies_of(records, satcat, table and table.known, excluded)
    notes = []
    if table is not None and table.strange:
        notes.append(
            f"note: {table_path}: {counted(len(table.strange), 'object')} not in the catalogue, "
            f"{table.strange[0]!r} for one; left out"
        )
    if satcat is not None and bodies.matched < FEW * len(bodies):
        of_when = f"the file of {satcat.updated}" if satcat.updated else "the file"
        notes.append(
            f"warning: {satcat_path}: {of_when} has {bodies.matched} of "
            f"{counted(len(bodies), 'object')}; the others have default masses"
        )
    defaults = bodies.default_masses
    if satcat is None and defaults:
        notes.append(
            f"note: {sum(defaults.values())} of {counted(len(bodies), 'mass', 'masses')} are "
            "defaults: "
            + ", ".join(f"{what} {count}" for what, count in defaults.items())
            + "; give better ones with --satcat or --table"
        )
    return bodies, notes
