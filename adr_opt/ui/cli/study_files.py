"""Files that studies write beside their answer: charts as pictures, and the plans of points."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

from ...common.errors import InputError, MissingExtra

if TYPE_CHECKING:
    from ...analysis.trade import Tradeoff
    from ...plan.plan import Plan
    from ...problem.instance import Instance
    from ..plot.chart import Chart


def check_picture(path: str | None) -> None:
    """Before long work begins, refuse a requested picture that cannot be drawn.

    Raises
    ------
    InputError
        Its name ends neither in .svg nor in .png nor in .pdf.
    MissingExtra
        matplotlib is not installed.
    """
    if path is None:
        return
    if not path.lower().endswith((".svg", ".png", ".pdf")):
        raise InputError(f"{path}: pictures end in .svg, .png or .pdf; rename it")
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise MissingExtra("a picture", "matplotlib", "viz") from None


def write_picture(chart: Chart, path: str) -> None:
    """Draw a chart with its legend, completely or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    from ...common.files import write_whole
    from ..plot.chart import draw

    figure, ax = pyplot.subplots(figsize=(7.0, 4.2), layout="constrained")
    draw(ax, chart).legend()
    write_whole(path, figure.savefig)
    pyplot.close(figure)


_WRITTEN = re.compile(r"(?:point|design)-\d+\.(?:instance\.json|plan\.json|html)")
"""Names of files of points."""


def check_folder(folder: str, instance: str) -> None:
    """Raise :class:`InputError` unless plans of an instance file can be written into a folder."""
    path, source = Path(folder), Path(instance)
    if _WRITTEN.fullmatch(source.name) and source.resolve().parent == path.resolve():
        raise InputError(f"{folder}: the plans would replace {instance}; name another folder")
    if path.exists() and not path.is_dir():
        raise InputError(f"{folder}: this is a file; name a folder for the plans")
    parent = path.resolve().parent
    if not path.exists() and not parent.is_dir():
        raise InputError(f"{folder}: the folder {path.parent} does not exist; create it first")
    if not os.access(path if path.exists() else parent, os.W_OK):
        raise InputError(f"{folder}: the folder cannot be written to; choose another")


def cleared(folder: str) -> Path:
    """Prepare a folder: create it, or remove files of an earlier call."""
    path = Path(folder)
    path.mkdir(exist_ok=True)
    for old in path.iterdir():
        if _WRITTEN.fullmatch(old.name):
            old.unlink()
    return path


def write_plan(folder: Path, stem: str, instance: Instance, plan: Plan) -> dict[str, Path]:
    """Write the instance and the plan of a point; returns their paths by what they are."""
    files = {"instance": folder / f"{stem}.instance.json", "plan": folder / f"{stem}.plan.json"}
    instance.save(files["instance"])
    plan.save(files["plan"])
    return files


def write_points(made: Tradeoff, folder: str) -> None:
    """Write instance and plan of each point of a trade-off that has a plan."""
    from ...analysis.trade.plans import plans_of

    where = cleared(folder)
    digits = len(str(len(made.points)))
    for at, instance, plan in plans_of(made):
        write_plan(where, f"point-{at + 1:0{digits}d}", instance, plan)
