"""Practice of label searches: code that short runs of column generation may not reach."""

from __future__ import annotations

import numpy as np

from adr_opt.mission.evidence import Cut
from adr_opt.mission.problem import Problem

from ..walks.walks import WalkBound
from .label_search import LabelSearch

SLOT_M_S = 20.0
MOST_LABELS = 10_000


def practise(problem: Problem) -> None:
    """Search walks of a chaser that pay for a subset-row cut, or for none, and list plans.

    Problems without a timetable, or with functions of time, have no such walks.
    """
    mission = problem.missions[0]
    if not mission.has_timetable or mission.has_functions:
        return
    first = problem.instance.first_target
    rows = tuple(range(first, first + 3))
    for cuts in ([], [Cut(rows, frozenset(rows), 0.5)]):
        search = LabelSearch(WalkBound(mission, SLOT_M_S))
        search.cut(cuts)
        search.use(np.zeros(len(mission.names)))
        search.search(search.total, MOST_LABELS, lambda: False)
        search.plans(2)
