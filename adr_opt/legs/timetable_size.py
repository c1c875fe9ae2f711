"""Size of a timetable, estimated before it is built."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..common.constants import DAY_S
from ..common.memory import available_bytes
from ..kernels.tables import timetable as kernels
from ..problem.instance import Instance

MEMORY_SHARE = 0.7
"""Share of free memory that building a timetable may use; planners need memory, too."""

LARGE_BYTES = 2.0**28
"""Builds expected to exceed this print a notice first (a few seconds of work)."""

BYTES_PER_CONNECTION = 30
"""Memory per cached connection [bytes]."""

PAIRS_AT_ONCE = 32
"""Minimum number of pairs whose connections are cached where not all fit."""

TABLE_BYTES = 2**31
"""Table size above which planners that can do so use only the nearest pairs [bytes]."""

TEMPORARY_BYTES = 8
"""Memory per pair of bodies while costs of eccentricity are computed [bytes]."""


REGULAR_S, GIVEN_S, LISTED_S, THRUST_S = 1e-6, 6e-7, 8e-6, 25e-6
"""Expected time of a departure event of a pair on one core, where events are regular, where
connections are given, where planes drift, and with low thrust or legs of a registered family [s].

By `bench/scale.py paces` 0.7, 0.5, 2 to 10 and 23 µs."""


@dataclass(frozen=True)
class Size:
    """Expected size of a timetable, without building it.

    Attributes
    ----------
    bodies : int
    events : int
        Most departure events of a pair.
    listed : float
        Connections of a pair that are kept, in the mean: where nodes drift by a sample.
    event_s : float
        Expected time to build a pair on one core, per event [s].
    most_near : int, optional
        Most destinations of a body that have connections, where these are given.
    """

    bodies: int
    events: int
    listed: float = 0.0
    event_s: float = REGULAR_S
    most_near: int | None = None

    @property
    def near(self) -> int:
        """Destinations of each body that a table of all its connections holds."""
        return self.bodies - 1 if self.most_near is None else self.most_near

    @property
    def pairs(self) -> int:
        """Number of pairs of bodies that a table of all connections holds."""
        return self.bodies * self.near

    @property
    def pair_s(self) -> float:
        """Expected time to build a pair on one core [s]."""
        return self.events * self.event_s

    @property
    def build_s(self) -> float:
        """Expected time to build all pairs on one core [s]."""
        return self.pairs * self.pair_s

    @property
    def connections(self) -> int:
        """Approximate number of cached connections."""
        return int(self.pairs * self.listed)

    @property
    def entries(self) -> int:
        """Maximum number of (pair, departure event) entries."""
        return self.pairs * self.events

    @property
    def bytes(self) -> int:
        """Memory needed to build it with all connections cached [bytes]."""
        return self._table_bytes + BYTES_PER_CONNECTION * self.connections

    @property
    def _table_bytes(self) -> int:
        return self._with(min(self.near + 1, self.bodies))

    def _with(self, slots: int) -> int:
        """Memory of the table with a number of destinations per body [bytes]."""
        return kernels.size_of(self.bodies, self.events, slots) + TEMPORARY_BYTES * self.bodies**2

    def slots(self, table_bytes: float = TABLE_BYTES) -> int:
        """Number of destinations per body that fit in an amount of memory."""
        free = min(table_bytes, MEMORY_SHARE * available_bytes())
        if self._table_bytes <= free:
            return self.bodies
        each = self._with(1) - self._with(0)
        return max(1, min(self.bodies, int((free - self._with(0)) / each)))

    @property
    def room_bytes(self) -> float:
        """Memory left for connections if not all fit; else +inf [bytes]."""
        free = MEMORY_SHARE * available_bytes()
        return math.inf if self.bytes <= free else free - self._table_bytes

    @property
    def is_large(self) -> bool:
        """Whether building it takes long enough for a notice."""
        return self.connections > 0 and self.bytes > LARGE_BYTES

    def __str__(self) -> str:
        connections = f"{self.connections:.2g}".replace("e+0", "e").replace("e+", "e")
        kept = "" if math.isinf(self.room_bytes) else "; the rest is computed when needed"
        return (
            f"about {connections} connections of {self.bodies} bodies, which take "
            f"{self.bytes / 2**30:.2g} GiB of memory{kept}"
        )

    @property
    def fits(self) -> bool:
        """Whether it fits in memory now, with the connections of some pairs cached at a time."""
        pairs = min(PAIRS_AT_ONCE, self.pairs)
        return BYTES_PER_CONNECTION * pairs * self.listed <= self.room_bytes


def too_large(instance: Instance, size: Size) -> str:
    """The message for a timetable that does not fit in memory."""
    if instance.transfer.given is not None:
        return (
            f"there are {size}, and {available_bytes() / 2**30:.3g} GiB are free; give fewer, or "
            "take fewer targets"
        )
    if size.connections:
        finer = "departure_spacing_s or delta_v_resolution_m_s"
        if instance.transfer.max_drift_s > 0.0:
            finer = f"drift_step_s, {finer}, lower max_drift_s"
        return (
            f"the mission of {instance.mission.duration_s / DAY_S:.4g} days has {size}, and "
            f"{available_bytes() / 2**30:.3g} GiB are free; raise {finer}, or take fewer targets"
        )
    return (
        f"the timetable of {size.bodies} bodies over {instance.mission.duration_s / DAY_S:.4g} "
        f"days takes {size.bytes / 2**30:.3g} GiB, and {available_bytes() / 2**30:.3g} GiB of "
        "memory are free; take fewer targets or a shorter mission"
    )
