"""Prize and bound against a budget or a duration."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from .axes import label
from .palette import CHASERS

if TYPE_CHECKING:
    from ..analysis.trade import Tradeoff

TITLES = {"delta-v": "ΔV of a full tank [m/s]", "duration": "duration [days]"}
SCALES = {"delta-v": 1.0, "duration": 86400.0}


def tradeoff(ax: Any, made: Tradeoff, kind: str | None = None) -> Any:
    """Add what the best plans collect, with a band up to the bounds; a line for each other limit.

    Where nothing is proven the band reaches up to all prizes.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    made : Tradeoff
    kind : {"delta-v", "duration"}, optional
        What goes along the axis; the first that is varied by default.

    Returns
    -------
    matplotlib.axes.Axes
    """
    kind = kind or made.axes[0].kind
    rows = made.along(kind)
    other = "duration" if kind == "delta-v" else "delta-v"
    units = {"delta-v": "m/s", "duration": "days"}
    most = math.fsum(target.prize for target in made.instance.targets)
    for at, (value, row) in enumerate(rows.items()):
        there = [point for point in row if math.isfinite(point.prize)]
        x = [
            (point.delta_v_m_s if kind == "delta-v" else point.duration_s) / SCALES[kind]
            for point in there
        ]
        prize = [point.prize for point in there]
        bound = [point.upper_bound if math.isfinite(point.upper_bound) else most for point in there]
        colour = CHASERS[at % len(CHASERS)]
        said = f"{value / SCALES[other]:g} {units[other]}" if len(rows) > 1 else "best plan"
        ax.plot(x, prize, color=colour, marker="o", markersize=4, label=said)
        ax.fill_between(x, prize, bound, color=colour, alpha=0.18, linewidth=0)
    label(ax, TITLES[kind], "prize")
    return ax
