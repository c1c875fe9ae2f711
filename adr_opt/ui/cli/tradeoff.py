"""``tradeoff``: the value of budgets and durations, as a curve or surface of plans and bounds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ...common.errors import InputError
from ...common.wording import counted
from . import designs, param
from .output import emit_json, emit_rich, say, say_written
from .parameters import admitted_plan, check_outs
from .study_files import check_folder, check_picture, write_picture, write_points

if TYPE_CHECKING:
    from rich.table import Table

    from ...analysis.trade import Point, Tradeoff
    from ...analysis.trade.frontier import Ending
    from ...analysis.trade.points import KnownPoints
    from ...common.stop import Stop


@click.command("tradeoff", short_help="Trade off budgets, durations, drives or designs.")
@param.instance
@param.many(
    "--vary",
    "NAME=LO:HI:STEP",
    "Range of delta-v [m/s], propellant [kg], duration [d], thrust [N] or isp [s], or, of designs, "
    "launches, separation [years], kits, dry-mass [kg], start [d], launch [years], altitude [km] "
    "or budget [euros]; or "
    "VALUE,VALUE...; repeatable.",
    name="varied",
)
@param.file(
    "--frontier",
    "CSV file of least ΔV against the last day, at the largest prize; needs no --vary.",
    name="frontier_path",
)
@param.file(
    "--worth",
    "JSON file of 'worth --pairs': plans with floors, bounds with worths alone.",
    "worth_path",
)
@param.number("--launch-cost", "EUR", "Of designs: euros for each launch.")
@param.number("--kit-cost", "EUR", "Of designs: euros for each kit.")
@param.number("--kg-cost", "EUR", "Of designs: euros for each kilogram at launch.")
@param.many("--start", "PLAN", "Plan of INSTANCE to start from; repeatable.", "start_paths")
@param.method
@param.time_limit("Wall-clock limit of each run; default 10 s.")
@param.seed
@param.processes
@param.file(
    "--out",
    "CSV table to write, with a .jsonl file beside it from which the same call resumes; any name "
    "but .csv: the latter file alone.",
)
@param.page
@param.file("--plot", "Picture to write: .svg, .png or .pdf.", name="plot_path")
@param.word("--plans", "FOLDER", "Folder for instances and plans; of designs, reports as well.")
@param.cluster
@param.spoken
def command(
    instance_path: str,
    varied: tuple[str, ...],
    frontier_path: str | None,
    worth_path: str | None,
    launch_cost: float | None,
    kit_cost: float | None,
    kg_cost: float | None,
    start_paths: tuple[str, ...],
    method: str | None,
    time_limit: float | None,
    seed: int,
    jobs: int,
    cluster: str | None,
    out: str | None,
    page_path: str | None,
    plot_path: str | None,
    plans: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Plan INSTANCE for a range of budgets, durations, drives or designs, and prove bounds.

    Plans also count for all points with more ΔV and time, and bounds for those with less. Designs,
    which have costs in euros, are planned, bounded and evaluated each by itself. Ctrl-C stops with
    the results so far; with --out the same call resumes later. Exit status 1: a point has no plan.
    """
    from ...analysis.trade import Axis, frontier, parse_axis, tradeoff
    from ...analysis.trade.axes import KINDS
    from ...analysis.trade.frontier import check_frontier, write_frontier
    from ...analysis.trade.points import write_table
    from ...problem.instance import load
    from ...run import front
    from ..report.plain import check_page, write_page
    from ..report.traded import traded_page
    from .bars import counting_bar, wanted
    from .work import work

    axes = [parse_axis(text) for text in varied]
    instance = load(instance_path)
    limit = front.DEFAULT_TIME_LIMIT_S if time_limit is None else time_limit
    costs = designs.EuroCosts(launch_cost, kit_cost, kg_cost)
    check_page(page_path)
    check_picture(plot_path)
    priced = any(cost is not None for cost in costs)
    if priced or worth_path or any(KINDS[axis.kind].of_designs for axis in axes):
        for sign, unused in (("--frontier", frontier_path), ("--start", start_paths)):
            if unused:
                raise InputError(f"{sign}: designs have none; leave it out")
        return designs.study(
            instance_path,
            instance,
            axes,
            worth_path,
            costs,
            designs.StudySettings(method or front.DEFAULT_METHOD, limit, seed, jobs, cluster),
            designs.StudyOutputs(out, page_path, plot_path, plans),
            as_json=as_json,
            quiet=quiet,
        )
    if plans is not None:
        check_folder(plans, instance_path)
    rows = out if out is None else _rows_of(out)
    results = [frontier_path, plot_path, page_path, out]
    read = (instance_path, *start_paths)
    check_outs(results if rows == out else [*results, rows], *read)
    starts = [admitted_plan(instance_path, path) for path in start_paths]
    if frontier_path is not None:
        check_frontier(instance, axes)
        axes = axes or [Axis("duration", (instance.mission.duration_s,))]

    def told(point: Point, board: KnownPoints) -> None:
        proven = sum(each.proven for each in board.points.values())
        show(proven, len(board.points))
        if not quiet:
            say(
                f"{_called(point)}: {point.methods[-1]} {point.prize:g}, bound "
                f"{board.points[point.limits].upper_bound:g}; {proven} of {len(board.points)} "
                "points proven"
            )

    def run(stop: Stop) -> tuple[Tradeoff, tuple[Ending, ...]]:
        made = tradeoff(
            instance,
            axes,
            method=method or front.DEFAULT_METHOD,
            time_limit=limit,
            seed=seed,
            jobs=jobs,
            cluster=cluster,
            path=rows,
            starts=starts,
            stop=stop,
            told=told,
        )
        if frontier_path is None:
            return made, ()
        heard = (lambda text: None) if quiet else say
        return made, frontier(made, time_limit=limit, seed=seed, stop=stop, told=heard)

    with counting_bar(wanted(as_json, quiet), "proven points") as show:
        made, endings = work(lambda stop, progress: run(stop), live=False, quiet=quiet)
    if out is not None and out != rows:
        write_table(out, made)
    if frontier_path is not None:
        write_frontier(frontier_path, endings)
    if page_path is not None:
        write_page(page_path, traded_page(made, endings))
    if plot_path is not None:
        from ..plot.fronts import tradeoff_chart

        write_picture(tradeoff_chart(made, made.axes[0].kind), plot_path)
    if plans is not None:
        write_points(made, plans)
    say_written(out, frontier_path, page_path, plot_path, plans, quiet=quiet)
    if as_json:
        stated = {"frontier": [ending.to_dict() for ending in endings]} if frontier_path else {}
        emit_json(made.to_dict() | stated)
    else:
        emit_rich(_table(made))
        if endings:
            emit_rich(_frontier_table(endings))
    return 0 if all(point.routes for point in made.points) else 1


def _rows_of(out: str) -> str:
    """The file of the runs beside a table.

    Raises
    ------
    InputError
        There is a table without them, which would be lost.
    """
    path = Path(out)
    if path.suffix.lower() != ".csv":
        return out
    rows = path.with_suffix(".jsonl")
    if path.exists() and not rows.exists():
        raise InputError(
            f"{out}: exists without {rows}, so it cannot be resumed, like tables of adr-opt 1.0; "
            "name another file"
        )
    return str(rows)


def _called(point: Point) -> str:
    from ...common.constants import DAY_S

    drive = f", {point.thrust_n:g} N" if point.thrust_n is not None else ""
    drive += f", {point.isp_s:g} s" if point.isp_s is not None else ""
    return f"{point.delta_v_m_s:g} m/s, {point.duration_s / DAY_S:g} d{drive}"


def _table(made: Tradeoff) -> Table:
    from ..report.traded import point_columns
    from .tables import number_table

    title = f"{made.instance.name}: {made.proven} of {counted(len(made.points), 'point')} proven"
    columns = point_columns(made)
    rows = ([tell(point) for tell in columns.values()] for point in made.points)
    return number_table(title, columns, rows)


def _frontier_table(endings: tuple[Ending, ...]) -> Table:
    from ..report.traded import FRONTIER, FRONTIER_COLUMNS
    from .tables import number_table

    rows = ([tell(ending) for tell in FRONTIER_COLUMNS.values()] for ending in endings)
    return number_table(FRONTIER, FRONTIER_COLUMNS, rows)
