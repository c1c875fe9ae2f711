"""Prize and bound against a budget or a duration."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ...analysis.trade.axes import KINDS, AxisKind
from ...plan.palette import CHASERS
from .chart import Chart, ChartAxis, Line
from .draw import draw

if TYPE_CHECKING:
    from ...analysis.trade.points import Tradeoff


def tradeoff_chart(made: Tradeoff, kind: str) -> Chart:
    """Prizes of the best plans against a limit, with bands up to the bounds, or to all prizes.

    There is a line for each combination of the values of the other axes.
    """
    along, others = KINDS[kind], [axis.kind for axis in made.axes if axis.kind != kind]
    rows = made.along(kind)
    most = math.fsum(target.greatest_prize for target in made.instance.targets)
    lines = []
    for at, (values, row) in enumerate(rows.items()):
        pairs = zip(others, values, strict=True)
        name = ", ".join(named(KINDS[other], value) for other, value in pairs)
        there = [point for point in row if math.isfinite(point.prize)]
        bounds = [point.upper_bound for point in there]
        lines.append(
            Line(
                name=name if len(rows) > 1 else "plans, and up to the bound",
                colour=CHASERS[at % len(CHASERS)],
                width=2.0,
                dots=True,
                x=[point.value(kind) / along.scale for point in there],
                y=[point.prize for point in there],
                below=[bound if math.isfinite(bound) else most for bound in bounds],
            )
        )
    return Chart(tuple(lines), ChartAxis(along.title), ChartAxis("prize"))


def named(kind: AxisKind, value: float) -> str:
    """A limit and its value."""
    return f"{kind.name} {value / kind.scale:,g} {kind.unit}"


def tradeoff(ax: Any, made: Tradeoff, kind: str | None = None) -> Any:
    """Add prizes of the best plans, with a band up to the bounds; a line for each value of others.

    Where nothing is proven the band reaches up to all prizes.

    Parameters
    ----------
    made : Tradeoff
    kind : {"delta-v", "propellant", "duration", "thrust", "isp"}, optional
        What goes along the axis; the first that is varied by default.
    """
    return draw(ax, tradeoff_chart(made, kind or made.axes[0].kind))
