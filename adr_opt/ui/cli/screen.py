"""``screen``: approaches of the objects of a catalogue to a refined plan."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Sequence
from pathlib import Path

import click

from ...common.errors import InputError
from ...common.wording import counted
from . import complete, param
from .output import emit_json, emit_rich, say, say_written
from .parameters import admitted_refined, check_outs

SHOWN = 20
"""Number of approaches in the printed table."""


@click.command("screen", short_help="Find approaches of catalogued objects to a refined plan.")
@param.instance
@click.argument("refined_path", metavar="REFINED", shell_complete=complete.files)
@param.files
@param.number(
    "--distance",
    "M",
    "Largest distance of a reported approach.",
    "distance_m",
    default=5000.0,
    show_default=True,
)
@param.errors
@param.file("--out", "CSV file of approaches to write.")
@param.word(
    "--messages",
    "FOLDER",
    "New folder, or .zip file, for a conjunction data message (CCSDS) of each approach that is not "
    "a visit.",
)
@param.page
@param.skip_bad
@param.spoken
def command(
    instance_path: str,
    refined_path: str,
    files: tuple[str, ...],
    distance_m: float,
    errors_path: str | None,
    out: str | None,
    messages: str | None,
    page_path: str | None,
    skip_bad: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Find all approaches of the objects in FILE... to the arcs of REFINED.

    Objects move by SGP4. Bodies that a leg leaves or leads to are counted separately.
    """
    from ...analysis.screening import approaches_csv, conjunction_message, read_errors, screen
    from ...common.files import write_text
    from ...sources import catalogue
    from ..report.plain import check_page, write_page
    from ..report.screened import columns, knows_probabilities, screening_page
    from .tables import number_table

    check_outs((out, page_path), instance_path, refined_path, *files, errors_path)
    if page_path is not None:
        check_page(page_path)
    if messages is not None:
        _check_folder(messages, errors_path)
    errors = {} if errors_path is None else read_errors(errors_path)
    admitted = admitted_refined(instance_path, refined_path)
    found = catalogue.read(files, skip_bad=skip_bad)
    approaches = screen(
        admitted.instance, admitted, found.records, distance_m=distance_m, errors=errors
    )
    others = [each for each in approaches if not each.own]
    if messages is not None:
        _write_messages(messages, [conjunction_message(each, errors) for each in others])
    if out is not None:
        write_text(out, approaches_csv(approaches))
    if page_path is not None:
        name, count = admitted.instance.name, len(found.records)
        write_page(page_path, screening_page(name, approaches, distance_m, count))
    found_of_others = counted(len(others), "approach", "approaches")
    say(
        f"{counted(len(found.records), 'object')}: {found_of_others} within {distance_m:g} m, and "
        f"{len(approaches) - len(others)} by visited bodies",
        unless=quiet,
    )
    say_written(out, messages, page_path, quiet=quiet)
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
        shown = columns(probable=knows_probabilities(others))
        headings = [title for title, *_ in shown]
        rows = ([str(tell(each)) for *_, tell in shown] for each in nearest)
        title = f"The {len(nearest)} nearest approaches of {len(others)}"
        emit_rich(number_table(title, headings[1:], rows, first=headings[0]))
    return 0


def _check_folder(folder: str, errors: str | None) -> None:
    """Refuse a folder to which messages cannot be written, before anything is computed."""
    path = Path(folder)
    if errors is None:
        raise InputError("--messages needs --errors: a message states covariances")
    if path.exists():
        raise InputError(f"{folder}: exists already; name a new folder for the messages")
    parent = path.resolve().parent
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise InputError(f"{folder}: {parent} is not a writable folder")


def _write_messages(place: str, texts: Sequence[str]) -> None:
    from ...common.files import write_bytes, write_text

    names = [f"{number:0{len(str(len(texts)))}d}.cdm" for number in range(1, len(texts) + 1)]
    if place.lower().endswith(".zip"):
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, text in zip(names, texts, strict=True):
                archive.writestr(name, text)
        write_bytes(place, packed.getvalue())
        return
    Path(place).mkdir()
    for name, text in zip(names, texts, strict=True):
        write_text(Path(place) / name, text)
