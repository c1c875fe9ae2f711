"""A pool of fields with their timetables, for many episodes at once."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...common.memory import available_bytes
from ...kernels.episodes.choices import NEAREST
from ...kernels.episodes.episodes import (
    LATEST,
    OPENS,
    PRIZE,
    SERVICE,
    Episodes,
    StackedFields,
    begin,
)
from ...kernels.orbits.ephemeris import ORBIT_COLUMNS
from ...kernels.rules.resources import CountLimits
from ...kernels.tables import stacked_timetables
from ...kernels.tables import timetable as timetable_kernels
from ...legs.nearest_pairs import PERIODS
from ...mission.mission import Mission
from ...problem.instance import Instance
from ...problem.rules import PLAYED, Follower
from ...problem.support import follows_all, refuse
from ...run.method_call import able
from .near_orbits import NearOrbits


class FieldPool:
    """Stacked fields in arrays that kernels take.

    Parameters
    ----------
    slots : int
        Number of fields.
    bodies : int
        Maximum number of bodies, the station included.
    events : int
        Maximum number of departure events of one body.
    more : int
        Maximum number of windows beside one of each body.
    regular : bool
        Whether the events of all fields are regular, as they are in two-body motion.

    Attributes
    ----------
    arrays : StackedFields
        Written by :meth:`install` alone.
    instances : list of Instance or None
        What stands in each slot.

    Raises
    ------
    InputError
        They would take more memory than is free.
    """

    def __init__(
        self, slots: int, bodies: int, events: int, more: int = 0, *, regular: bool = True
    ) -> None:
        needed = stacked_timetables.size_of_slots(slots, bodies, events, regular=regular)
        free = available_bytes()
        if needed > free:
            raise InputError(
                f"episodes need the connections of all pairs: those of {bodies} bodies with "
                f"{events} departures each take {needed / 2**30:.1f} GiB of "
                f"memory, and {free / 2**30:.1f} GiB are free; use another method or fewer targets"
            )
        tables = stacked_timetables.allocate_slots(slots, bodies, events, regular=regular)
        self.arrays = StackedFields(
            counts=np.zeros((slots, 1 + len(CountLimits._fields)), dtype=np.int32),
            orbits=np.zeros((slots, bodies, len(ORBIT_COLUMNS))),
            limits=np.zeros((slots, 4, bodies + more)),
            places=np.full((slots, bodies + 1), bodies),
            is_station=np.arange(bodies) < 1,
            tables=tables,
            near=np.full((slots, 1 if regular else PERIODS, bodies, NEAREST), -1, dtype=np.int16),
            period=np.ones(slots),
        )
        self.instances: list[Instance | None] = [None] * slots

    @classmethod
    def of(cls, mission: Mission) -> FieldPool:
        """A pool with one slot that holds one mission."""
        pool = cls.for_one(mission, len(mission.names))
        pool.install(0, mission)
        return pool

    @classmethod
    def for_one(cls, mission: Mission, bodies: int) -> FieldPool:
        """An empty pool with one slot for a mission, and capacity for a number of bodies."""
        timetable, more = mission.timetable, more_windows(mission)
        regular = not timetable.connecting.is_listed
        return cls(1, bodies, timetable.most_events, more, regular=regular)

    def fits(self, mission: Mission) -> bool:
        """Whether a mission fits a slot, with events spaced as in the others."""
        tables = self.arrays.tables
        return (
            len(mission.names) <= self.arrays.is_station.size
            and more_windows(mission) <= self.arrays.limits.shape[2] - self.arrays.is_station.size
            and mission.timetable.most_events <= timetable_kernels.most_events(tables)
            and mission.connecting.is_listed != timetable_kernels.is_regular(tables)
        )

    def install(self, slot: int, mission: Mission) -> None:
        """Put a mission into a slot, which no running episode may be using.

        Raises
        ------
        InputError
            Not a mission that can be played, see :func:`check_playable`.
        """
        check_playable(mission)
        arrays = self.arrays
        table = mission.timetable.table
        bodies = len(mission.names)
        orbits = mission.transfer_inputs[1]
        arrays.counts[slot] = bodies, *mission.limits
        arrays.orbits[slot, :bodies] = orbits
        limits = arrays.limits[slot]
        limits[SERVICE, :bodies] = mission.rules.service
        windows, most, more = mission.rules.windows, arrays.is_station.size, more_windows(mission)
        arrays.places[slot] = most + more
        arrays.places[slot, : bodies + 1] = most - bodies + windows.first
        for row, times in ((OPENS, windows.opens), (LATEST, windows.latest)):
            limits[row, :bodies], limits[row, most : most + more] = np.split(times, [bodies])
        limits[PRIZE] = 0.0
        limits[PRIZE, :bodies] = in_mean_prizes(mission)
        stacked_timetables.put(arrays.tables, slot, table)
        around = NearOrbits(mission.instance, arrays.near.shape[1])
        arrays.period[slot] = around.period_s
        arrays.near[slot] = -1
        for period, near in enumerate(arrays.near[slot]):
            found = around.at((period + 0.5) * around.period_s).neighbours_of(np.arange(bodies))
            near[:bodies, : found.shape[1]] = found
        self.instances[slot] = mission.instance


def more_windows(mission: Mission) -> int:
    """Number of windows of a mission beside one of each body."""
    return mission.rules.windows.opens.size - len(mission.names)


FOLLOWS = Follower("the environment with its policies", PLAYED)


def check_playable(mission: Mission) -> None:
    """Refuse a mission that episodes cannot play; the sentence names methods that plan it.

    Raises
    ------
    InputError
    """
    if not follows_all(mission.instance, FOLLOWS.follows):
        refuse(mission.instance, FOLLOWS, able=able(mission.instance))


def playing_time_s(instance: Instance) -> float:
    """Longest duration of an episode: until the mission or the chaser's availability ends [s]."""
    end = instance.chaser.available_s[1]
    duration_s = instance.mission.duration_s
    return duration_s if end is None else min(duration_s, end)


def in_mean_prizes(mission: Mission) -> npt.NDArray[np.float64]:
    """Prize of every body in mean prizes of targets with a prize, shape (bodies,)."""
    prize = mission.rules.prize
    worth = prize[prize > 0.0]
    if not worth.size:
        return np.zeros(prize.size)
    # Equal prizes are 1 exactly, which a mean of theirs need not give.
    mean = worth[0] if worth.min() == worth.max() else worth.mean()
    scaled: npt.NDArray[np.float64] = prize / mean
    return scaled


def new_episodes(count: int, bodies: int) -> Episodes:
    """Storage for the states of ``count`` episodes; :func:`start` begins them."""
    return Episodes(
        slot=np.zeros(count, dtype=np.int32),
        budget=np.zeros(count),
        duration=np.zeros(count),
        body=np.zeros(count, dtype=np.int32),
        since=np.zeros(count, dtype=np.int32),
        time=np.zeros(count),
        left=np.zeros(count),
        visited=np.zeros((count, bodies), dtype=np.bool_),
        serviced=np.zeros(count, dtype=np.int32),
        refuelled=np.zeros(count, dtype=np.int32),
        delta_v=np.zeros(count),
        collected=np.zeros(count),
    )


def start(
    pool: FieldPool,
    episodes: Episodes,
    index: int,
    slot: int,
    delta_v_m_s: float,
    duration_s: float,
) -> None:
    """Begin an episode on a slot of the pool."""
    episodes.slot[index] = slot
    episodes.budget[index] = delta_v_m_s
    episodes.duration[index] = duration_s
    begin(pool.arrays, episodes, index)
