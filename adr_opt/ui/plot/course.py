"""The course of a run: best plan, bound and the gap between them, over time."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from ...plan.palette import CHASERS, VISITED
from ...plan.plan import CoursePoint, relative_gap
from .chart import Chart, ChartAxis, Line

BOUND = CHASERS[0]
"""Colour of bounds, which are dashed, too."""

RUN = "Best plan and bound over the run, as it stated them"
"""Caption of the chart."""

Corners = list[tuple[float, float]]


def course_chart(course: Sequence[CoursePoint], until_s: float = 0.0) -> Chart:
    """Best plan and bound against time [s]; the band between them is the gap.

    Parameters
    ----------
    course : sequence of (float, float or None, float or None)
        As :attr:`.Plan.course`.
    until_s : float
        End of the run, if it is later than the last change [s].
    """
    end = max(until_s, course[-1][0]) if course else until_s
    best = _stairs([(at, value) for at, value, _ in course if value is not None], end)
    bound = _stairs([(at, value) for at, _, value in course if value is not None], end)
    known = [(at, one, two) for at, one, two in course if one is not None and two is not None]
    lines: list[Line] = []
    if known:
        over = _stairs([(at, two) for at, _, two in known], end)
        under = _stairs([(at, one) for at, one, _ in known], end)
        first, last = (100.0 * relative_gap(one, two) for _, one, two in (known[0], known[-1]))
        fell = f"{first:.3g} % → " if len(known) > 1 else ""
        times, above, below = [at for at, _ in over], _values(over), _values(under)
        gap = f"gap: {fell}{last:.3g} %"
        lines.append(Line(name=gap, colour=BOUND, width=0.0, x=times, y=above, below=below))
    if bound:
        lines.append(_line("bound", BOUND, bound))
    if best:
        lines.append(_line("best plan", VISITED, best))
    return Chart(tuple(lines), ChartAxis("time [s]"), ChartAxis("prize"))


def _line(name: str, colour: str, corners: Corners) -> Line:
    times = [at for at, _ in corners]
    return Line(name=name, colour=colour, x=times, y=_values(corners), dashed=colour == BOUND)


def _values(corners: Corners) -> list[float]:
    return [value for _, value in corners]


def _stairs(points: Corners, end: float) -> Corners:
    """Corners of values each of which holds until the next one."""
    if not points:
        return []
    corners = []
    for (at, value), (then, _) in pairwise([*points, (end, 0.0)]):
        corners += [(at, value), (then, value)]
    return corners
