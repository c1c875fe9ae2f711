"""Charts of studies: approaches, worth of removals, scenarios and rehearsals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ...analysis.rehearse.rehearsals import Rehearsals
from ...analysis.screening import CloseApproach
from ...common.constants import DAY_S
from ...plan.palette import CHASERS
from ...sources.worth import RemovalWorth
from ...sources.worth.bodies import ends_km
from .chart import KM_M, Chart, ChartAxis, Line, Marks, draw


def approaches_chart(found: Sequence[CloseApproach]) -> Chart:
    """Misses of approaches against time; visited bodies have open circles."""
    series = []
    for name, own, symbol in (("objects", False, "circle"), ("visited", True, "circle-open")):
        there = [each for each in found if each.own == own]
        days = [each.time_s / DAY_S for each in there]
        misses_km = [each.miss_m / KM_M for each in there]
        series.append(Marks(name=name, colour=CHASERS[own], x=days, y=misses_km, symbol=symbol))
    return Chart(tuple(series), ChartAxis("time [d]"), ChartAxis("miss [km]"))


def approaches(ax: Any, found: Sequence[CloseApproach]) -> Any:
    """Add misses of approaches against time; visited bodies have open circles.

    Parameters
    ----------
    found : sequence of CloseApproach
        As :func:`adr_opt.analysis.screening.screen` finds them.
    """
    return draw(ax, approaches_chart(found))


STEP_KM, HIGHEST_KM = 50.0, 2000.0
"""Bands of mean altitude."""

OBJECT_KINDS = ("rocket body", "payload", "debris")


def worth_chart(worth: RemovalWorth) -> Chart:
    """Sums of worths alone in bands of altitude, for each kind of object."""
    bodies = worth.bodies
    altitudes = np.array([sum(ends_km(record)) / 2.0 for record in bodies.records])
    edges = np.arange(0.0, HIGHEST_KM + STEP_KM, STEP_KM)
    lines = []
    for kind, colour in zip(OBJECT_KINDS, CHASERS, strict=False):
        own = np.array([each == kind for each in bodies.kinds])
        sums = np.histogram(altitudes[own], edges, weights=worth.alone[own])[0]
        first = int(np.argmax(edges >= 300.0))
        lines.append(
            Line(
                name=kind,
                colour=colour,
                step=True,
                x=edges[first:].tolist(),
                y=[*sums[first:].tolist(), 0.0],
            )
        )
    title = f"fragment-years by {STEP_KM:g} km"
    return Chart(tuple(lines), ChartAxis("mean altitude [km]"), ChartAxis(title))


CASES = {"without": "without removals", "with": "with removals"}

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def scenario_chart(told: Mapping[str, Any], name: str, title: str) -> Chart | None:
    """A count of each year in both cases, with a band of one standard error; None if always 0.

    Parameters
    ----------
    told : mapping
        The answer, see :func:`adr_opt.analysis.scenario.scenario_answer`.
    name : str
        Number of a year.
    title : str
        Of the axis; a power of ten is added where numbers are small.
    """
    largest = max(max(told[case][name]["mean"]) for case in CASES)
    if largest <= 0.0:
        return None
    power = 0 if largest >= 1.0 else 3 * math.floor(math.log10(largest) / 3.0)
    unit = 10.0**power
    years = [float(year) for year in told["years"]]
    lines = []
    for (case, said), colour in zip(CASES.items(), CHASERS, strict=False):
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


TIMES = 80
"""Number of times at which quantiles are taken."""

BANDS = ((0.05, 0.95), (0.25, 0.75))


def prize_fan(made: Rehearsals) -> Chart:
    """Prize collected over time: the plan, the median, and quantiles of all rehearsals."""
    prizes = {target.name: target.prize for target in made.instance.targets}
    planned, total = [(0.0, 0.0)], 0.0
    for leg in sorted(made.plan.legs, key=lambda leg: leg.end_s):
        total += prizes.get(leg.destination, 0.0)
        planned.append((leg.end_s, total))
    courses = [each.course for each in made.outcomes]
    return _fan(made, courses, planned, "prize")


def delta_v_fan(made: Rehearsals) -> Chart:
    """ΔV of all legs over time."""
    planned, total = [(0.0, 0.0)], 0.0
    for leg in sorted(made.plan.legs, key=lambda leg: leg.arrival_s):
        total += leg.delta_v_m_s
        planned.append((leg.arrival_s, total))
    return _fan(made, [each.spent for each in made.outcomes], planned, "ΔV of all legs [m/s]")


MOST_BINS = 24


def visits_spread(made: Rehearsals) -> Chart:
    """Histogram of visits over rehearsals, and the planned number."""
    found = [len(each.course) for each in made.outcomes]
    planned = len(set(made.plan.destinations) - set(made.instance.station_names))
    return _spread(found, planned, np.arange(min(found), max(found) + 2) - 0.5, "visits")


def delta_v_spread(made: Rehearsals) -> Chart:
    """Histogram of ΔV over rehearsals, and the planned ΔV."""
    found = [each.delta_v_m_s for each in made.outcomes]
    edges = np.histogram_bin_edges(found, MOST_BINS)
    return _spread(found, made.plan.delta_v_m_s, edges, "ΔV of all legs [m/s]")


def _spread(
    found: Sequence[float], planned: float, edges: npt.NDArray[np.floating[Any]], title: str
) -> Chart:
    counts = np.histogram(found, edges)[0].tolist()
    lines = (
        Line(
            name="rehearsals", colour=CHASERS[0], step=True, x=[edges[0], *edges], y=[0, *counts, 0]
        ),
        Line(name="plan", colour=CHASERS[1], x=[planned, planned], y=[0, max(counts)]),
    )
    return Chart(lines, ChartAxis(title), ChartAxis("rehearsals"))


def _fan(
    made: Rehearsals,
    courses: Sequence[Sequence[tuple[float, float]]],
    planned: Sequence[tuple[float, float]],
    title: str,
) -> Chart:
    times = np.linspace(0.0, made.instance.mission.duration_s, TIMES)
    values = np.array([_at(course, times) for course in courses])
    days = (times / DAY_S).tolist()
    lines = [
        Line(
            name=f"{low:.0%} to {high:.0%} of rehearsals",
            colour=CHASERS[0],
            width=0.0,
            x=days,
            y=np.quantile(values, high, axis=0).tolist(),
            below=np.quantile(values, low, axis=0).tolist(),
        )
        for low, high in BANDS
    ]
    lines.append(
        Line(name="median", colour=CHASERS[0], x=days, y=np.median(values, axis=0).tolist())
    )
    lines.append(
        Line(name="plan", colour=CHASERS[1], x=days, y=_at(planned, times).tolist(), step=True)
    )
    return Chart(tuple(lines), ChartAxis("days"), ChartAxis(title))


def _at(
    course: Sequence[tuple[float, float]], times: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Values of a step function at some times; 0 before its first step."""
    if not course:
        return np.zeros(times.size)
    whens, values = np.array(course, dtype=np.float64).T
    before = np.searchsorted(whens, times, side="right")
    return np.concatenate(([0.0], values))[before]
