"""Missions of GTOC9 in time, and the file of the winning solution."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from adr_opt.common.constants import DAY_S
from adr_opt.common.files import read_text
from adr_opt.plan.plan import Plan

from ..reading import published

FILE = "jpl_solution.json"

FIRST_D, LAST_D = 23467.0, 26419.0
"""Range of the missions [d, MJD2000]."""

PREFIX = "debris-"
"""Names of targets begin so, and end with the number of a debris."""


class Stop(NamedTuple):
    """A debris of a mission: its number, arrival and departure [d, MJD2000].

    The departure from the last one is the end of the mission.
    """

    debris: int
    arrival_d: float
    departure_d: float


@dataclass(frozen=True)
class Removals:
    """One mission.

    Attributes
    ----------
    stops : tuple of Stop
        In order of time; the first arrival is the launch.
    flown_m_s : tuple of float
        ΔV of the legs between stops as somebody else has them; empty where nobody does.
    """

    stops: tuple[Stop, ...]
    flown_m_s: tuple[float, ...] = ()

    @property
    def begin_d(self) -> float:
        """Launch, which is the first arrival [d, MJD2000]."""
        return self.stops[0].arrival_d

    @property
    def end_d(self) -> float:
        """End of the last stay [d, MJD2000]."""
        return self.stops[-1].departure_d


def _missions_of(plan: Plan) -> tuple[Removals, ...]:
    """The missions of a plan, in order of time."""
    found = []
    for route in plan.routes:
        leaves = [leg.departure_s for leg in route.legs[1:]] + [
            leg.end_s for leg in route.legs[-1:]
        ]
        stops = tuple(
            Stop(
                int(leg.destination.removeprefix(PREFIX)),
                FIRST_D + leg.arrival_s / DAY_S,
                FIRST_D + then / DAY_S,
            )
            for leg, then in zip(route.legs, leaves, strict=True)
        )
        if stops:
            found.append(Removals(stops, tuple(leg.delta_v_m_s for leg in route.legs[1:])))
    return tuple(sorted(found, key=lambda mission: mission.begin_d))


@published
def read_campaign(path: Path) -> tuple[Removals, ...]:
    """The missions of a file.

    `start_mjd2000` holds the launches; each of `missions` its `debris` in order, `stay_d` and
    `transfer_d` [d], and `dv_m_s` of its legs. A plan of :func:`.instance.contest` is read as well.
    """
    content = json.loads(read_text(path))
    if "routes" in content:
        return _missions_of(Plan.load(path))
    found = []
    for now, mission in zip(content["start_mjd2000"], content["missions"], strict=True):
        stops, ways = [], (*mission["transfer_d"], 0.0)
        for one, stay, way in zip(mission["debris"], mission["stay_d"], ways, strict=True):
            stops.append(Stop(one, now, now + stay))
            now += stay + way
        legs = zip(stops[1:], mission["dv_m_s"], strict=True)
        found.append(Removals(tuple(stops), tuple(flown for _, flown in legs)))
    return tuple(found)
