"""``tradeoff`` over designs: plans, bounds and sets of campaigns against euros."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import quote

from ...common.errors import MissingExtra
from .output import emit_json, emit_rich, say
from .parameters import check_outs
from .study_files import check_folder, cleared, write_picture, write_plan

if TYPE_CHECKING:
    from rich.table import Table

    from ...analysis.design.results import DesignPoint, DesignStudy
    from ...analysis.trade import Axis
    from ...common.stop import Stop
    from ...problem.instance import Instance


class EuroCosts(NamedTuple):
    """Prices as a command line gives them [euros]."""

    launch: float | None
    kit: float | None
    kilogram: float | None


class StudyOutputs(NamedTuple):
    """Files that a study writes; None for those not requested."""

    results: str | None
    page: str | None
    plot: str | None
    plans: str | None


class StudySettings(NamedTuple):
    """Settings of the runs of designs."""

    method: str
    time_limit: float
    seed: int
    jobs: int
    cluster: str | None


def study(
    instance_path: str,
    instance: Instance,
    axes: Sequence[Axis],
    worth_path: str | None,
    costs: EuroCosts,
    settings: StudySettings,
    outputs: StudyOutputs,
    *,
    as_json: bool,
    quiet: bool,
) -> int:
    """Run a study of designs and write its results; returns the exit status."""
    from ...analysis.design.prices import CampaignPrices
    from ...analysis.design.study import design_study
    from ...sources.worth import load_set_worths
    from ..report.designs import designs_page
    from ..report.plain import write_page
    from .bars import counting_bar, wanted
    from .work import work

    check_outs((outputs.results, outputs.page, outputs.plot), instance_path, worth_path)
    if outputs.plans is not None:
        check_folder(outputs.plans, instance_path)
    worths = None if worth_path is None else load_set_worths(worth_path)

    def told(point: DesignPoint, done: int, of: int) -> None:
        show(done, of)
        if not quiet:
            say(f"{point.design.title}: {_said(point)}; {done} of {of} designs")

    def run(stop: Stop) -> DesignStudy:
        return design_study(
            instance,
            axes,
            worths=worths,
            prices=CampaignPrices(*costs),
            method=settings.method,
            time_limit=settings.time_limit,
            seed=settings.seed,
            jobs=settings.jobs,
            cluster=settings.cluster,
            path=outputs.results,
            stop=stop,
            told=told,
        )

    with counting_bar(wanted(as_json, quiet), "designs") as show:
        made = work(lambda stop, progress: run(stop), live=False, quiet=quiet)
    if made.rating.left_out:
        say(
            f"left out, as their worth is unknown: {len(made.rating.left_out)} of "
            f"{len(instance.targets)} targets",
            unless=quiet,
        )
    links = {} if outputs.plans is None else _write_plans(made, outputs.plans, quiet)
    if outputs.page is not None:
        around = Path(outputs.page).resolve().parent
        relative = {
            at: {what: quote(os.path.relpath(path, around)) for what, path in files.items()}
            for at, files in links.items()
        }
        write_page(outputs.page, designs_page(made, relative))
    if outputs.plot is not None:
        from ..plot.fronts import designs_chart

        write_picture(designs_chart(made), outputs.plot)
    for path in outputs:
        if path is not None and Path(path).exists():
            say(f"wrote {path}", unless=quiet)
    if as_json:
        emit_json(made.to_dict())
    else:
        emit_rich(_table(made))
    whole = len(made.points) == made.wanted and all(point.plan for point in made.points)
    return 0 if whole else 1


def _said(point: DesignPoint) -> str:
    from ...sources.worth.answer import figure

    if point.plan is None:
        return f"no plan, at most {figure(point.bound)}"
    return (
        f"{figure(point.worth)} avoided of at most {figure(point.bound)}, "
        f"{point.euros / 1e6:.2f} million euros"
    )


def _write_plans(made: DesignStudy, folder: str, quiet: bool) -> dict[int, dict[str, Path]]:
    """Instance, plan and report of each design; returns their paths by the design's place."""
    from ..report import write_report

    where, found = cleared(folder), dict[int, dict[str, Path]]()
    digits, reports = len(str(made.wanted)), True
    for at, point in enumerate(made.points):
        if point.plan is None:
            continue
        stem = f"design-{at + 1:0{digits}d}"
        files = write_plan(where, stem, point.instance, point.plan)
        if reports:
            report = where / f"{stem}.html"
            try:
                write_report(point.instance, point.plan, report)
                files = {"report": report, **files}
            except MissingExtra as error:
                reports = False
                say(f"plans without reports: {error}", unless=quiet)
        found[at] = files
    return found


def _table(made: DesignStudy) -> Table:
    from ..report.designs import design_columns
    from .tables import number_table

    unit = made.rating.unit or "prize"
    title = f"{made.instance.name}: {len(made.points)} of {made.wanted} designs, in {unit}"
    columns = design_columns(made)
    points = enumerate(made.points)
    rows = ([tell(*each) for tell in columns.values()] for each in points)
    return number_table(title, columns, rows)
