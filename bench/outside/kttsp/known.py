"""What is known of the small instance: its size, best durations, and a solution if one is given."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ..tables import Row, table
from .reading import FILE, read_problem, read_tour
from .scoring import score

PUBLISHED_D = 111.96
"""Of the best solution file that is public; the first of the contest is said to have 100.397."""


def report(folder: Path, solution: Path | None = None) -> str:
    """The tables, in Markdown."""
    problem = read_problem(folder / FILE)
    axes = problem.elements[:, 0]
    lines = [
        f"{problem.targets} targets about the Moon, semi-major axes from {axes.min() / 1e3:.0f} to "
        f"{axes.max() / 1e3:.0f} km; legs up to {problem.most_m_s:g} m/s, {problem.exceptions} "
        f"of them up to {problem.most_exception_m_s:g} m/s, within {problem.longest_d:g} d.",
        "",
    ]
    rescored = math.nan
    if solution is not None:
        found = score(problem, read_tour(solution, problem.targets))
        rescored = found.duration_d
        lines += [
            f"{solution.name}: {found.duration_d:.4f} d, {found.exceptions} exceptions, "
            f"{np.sum(found.delta_v_m_s):.1f} m/s in all, {len(found.violations)} rules broken",
            *found.violations,
            "",
        ]
    return "\n".join([*lines, table([Row(problem.name, PUBLISHED_D, rescored)], "d", ".3f")])
