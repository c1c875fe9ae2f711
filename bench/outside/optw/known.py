"""The 24 instances: optima of CPLEX, those of the small ones by all subsets, and our plans."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from ..tables import Row, head, line
from ..telling import Doing, silent
from .ours import plan
from .reading import Optimum, Places, instance_files, read_optima, read_places, travel_of
from .scoring import score
from .subsets import MOST_PLACES, optimum

TIME_LIMIT_S = 120.0
"""For each instance; all are proven long before on the machine of the tables in the pages."""


def report(
    folder: Path, time_limit_s: float = TIME_LIMIT_S, doing: Doing = silent
) -> Iterator[str]:
    """The tables, in Markdown, row by row: static first, then time-dependent.

    Parameters
    ----------
    folder : Path
    time_limit_s : float
        For each instance.
    doing : callable
        Hears of each instance before it is planned.
    """
    files = instance_files(folder)
    published = read_optima(folder / "optima.csv")
    for path in files:  # what is missing or broken is said before the first of them is planned
        for varying in (False, True):
            travel_of(path, read_places(path), varying=varying)
    for varying in (False, True):
        yield (
            f"{'Time-dependent' if varying else 'Static'} travel times; re-scored are tours of the "
            "optimum by all subsets, which are no plans of ours, and others are CPLEX 12.6:\n"
        )
        yield head("score", theirs=not varying)
        rows = []
        for number, path in enumerate(files, len(files) * varying):
            doing(path.stem, number, 2 * len(files))
            known = None if varying else published.get(path.stem)
            rows.append(_row(path, known, varying, time_limit_s))
            yield line(rows[-1], "g", theirs=not varying)
        yield f"\n{_sums(rows)}\n"


def _row(path: Path, known: Optimum | None, varying: bool, time_limit_s: float) -> Row:
    """Results of others and ours on an instance; our score is that of the scorer."""
    places = read_places(path)
    travel = travel_of(path, places, varying=varying)
    ours = plan(places, travel, time_limit_s)
    judged = score(places, travel, ours.tour)
    if judged.violations or judged.score != ours.score:
        raise RuntimeError(f"{places.name}: {judged} is not the {ours.score:g} of our plan")
    star = "" if known is None or known.is_proven else f" ({known.status})"
    return Row(
        places.name + star,
        math.nan if known is None else known.score,
        *_by_subsets(path, places, varying),
        judged.score,
        ours.bound,
        ours.time_s,
        math.nan if known is None else known.taken_s,
    )


def _sums(rows: Sequence[Row]) -> str:
    """Number of proven instances, and their total time."""
    proven = sum(row.ours == row.bound for row in rows)
    ours = sum(row.taken_s for row in rows)
    said = f"{proven} of {len(rows)} proven, in {ours:.1f} s"
    closed = [row for row in rows if "(" not in row.instance and not math.isnan(row.published_s)]
    if not closed:
        return f"{said}."
    same = sum(row.published == row.ours == row.bound for row in closed)
    taken, theirs = sum(row.taken_s for row in closed), sum(row.published_s for row in closed)
    return (
        f"{said}. Of the {len(closed)} that CPLEX proved, {same} have the same score and are "
        f"proven, in {taken:.1f} s where CPLEX took {theirs:,.1f} s, {theirs / taken:,.0f} times "
        "as long."
    )


def _by_subsets(path: Path, places: Places, varying: bool) -> tuple[float]:
    """Score of the best tour of a small instance, by the scorer; NaN of a large one."""
    if places.count > MOST_PLACES:
        return (math.nan,)
    travel = travel_of(path, places, varying=varying)
    found, tour = optimum(places, travel)
    judged = score(places, travel, tour)
    if judged.violations or judged.score != found:
        raise RuntimeError(f"{places.name}: {judged} is not the {found:g} of all subsets")
    return (judged.score,)
