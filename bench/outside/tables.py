"""The table that every benchmark of the outside world ends in."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """Known results of one instance.

    Attributes
    ----------
    instance : str
    published : float
        The best figure that others published; NaN where there is none.
    rescored : float
        What our scorer makes of the published solution; NaN where there is no solution.
    ours, bound : float
        NaN where nothing was planned or proven.
    taken_s : float
        How long planning and proving took [s]; NaN where neither was done.
    published_s : float
        How long others took; NaN where they do not tell.
    """

    instance: str
    published: float = math.nan
    rescored: float = math.nan
    ours: float = math.nan
    bound: float = math.nan
    taken_s: float = math.nan
    published_s: float = math.nan


def _cell(value: float, form: str) -> str:
    return "–" if math.isnan(value) else format(value, form)


def head(unit: str, *, theirs: bool = False) -> str:
    """The head of the table in Markdown; figures in a unit.

    Parameters
    ----------
    unit : str
    theirs : bool
        Whether there is a column for how long others took.
    """
    return (
        f"| instance | published [{unit}] | re-scored | ours | bound | time |"
        + " time of others |" * theirs
        + "\n|---|---|---|---|---|---|"
        + "---|" * theirs
    )


def line(row: Row, form: str, *, theirs: bool = False) -> str:
    """A row of it, figures as a format specification says."""
    figures = row.published, row.rescored, row.ours, row.bound
    cells = [_cell(value, form) for value in figures]
    times = (row.taken_s, row.published_s) if theirs else (row.taken_s,)
    cells += ["–" if math.isnan(time) else f"{time:,.1f} s" for time in times]
    return f"| {row.instance} | {' | '.join(cells)} |"
