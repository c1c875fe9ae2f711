"""The timeline as a Gantt chart."""

from __future__ import annotations

from ....plan.plan import Plan
from ....problem.instance import Instance
from ...plot.gantt import gantt_chart
from .parts import FRAME_PX, Figure, figure, of_bars, time_axis

ROW_PX = 19


def gantt(instance: Instance, plan: Plan) -> Figure:
    """One row per leg, the first on top, with a bar for each of its phases.

    Where there are several chasers, the legs of each come below a row with its name.
    """
    chart = gantt_chart(instance, plan, headed=True)
    return figure(
        chart, lambda bars: of_bars(plan, bars), xaxis=time_axis(instance, plan),
        height=FRAME_PX + ROW_PX * max(len(chart.y.rows or ()), 4), barmode="overlay",
    )  # fmt: skip
