"""Fans of rehearsals over time, as charts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...analysis.rehearse.rehearsals import Rehearsals
from ...common.constants import DAY_S
from ...plan.palette import CHASERS
from .chart import Chart, ChartAxis, Line

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
    """A course of steps at some times; 0 before its first."""
    if not course:
        return np.zeros(times.size)
    whens, values = np.array(course, dtype=np.float64).T
    before = np.searchsorted(whens, times, side="right")
    return np.concatenate(([0.0], values))[before]
