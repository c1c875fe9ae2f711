"""Missions of a campaign at better times, each between its neighbours."""

from __future__ import annotations

from collections.abc import Sequence

from ..reading import FloatArray
from .campaign import Removals
from .phases import Latitude
from .retiming import retimed
from .scoring import APART_D, FIRST_D, LAST_D


def better_times(
    missions: Sequence[Removals],
    rows: FloatArray,
    step_d: float,
    rounds: int = 2,
    latitudes: Sequence[Latitude] | None = None,
) -> tuple[Removals, ...]:
    """Missions at better times, each in turn between its neighbours.

    Parameters
    ----------
    missions : sequence of Removals
        In order of time; there must be a way through each on the grid.
    rows : (debris, columns) float64
    step_d : float
        Of the grid, which begins anew for each mission [d].
    rounds : int
    latitudes : sequence of Latitude, optional
        See :func:`.retiming.retimed`.
    """
    found = list(missions)
    for _ in range(rounds):
        for place, mission in enumerate(found):
            begin = found[place - 1].end_d + APART_D if place > 0 else FIRST_D
            last = place + 1 == len(found)
            end = LAST_D if last else found[place + 1].begin_d - APART_D
            # Missions far apart need not be looked for everywhere.
            begin, end = max(begin, mission.begin_d - 40.0), min(end, mission.end_d + 40.0)
            if len(mission.stops) > 1:
                found[place] = retimed(mission, rows, step_d, begin, end, latitudes)
    return tuple(found)
