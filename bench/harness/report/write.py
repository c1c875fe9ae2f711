"""Make the report: page, summary and pictures."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import asdict, fields
from importlib.util import find_spec
from pathlib import Path

from adr_opt.common.errors import InputError, MissingExtra
from adr_opt.common.files import write_text

PACKAGES = ("scipy", "plotly", "matplotlib")


def write(rows: Path, folder: Path) -> Path:
    """Write ``report.html``, ``summary.csv``, charts and their tables of a file into a folder.

    Returns
    -------
    Path
        Of the page.

    Raises
    ------
    InputError
        There is nothing to report.
    MissingExtra
        A package of the report is not installed.
    """
    need()
    from . import quality
    from .model import Means, read
    from .page import page
    from .pictures import draw

    results = read(rows)
    if not results.sections:
        raise InputError(f"{rows}: holds no row yet; run without --report-only first")
    path = folder / "report.html"
    write_text(path, page(results))
    text = io.StringIO()
    table = csv.DictWriter(text, [field.name for field in fields(Means)], lineterminator="\n")
    table.writeheader()
    for section in results.sections:
        for method in section.rows:
            line = asdict(section.means(method))
            table.writerow({key: "" if _is_nan(value) else value for key, value in line.items()})
    write_text(folder / "summary.csv", text.getvalue())
    for section in results.sections:
        draw(section, results.labels, folder)
        found = quality.spots(section)
        quality.write_table(found, folder / f"quality-{section.stem}.csv")
        quality.draw(found, folder / f"quality-{section.stem}.svg", section.title)
    return path


def need() -> None:
    """See that the packages of the report are there, before hours of work.

    Raises
    ------
    MissingExtra
        One is not installed.
    """
    for package in PACKAGES:
        if find_spec(package) is None:
            raise MissingExtra("the report of the benchmark", package, "bench")


def _is_nan(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)
