"""Campaigns of GTOC9 planned from nothing: a tour on a grid of times, then better times."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from adr_opt.common.files import write_text
from solvers.tours.costs import TimeGrid, TourExpense
from solvers.tours.planner import Annealing, Tour, plan

from ..reading import FloatArray
from .campaign import Removals
from .campaigns import better_times, missions_of
from .estimate import legs_m_s
from .expense import DRY_KG, EXHAUST_M_S, KIT_KG, LAUNCH_MEUR, MOST_PROPELLANT_KG, PER_KG2_MEUR
from .scoring import APART_D, STAY_D, Score, score
from .tables import UNIT_M_S, table

STEP_D = 2.5
"""Step of the grid on which tours are planned; stay and longest leg are multiples of it."""

SLACK_D = 0.6
"""Extra time allowed for transfers in planning: on a fine grid less time is lost."""

FINE = 4
"""Lengths of transfers that are tried within a step."""

EXPENSE = TourExpense(
    LAUNCH_MEUR, 0.0, PER_KG2_MEUR, DRY_KG, KIT_KG, EXHAUST_M_S, MOST_PROPELLANT_KG
)

REFINED = 2
"""Number of tours that are re-timed; the best of them counts."""


@dataclass(frozen=True)
class Planned:
    """A campaign from nothing.

    Attributes
    ----------
    missions : tuple of Removals
        At times of the fine grid.
    judged : Score
        By the estimate.
    coarse_meur : float
        What the search took it for.
    processor_s : float
        Processor time of everything [s].
    """

    missions: tuple[Removals, ...]
    judged: Score
    coarse_meur: float
    processor_s: float


def planned(
    rows: FloatArray,
    seed: int,
    chains: int,
    step_d: float,
    time_limit_s: float = float("inf"),
    iterations: int | None = None,
    settings: Annealing | None = None,
    tell: Callable[[float, Tour], None] | None = None,
) -> Planned:
    """Plan a campaign.

    Parameters
    ----------
    rows : (debris, columns) float64
    seed, chains : int
        Chains run side by side, each in a thread.
    step_d : float
        Of the fine grid [d].
    time_limit_s : float
        Processor time of each chain [s].
    iterations : int, optional
        Of each chain: the same number gives the same campaign.
    """
    since = time.process_time()
    grid = TimeGrid(round(STAY_D / STEP_D), round((STAY_D + APART_D) / STEP_D), UNIT_M_S)
    cost = table(rows, STEP_D, SLACK_D, FINE)
    cooling = replace(settings or Annealing(), iterations=iterations, time_limit_s=time_limit_s)
    tours = plan(cost, grid, EXPENSE, cooling, seed, chains, tell)
    best: Planned | None = None
    for tour in tours[:REFINED]:
        missions = better_times(missions_of(tour.order, tour.begins, tour.at, STEP_D), rows, step_d)
        found = score(missions, [legs_m_s(mission, rows) for mission in missions], len(rows))
        spent = time.process_time() - since
        if best is None or found.total_meur < best.judged.total_meur:
            best = Planned(missions, found, tour.expense, spent)
    assert best is not None
    return best


def write_campaign(path: Path, missions: tuple[Removals, ...], rows: FloatArray) -> None:
    """Write missions as :func:`~.campaign.read_campaign` reads them."""
    content = {
        "start_mjd2000": [mission.begin_d for mission in missions],
        "missions": [
            {
                "debris": [stop.debris for stop in mission.stops],
                "stay_d": [stop.departure_d - stop.arrival_d for stop in mission.stops],
                "transfer_d": [
                    other.arrival_d - one.departure_d
                    for one, other in zip(mission.stops[:-1], mission.stops[1:], strict=True)
                ],
                "dv_m_s": list(legs_m_s(mission, rows)),
            }
            for mission in missions
        ],
    }
    write_text(path, json.dumps(content, indent=1) + "\n")
