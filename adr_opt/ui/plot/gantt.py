"""The timeline as a Gantt chart."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from ...plan.phases import COLOURS, LABELS, PHASES
from ...plan.plan import Plan
from ...plan.routes import routes_of, several
from ...problem.instance import Instance
from .chart import DAYS, Bars, Chart, ChartAxis, days
from .draw import draw
from .segments import Segment, segments


def phase_bars(found: Iterable[Segment], row_of: Callable[[int], int]) -> list[Bars]:
    """Segments of each phase as bars, in the row of their leg."""
    of_phase: dict[str, list[Segment]] = {phase: [] for phase in PHASES}
    for segment in found:
        of_phase[segment.phase].append(segment)
    return [
        Bars(
            name=LABELS[phase],
            colour=COLOURS[phase],
            phase=phase,
            of=bars,
            legs=[bar.leg for bar in bars],
            x=days([bar.start_s for bar in bars]),
            y=[row_of(bar.leg) for bar in bars],
            lengths=days([bar.duration_s for bar in bars]),
        )
        for phase, bars in of_phase.items()
        if bars
    ]


def gantt_chart(instance: Instance, plan: Plan, *, headed: bool) -> Chart:
    """One row per leg, named by its destination, first on top, with a bar for each phase.

    Parameters
    ----------
    instance : Instance
    plan : Plan
    headed : bool
        Whether the legs of each of several chasers come below a row with its name; otherwise the
        name stands before the destination of its first leg.
    """
    rows: list[str] = []
    headings: list[int] = []
    row_of: dict[int, int] = {}
    for flown in routes_of(instance, plan):
        who = flown.chaser.name if several(instance) else ""
        if who and headed:
            rows.append(who)
            headings.append(len(rows))
        for at, (number, leg) in enumerate(flown.legs):
            is_named = who and not headed and at == 0
            rows.append(f"{who}: {leg.destination}" if is_named else leg.destination)
            row_of[number] = len(rows)
    bars = phase_bars(segments(instance, plan), row_of.__getitem__)
    return Chart(
        tuple(bars), DAYS, ChartAxis("destination", rows=tuple(rows), headings=tuple(headings))
    )


def gantt(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add one row per leg, first on top, with its phases as bars against time [days].

    Where there are several chasers, the first leg of each has its name beside the destination.

    Raises
    ------
    InputError
        The plan belongs to another instance.
    """
    return draw(ax, gantt_chart(instance, plan, headed=False))
