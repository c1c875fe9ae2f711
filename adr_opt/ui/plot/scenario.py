"""Curves of a scenario: futures with campaigns and without, over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...plan.palette import CHASERS
from .chart import Chart, ChartAxis, Line

NAMES = {"without": "without removals", "with": "with removals"}


def scenario_chart(told: Mapping[str, Any], name: str, title: str) -> Chart:
    """A number of each year in both cases, with a band of one standard error.

    Parameters
    ----------
    told : mapping
        The answer, see :func:`adr_opt.analysis.scenario.scenario_answer`.
    name : str
        Number of a year.
    title : str
        Of the axis.
    """
    years = [float(year) for year in told["years"]]
    lines = []
    for (case, said), colour in zip(NAMES.items(), CHASERS, strict=False):
        mean, error = told[case][name]["mean"], told[case][name]["standard_error"]
        above = mean if error is None else [m + e for m, e in zip(mean, error, strict=True)]
        below = [] if error is None else [m - e for m, e in zip(mean, error, strict=True)]
        if below:
            lines.append(Line(name=f"{said}, ± 1 σ", colour=colour, x=years, y=above, below=below))
        lines.append(Line(name=said, colour=colour, x=years, y=list(mean)))
    return Chart(tuple(lines), ChartAxis("year"), ChartAxis(title))
