"""The instances, all 130 or some that are drawn: known least ends, our tours and our bounds."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from adr_opt.common.files import write_text

from ..reading import read_object
from ..telling import Doing, silent
from .ours import Ours, plan
from .reading import BEST, instance_files, read_best, read_roads
from .scoring import score

TIME_LIMIT_S = 300.0
"""For each instance."""

PROVEN = 1e-6
"""Relative gap up to which an end counts as least."""

ROUNDED = 0.005 + 1e-9
"""Known ends are rounded to hundredths."""


def report(
    folder: Path,
    time_limit_s: float = TIME_LIMIT_S,
    kept: Path | None = None,
    doing: Doing = silent,
    count: int | None = None,
) -> Iterator[str]:
    """The table, in Markdown, row by row.

    Parameters
    ----------
    folder : Path
    time_limit_s : float
        For each instance.
    kept : Path, optional
        File of results, which are not worked out again; new ones are added. Those of a shorter time
        limit that were not proven are.
    doing : callable
        Hears of each instance before it is planned.
    count : int, optional
        Of the largest instances as many with a known end and as many without are drawn; all
        instances without.
    """
    files, best = instance_files(folder), read_best(folder / BEST)
    if count is not None:
        files = drawn(files, best, count)
    for path in files:  # what is broken is said before the first of them is planned
        read_roads(path)
    rows: dict[str, Any] = read_object(kept) if kept is not None and kept.exists() else {}
    yield (
        "| instance | known | ours | bound | gap | labels | processor time |\n"
        "|---|---|---|---|---|---|---|"
    )
    for number, path in enumerate(files):
        doing(path.stem, number, len(files))
        row = rows.get(path.stem)
        if row is None or not (_is_proven(row) or row["time_limit_s"] >= time_limit_s):
            row = rows[path.stem] = _row(path, time_limit_s)
            if kept is not None:
                write_text(kept, json.dumps(rows, indent=0) + "\n")
        yield _line(path.stem, best.get(path.stem, math.nan), row)
    names = {path.stem for path in files}
    rows = {name: row for name, row in rows.items() if name in names}
    yield f"\n{_sums(rows, {name: best.get(name, math.nan) for name in names})}\n"


def drawn(files: list[Path], best: dict[str, float], count: int) -> list[Path]:
    """Some of the largest instances, always the same: half of them with a known end."""
    most = max(int(path.stem.split("_")[0]) for path in files)
    largest = [path for path in files if int(path.stem.split("_")[0]) == most]
    is_open = [math.isnan(best.get(path.stem, math.nan)) for path in largest]
    found = []
    for wanted in (False, True):
        those = [path for path, one in zip(largest, is_open, strict=True) if one == wanted]
        found += random.Random(0).sample(those, min(count, len(those)))
    return sorted(found)


def _row(path: Path, time_limit_s: float) -> dict[str, Any]:
    """Our result for an instance; the end is that of the scorer."""
    roads = read_roads(path)
    ours: Ours = plan(roads, time_limit_s)
    end = None
    if ours.tour:
        judged = score(roads, ours.tour)
        if judged.violations or abs(judged.end - ours.end) > 1e-5:
            raise RuntimeError(f"{roads.name}: {judged} is not the {ours.end:g} of our plan")
        end = judged.end
    return {
        "tour": list(ours.tour),
        "end": end,
        "bound": ours.bound,
        "labels": ours.labels,
        "processor_s": ours.processor_s,
        "time_limit_s": time_limit_s,
    }


def _is_proven(row: dict[str, Any]) -> bool:
    return row["end"] is not None and row["end"] <= row["bound"] * (1.0 + PROVEN)


def _line(name: str, best: float, row: dict[str, Any]) -> str:
    known = "–" if math.isnan(best) else f"{best:.2f}"
    end, bound = row["end"], row["bound"]
    ours, gap = ("–", "–") if end is None else (f"{end:.2f}", f"{100 * (1 - bound / end):.2f} %")
    if _is_proven(row):
        gap = "proven"
    return (
        f"| {name} | {known} | {ours} | {bound:.2f} | {gap} | {row['labels']:,} | "
        f"{row['processor_s']:.1f} s |"
    )


def _sums(rows: dict[str, Any], best: dict[str, float]) -> str:
    """Number of proven instances, and comparison with known ends."""
    proven = {name for name, row in rows.items() if _is_proven(row)}
    closed = {name for name, end in best.items() if not math.isnan(end)}
    same = {name for name in proven & closed if abs(rows[name]["end"] - best[name]) <= ROUNDED}
    others = sorted(proven & closed - same)
    said = (
        f"{len(proven)} of {len(rows)} proven: {len(same)} of the {len(closed)} that were known, "
        f"with the same end, and {len(proven - closed)} of the {len(best) - len(closed)} that were "
        "not."
    )
    return said if not others else f"{said} Other ends than known: {', '.join(others)}."
