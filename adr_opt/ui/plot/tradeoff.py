"""Prize and bound against a budget or a duration."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ...analysis.trade.axes import KINDS
from ...plan.palette import CHASERS
from .axes import label

if TYPE_CHECKING:
    from ...analysis.trade import Tradeoff

TITLES = {kind.name: kind.title for kind in KINDS.values()}
SCALES = {kind.name: kind.scale for kind in KINDS.values()}


def tradeoff(ax: Any, made: Tradeoff, kind: str | None = None) -> Any:
    """Add what the best plans collect, with a band up to the bounds; a line for each other limit.

    Where nothing is proven the band reaches up to all prizes.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    made : Tradeoff
    kind : {"delta-v", "propellant", "duration"}, optional
        What goes along the axis; the first that is varied by default.

    Returns
    -------
    matplotlib.axes.Axes
    """
    kind = kind or made.axes[0].kind
    rows = made.along(kind)
    other = "delta-v" if kind == "duration" else "duration"
    units = {"delta-v": "m/s", "duration": "days"}
    most = math.fsum(target.prize for target in made.instance.targets)
    for at, (value, row) in enumerate(rows.items()):
        there = [point for point in row if math.isfinite(point.prize)]
        x = [point.value(kind) / SCALES[kind] for point in there]
        prize = [point.prize for point in there]
        bound = [point.upper_bound if math.isfinite(point.upper_bound) else most for point in there]
        colour = CHASERS[at % len(CHASERS)]
        said = f"{value / SCALES[other]:g} {units[other]}" if len(rows) > 1 else "best plan"
        ax.plot(x, prize, color=colour, marker="o", markersize=4, label=said)
        ax.fill_between(x, prize, bound, color=colour, alpha=0.18, linewidth=0)
    label(ax, TITLES[kind], "prize")
    return ax
