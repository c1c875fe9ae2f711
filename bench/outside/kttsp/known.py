"""What is known of the small instance, and what we make of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..tables import Row, table
from .ours import plan
from .proof import bound
from .reading import FILE, Problem, Tour, read_problem, read_tour
from .scoring import Score, score

BEST_KNOWN = Path(__file__).parent / "best-known.json"
"""A tour of ours, as it is submitted."""

PROVING_S = 3600.0
"""How long rounds of a proof begin."""

PUBLISHED_D = 111.96
"""Of the best solution file that is public; the first of the contest is said to have 100.397."""


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
    path.write_text(json.dumps(content) + "\n", encoding="utf-8")


def best_known(problem: Problem) -> Tour | None:
    """Our best tour of the instance, if it is that one."""
    if not BEST_KNOWN.is_file():
        return None
    tour = read_tour(BEST_KNOWN, problem.targets)
    return None if score(problem, tour).violations else tour


def _made(
    problem: Problem, time_limit_s: float, cells: Path | None, write: Path | None
) -> tuple[list[str], Row]:
    """Plan from nothing and prove; what there is to say, and the row of the table."""
    made = plan(problem)
    judged = score(problem, made.tour)
    if judged.violations:
        raise RuntimeError(f"{problem.name}: {judged.violations[0]}")
    if write is not None:
        write_tour(write, problem, made.tour)
    proven = bound(problem, judged.duration_d, time_limit_s=time_limit_s, path=cells)
    lines = [
        *_said("ours, from nothing", judged),
        f"Planned in {made.time_s:.0f} s ({made.processor_s:.0f} s of processors). No tour is "
        f"shorter than {proven.duration_d:.4f} d: {proven.rounds} rounds in {proven.time_s:.0f} s "
        f"({proven.processor_s:.0f} s of processors).",
        "",
    ]
    taken = made.time_s + proven.time_s
    return lines, Row(problem.name, ours=judged.duration_d, bound=proven.duration_d, taken_s=taken)


def report(
    folder: Path,
    solution: Path | None = None,
    time_limit_s: float | None = None,
    cells: Path | None = None,
    write: Path | None = None,
) -> str:
    """The tables, in Markdown.

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
    """
    problem = read_problem(folder / FILE)
    axes = problem.elements[:, 0]
    lines = [
        f"{problem.targets} targets about the Moon, semi-major axes from {axes.min() / 1e3:.0f} to "
        f"{axes.max() / 1e3:.0f} km; legs up to {problem.most_m_s:g} m/s, {problem.exceptions} "
        f"of them up to {problem.most_exception_m_s:g} m/s, within {problem.longest_d:g} d.",
        "",
    ]
    row = Row(problem.name)
    if solution is not None:
        found = score(problem, read_tour(solution, problem.targets))
        row = replace(row, rescored=found.duration_d)
        lines += _said(solution.name, found)
    kept = best_known(problem)
    if kept is not None:
        found = score(problem, kept)
        row = replace(row, ours=found.duration_d)
        lines += _said(BEST_KNOWN.name, found)
    limit = PROVING_S if time_limit_s is None else time_limit_s
    if limit:
        said, made = _made(problem, limit, cells, write)
        lines += said
        row = replace(made, rescored=row.rescored)
    return "\n".join([*lines, table([replace(row, published=PUBLISHED_D)], "d", ".4f")])
