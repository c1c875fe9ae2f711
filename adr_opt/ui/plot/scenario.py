"""Curves of a scenario: futures with campaigns and without, over time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ...plan.palette import CHASERS
from .chart import Chart, ChartAxis, Line

NAMES = {"without": "without removals", "with": "with removals"}

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def scenario_chart(told: Mapping[str, Any], name: str, title: str) -> Chart | None:
    """A number of each year in both cases, with a band of one standard error; None if it is 0.

    Parameters
    ----------
    told : mapping
        The answer, see :func:`adr_opt.analysis.scenario.scenario_answer`.
    name : str
        Number of a year.
    title : str
        Of the axis; a power of ten is added where numbers are small.
    """
    largest = max(max(told[case][name]["mean"]) for case in NAMES)
    if largest <= 0.0:
        return None
    power = 0 if largest >= 1.0 else 3 * math.floor(math.log10(largest) / 3.0)
    unit = 10.0**power
    years = [float(year) for year in told["years"]]
    lines = []
    for (case, said), colour in zip(NAMES.items(), CHASERS, strict=False):
        mean = [value / unit for value in told[case][name]["mean"]]
        error = told[case][name]["standard_error"]
        if error is not None:
            spread = [value / unit for value in error]
            above = [m + e for m, e in zip(mean, spread, strict=True)]
            below = [max(m - e, 0.0) for m, e in zip(mean, spread, strict=True)]
            lines.append(Line(name=f"{said}, ± 1 σ", colour=colour, x=years, y=above, below=below))
        lines.append(Line(name=said, colour=colour, x=years, y=mean))
    if power:
        title += " × 10" + str(power).translate(SUPERSCRIPTS)
    return Chart(tuple(lines), ChartAxis("year"), ChartAxis(title))
