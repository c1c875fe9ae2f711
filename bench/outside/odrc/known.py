"""Known results of `odrc`: the published plan, and the best one on a grid by all subsets."""

from __future__ import annotations

import math
from pathlib import Path

from ..tables import Row, table
from .ours import NAME, plan
from .published import PLAN, TOTAL_M_S
from .reading import FILE, read_debris, with_centroid
from .scoring import score
from .subsets import cheapest

STEPS, FINER, CHASERS = 365, 10, 3
"""Number of departures in the year, factor of the finer grid, and number of chasers."""

TIME_LIMIT_S = 60.0


def report(folder: Path, steps: int = STEPS, finer: int = FINER) -> str:
    """The tables, in Markdown."""
    bodies = with_centroid(read_debris(folder / FILE))
    published = score(bodies, PLAN)
    total, routes = cheapest(bodies, steps, CHASERS)
    checked = score(bodies, routes)
    rows, wrong = [], [*published.violations, *checked.violations]
    for grid in (steps, steps * finer):
        ours = plan(bodies, grid, CHASERS, TIME_LIMIT_S)
        scored = score(bodies, ours.routes)
        wrong += scored.violations
        rows.append(
            Row(
                f"{NAME}, {grid} departures", TOTAL_M_S, published.total_m_s, scored.total_m_s,
                math.nan if ours.least_m_s is None else ours.least_m_s, ours.time_s,
            )
        )  # fmt: skip
    lines = [
        f"{len(bodies) - 1} debris, at most {CHASERS} chasers. The best plan with departures at "
        f"{steps} equal parts of the year, by all subsets: {total:.1f} m/s, "
        f"{checked.total_m_s:.1f} by the scorer, {len(routes)} chasers.",
        "",
        table(rows, "m/s", ".1f"),
    ]
    return "\n".join([*lines, *wrong])
