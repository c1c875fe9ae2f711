"""What is known of the 24 instances: CPLEX's optima, and those of the small ones by all subsets."""

from __future__ import annotations

import math
from pathlib import Path

from ..tables import Row, table
from .reading import Places, instance_files, read_optima, read_places, travel_of
from .scoring import score
from .subsets import MOST_PLACES, optimum


def report(folder: Path) -> str:
    """The tables, in Markdown: static first, then time-dependent."""
    published = read_optima(folder / "optima.csv")
    lines = []
    for varying in (False, True):
        rows = []
        for path in instance_files(folder):
            places = read_places(path)
            known = published.get(places.name)
            figure = math.nan if varying or known is None else known.score
            star = "" if varying or known is None or known.is_proven else f" ({known.status})"
            rows.append(Row(places.name + star, figure, *_by_subsets(path, places, varying)))
        lines += [
            f"{'Time-dependent' if varying else 'Static'} travel times; re-scored are tours of the "
            "optimum by all subsets, which are no plans of ours:",
            "",
            table(rows, "score", "g"),
            "",
        ]
    return "\n".join(lines)


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
