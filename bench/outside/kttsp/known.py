"""What is known of the small instance, and what we make of it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from adr_opt.common.files import check_writable, write_text

from ..tables import Row, head, line
from ..telling import Doing, silent
from .ours import plan
from .proof import bound
from .reading import FILE, Problem, Tour, read_problem, read_tour
from .scoring import Score, score

BEST_KNOWN = Path(__file__).parent / "best-known.json"
"""A tour of ours, as it is submitted."""

PROVING_S = 3600.0
"""How long rounds of a proof begin."""

PUBLISHED_D = 111.96
"""Of the best solution file that is public."""


def _said(name: str, found: Score) -> list[str]:
    """A solution in a line, and the rules that it breaks."""
    return [
        f"{name}: {found.duration_d:.4f} d, {found.exceptions} exceptions, "
        f"{np.sum(found.delta_v_m_s):.1f} m/s in all, {len(found.violations)} rules broken",
        *found.violations,
        "",
    ]


def write_tour(path: Path, problem: Problem, tour: Tour) -> None:
    """Write a tour as it is submitted."""
    figures = [*tour.departures_d.tolist(), *tour.flights_d.tolist(), *tour.order.tolist()]
    content = [{"challenge": "spoc-4-tomato", "problem": problem.name, "decisionVector": figures}]
    write_text(path, json.dumps(content) + "\n")


def best_known(problem: Problem) -> Tour | None:
    """Our best tour of the instance, if it is that one."""
    if not BEST_KNOWN.is_file():
        return None
    tour = read_tour(BEST_KNOWN, problem.targets)
    return None if score(problem, tour).violations else tour


def report(
    folder: Path,
    solution: Path | None = None,
    time_limit_s: float | None = None,
    cells: Path | None = None,
    write: Path | None = None,
    doing: Doing = silent,
) -> Iterator[str]:
    """The tables, in Markdown, each figure as soon as it is known.

    Parameters
    ----------
    folder : Path
    solution : Path, optional
        Is scored.
    time_limit_s : float, optional
        After which no round of the proof begins; with 0 nothing is planned or proven, and *ours* is
        the best tour that is kept. ``PROVING_S`` by default.
    cells : Path, optional
        Where the proof is kept, and gone on with.
    write : Path, optional
        Where the tour that is planned is written, as it is submitted.
    doing : callable
        Hears of planning and of proving.
    """
    problem = read_problem(folder / FILE)
    tour = None if solution is None else read_tour(solution, problem.targets)
    for path in (cells, write):
        if path is not None:
            check_writable(path)
    axes = problem.elements[:, 0]
    yield (
        f"{problem.targets} targets about the Moon, semi-major axes from {axes.min() / 1e3:.0f} to "
        f"{axes.max() / 1e3:.0f} km; legs up to {problem.most_m_s:g} m/s, {problem.exceptions} "
        f"of them up to {problem.most_exception_m_s:g} m/s, within {problem.longest_d:g} d.\n"
    )
    row = Row(problem.name, published=PUBLISHED_D)
    if solution is not None and tour is not None:
        found = score(problem, tour)
        row = replace(row, rescored=found.duration_d)
        yield from _said(solution.name, found)
    kept = best_known(problem)
    if kept is not None:
        found = score(problem, kept)
        row = replace(row, ours=found.duration_d)
        yield from _said(BEST_KNOWN.name, found)
    limit = PROVING_S if time_limit_s is None else time_limit_s
    if limit:
        doing("planning", 0, 2)
        made = plan(problem)
        judged = score(problem, made.tour)
        if judged.violations:
            raise RuntimeError(f"{problem.name}: {judged.violations[0]}")
        if write is not None:
            write_tour(write, problem, made.tour)
        yield from _said("ours, from nothing", judged)
        spent = f"{made.time_s:.0f} s ({made.processor_s:.0f} s of processors)"
        yield f"Planned in {spent}."
        doing("proving", 1, 2)
        proven = bound(problem, judged.duration_d, time_limit_s=limit, path=cells)
        yield (
            f"No tour is shorter than {proven.duration_d:.4f} d: {proven.rounds} rounds in "
            f"{proven.time_s:.0f} s ({proven.processor_s:.0f} s of processors).\n"
        )
        row = replace(
            row, ours=judged.duration_d, bound=proven.duration_d,
            taken_s=made.time_s + proven.time_s,
        )  # fmt: skip
    yield head("d")
    yield line(row, ".4f")
