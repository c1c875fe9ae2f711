"""Beams that finish in time: a narrow beam predicts how wide the others may be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from adr_opt.common.clock import now_s
from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission

from ..walks.latest_times import Latest
from .beams import BeamSettings, beam_search

PILOT_WIDTH = 100
"""Width of the search that predicts the time of a wide one."""

ASKING_WIDTHS = (10, 30)
"""Widths of searches before a wide one if rows are computed on demand and searches expensive."""

PUNCTUAL = 0.9
"""Share of the remaining time that a search may be expected to take."""


def pilots(mission: Mission) -> tuple[int, ...]:
    """Widths of the searches before wide ones, which predict their time."""
    return (*(ASKING_WIDTHS if mission.timetable.is_on_demand else ()), PILOT_WIDTH)


def first_width(mission: Mission, usual: int) -> int:
    """Usual width of a search, or the narrowest if rows are computed on demand."""
    return pilots(mission)[0] if mission.timetable.is_on_demand else usual


class Beams:
    """Searches of one mission that finish in time; widths are limited by the pace so far.

    Parameters
    ----------
    mission : Mission
    stop : Stop
    """

    def __init__(self, mission: Mission, stop: Stop) -> None:
        self._mission = mission
        self._least = pilots(mission)[0]
        self._stop = stop
        self._pace_s = 0.0  # per state of width
        self.states = 0

    def needed_s(self, width: int) -> float:
        """Expected time of a search, from the last one of any width; 0 before [s]."""
        return self._pace_s * width

    def search(
        self,
        settings: BeamSettings,
        *,
        guide: Latest | None = None,
        seed: int = 0,
        mission: Mission | None = None,
    ) -> npt.NDArray[np.int64]:
        """The best plan of one search; ``mission`` may be a variant with another choice.

        No moves where time was over before and rows are asked for, each of which takes its time.
        """
        affordable = PUNCTUAL * max(0.0, self._stop.remaining_s())
        if affordable == 0.0 and self._mission.timetable.is_on_demand:
            return np.empty(0, dtype=np.int64)
        if self.needed_s(settings.width) > affordable:
            settings = replace(settings, width=max(1, int(affordable / self._pace_s)))
        began = now_s()
        found, _, _, states = beam_search(
            mission or self._mission, settings, guide=guide, seed=seed, stop=self._stop
        )
        self.states += states
        if settings.width >= self._least:
            self._pace_s = (now_s() - began) / settings.width
        return found
