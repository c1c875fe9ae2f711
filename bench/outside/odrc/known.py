"""Known results of `odrc`: the published plan, and the best one on a grid by all subsets."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from ..reading import FloatArray
from ..tables import Row, head, line
from ..telling import Doing, silent
from . import by_model
from .ours import NAME, plan
from .published import PLAN, TOTAL_M_S
from .reading import FILE, read_debris, with_centroid
from .scoring import score
from .subsets import cheapest

STEPS, FINER, CHASERS = 365, 10, 3
"""Number of departures in the year, factor of the finer grid, and number of chasers."""

TIME_LIMIT_S = 60.0


def report(
    folder: Path, steps: int = STEPS, finer: int = FINER, doing: Doing = silent
) -> Iterator[str]:
    """The tables, in Markdown, row by row.

    Parameters
    ----------
    folder : Path
    steps, finer : int
    doing : callable
        Hears of each grid before it is planned on.
    """
    bodies = with_centroid(read_debris(folder / FILE))
    published = score(bodies, PLAN)
    doing("all subsets", 0, 3)
    total, routes = cheapest(bodies, steps, CHASERS)
    checked = score(bodies, routes)
    wrong = [*published.violations, *checked.violations]
    yield (
        f"{len(bodies) - 1} debris, at most {CHASERS} chasers. The best plan with departures at "
        f"{steps} equal parts of the year, by all subsets: {total:.1f} m/s, "
        f"{checked.total_m_s:.1f} by the scorer, {len(routes)} chasers.\n"
    )
    yield head("m/s")
    for number, grid in enumerate((steps, steps * finer), 1):
        doing(f"{grid} departures", number, 3)
        ours = plan(bodies, grid, CHASERS, TIME_LIMIT_S)
        scored = score(bodies, ours.routes)
        wrong += scored.violations
        row = Row(
            f"{NAME}, {grid} departures",
            TOTAL_M_S,
            published.total_m_s,
            scored.total_m_s,
            math.nan if ours.least_m_s is None else ours.least_m_s,
            ours.time_s,
        )
        yield line(row, ".1f")
    yield from wrong
    yield from _by_model(bodies, doing)


def _by_model(bodies: FloatArray, doing: Doing) -> Iterator[str]:
    """The published plan's legs by the model, and a plan on legs of the model."""
    doing("legs of the model", 3, 3)
    legs = by_model.priced(bodies, PLAN)
    there = [(said, cost) for said, cost in legs if math.isfinite(cost)]
    ours = by_model.plan(bodies, CHASERS, TIME_LIMIT_S)
    said_m_s, cost_m_s = (sum(column) for column in zip(*there, strict=True))
    yield (
        f"\nOf the {len(legs)} legs of the published plan {len(there)} are legs of the model from "
        f"their departures to the next ones, for {cost_m_s:.1f} m/s where the estimate has "
        f"{said_m_s:.1f} m/s.\n"
    )
    yield "| leg | estimate [m/s] | model [m/s] |"
    yield "|---|---|---|"
    for number, (said, cost) in enumerate(legs, 1):
        shown = f"{cost:.1f}" if math.isfinite(cost) else "no leg"
        yield f"| {number} | {said:.1f} | {shown} |"
    yield (
        f"\nPlanned on legs of the model: {ours.total_m_s:.1f} m/s, {len(ours.legs)} legs, "
        f"{ours.violations} violations. Refined and flown:\n"
    )
    yield "| leg | estimate [m/s] | planned [m/s] | flown [m/s] | miss [m] |"
    yield "|---|---|---|---|---|"
    for leg in ours.legs:
        figures = leg.estimate_m_s, leg.planned_m_s, leg.flown_m_s
        shown = " | ".join(f"{figure:.1f}" for figure in figures)
        yield f"| {leg.origin} → {leg.destination} | {shown} | {leg.missed_m:.2g} |"
    totals = (math.fsum(column) for column in zip(*(leg[2:5] for leg in ours.legs), strict=True))
    yield f"| all | {' | '.join(f'{total:.1f}' for total in totals)} | |"
