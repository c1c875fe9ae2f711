"""What is known of `odrc`: the published plan, and the best one on a grid by all subsets."""

from __future__ import annotations

from pathlib import Path

from ..tables import Row, table
from .published import PLAN, TOTAL_M_S
from .reading import FILE, read_debris, with_centroid
from .scoring import score
from .subsets import cheapest

STEPS, CHASERS = 365, 3
"""Departures every day."""


def report(folder: Path, steps: int = STEPS) -> str:
    """The tables, in Markdown."""
    bodies = with_centroid(read_debris(folder / FILE))
    published = score(bodies, PLAN)
    total, routes = cheapest(bodies, steps, CHASERS)
    checked = score(bodies, routes)
    lines = [
        f"{len(bodies) - 1} debris, at most {CHASERS} chasers. The best plan with departures at "
        f"{steps} equal parts of the year, by all subsets: {total:.1f} m/s, "
        f"{checked.total_m_s:.1f} by the scorer, {len(routes)} chasers.",
        "",
        table([Row("odrc", TOTAL_M_S, published.total_m_s)], "m/s", ".1f"),
    ]
    return "\n".join([*lines, *published.violations, *checked.violations])
