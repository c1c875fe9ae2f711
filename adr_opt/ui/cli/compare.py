"""``compare``: compare plans of one instance, leg by leg."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import click

from ...common.errors import InputError
from . import complete, param
from .output import emit, emit_json, emit_rich, say_written
from .parameters import check_out

if TYPE_CHECKING:
    from rich.table import Table

    from ...analysis import Comparison
    from ...analysis.comparison import Difference


@click.command("compare", short_help="Compare plans, leg by leg.")
@param.instance
@click.argument(
    "plan_paths", nargs=-1, required=True, metavar="PLAN PLAN...", shell_complete=complete.files
)
@param.file("--page", "HTML file to write as well.", name="page_path")
@param.flag("--all", "List equal legs, too.", name="tell_all")
@param.spoken
def command(
    instance_path: str,
    plan_paths: tuple[str, ...],
    page_path: str | None,
    tell_all: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Compare two or more PLANs of INSTANCE, each with the first, leg by leg.

    Exit status 1: a plan has violations.
    """
    from ...analysis import compare
    from ...plan.plan import Plan
    from ...problem.instance import load
    from ..report.compared import compared_page
    from ..report.plain import check_page, write_page

    instance = load(instance_path)
    check_page(page_path)
    check_out(page_path, instance_path, *plan_paths)
    if len(set(plan_paths)) < len(plan_paths):
        raise InputError("a plan is given twice; give each once")
    plans = {_called(path, plan_paths): Plan.load(path) for path in plan_paths}
    comparison = compare(instance, plans)
    if page_path is not None:
        write_page(page_path, compared_page(comparison))
        say_written(page_path, quiet=quiet)
    if as_json:
        emit_json(comparison.to_dict())
    else:
        _tell(comparison, tell_all)
    return 1 if any(side.violations for side in comparison.sides) else 0


def _called(path: str, paths: tuple[str, ...]) -> str:
    """Name of a plan: that of its file, if unique."""
    name = os.path.basename(path)
    alone = sum(os.path.basename(other) == name for other in paths) == 1
    return name if alone else path


def _tell(comparison: Comparison, tell_all: bool) -> None:
    emit_rich(_sides(comparison))
    first = comparison.sides[0].name
    for difference in comparison.differences:
        if difference.same and not tell_all:
            emit(f"{difference.name}: all legs as in {first}")
            continue
        emit_rich(_legs(first, difference, tell_all))
        for words, names in (("gains", difference.gained), ("loses", difference.lost)):
            if names:
                emit(f"{difference.name} {words} {len(names)}: {', '.join(names)}")


def _sides(comparison: Comparison) -> Table:
    from ..report.compared import FIGURES
    from .tables import number_table

    rows = ((title, *map(tell, comparison.sides)) for title, tell in FIGURES.items())
    return number_table(comparison.instance.name, comparison.plans, rows, first="")


def _legs(first: str, difference: Difference, tell_all: bool) -> Table:
    from rich.text import Text

    from ..report.compared import more, told
    from ..report.text import NOTHING
    from .tables import number_table
    from .timeline import clock

    rows = []
    for pair in difference.pairs:
        if pair.what == "same" and not tell_all:
            continue
        cells = []
        for numbered in (pair.first, pair.other):
            if numbered is None:
                cells.append((NOTHING, NOTHING, NOTHING))
            else:
                at, leg = numbered
                cells.append((str(at), clock(leg.departure_s), f"{leg.delta_v_m_s:.1f}"))
        rows.append((Text(pair.destination), *cells[0], *cells[1][:2], more(pair), told(pair)))
    headings = ("leg", "departs", "ΔV\nm/s", "leg\nthere", "departs\nthere", "more\nm/s")
    title = f"{difference.name} against {first}"
    return number_table(title, headings, rows, first="destination", last="")
