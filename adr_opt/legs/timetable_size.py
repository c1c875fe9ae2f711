"""How large a timetable is going to be: what it takes is known before it is built."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..common.constants import DAY_S
from ..common.memory import available_bytes
from ..kernels.tables import timetable as kernels
from ..problem.instance import Instance

MEMORY_SHARE = 0.7
"""Part of the free memory that building a timetable may take; planners need some too."""

LARGE_BYTES = 2.0**28
"""Who builds connections that take more is told beforehand: some seconds' work."""

BYTES_PER_CONNECTION = 30
"""Memory that a connection takes that is kept."""

PAIRS_AT_ONCE = 32
"""Where connections do not fit, those of at least so many pairs are kept."""

TABLE_BYTES = 2**31
"""Who can plan on the nearest pairs takes no more for a table."""

TEMPORARY_BYTES = 8
"""Memory that working out the costs of eccentricity takes for each pair of bodies."""


@dataclass(frozen=True)
class Size:
    """How large a timetable is going to be: nothing of it is built.

    Attributes
    ----------
    bodies : int
    events : int
        Most departure events of a pair.
    listed : float
        Connections of a pair that are kept, in the mean: where nodes drift by a sample.
    """

    bodies: int
    events: int
    listed: float = 0.0

    @property
    def connections(self) -> int:
        """Number of connections that are kept, about."""
        return int(self.bodies * (self.bodies - 1) * self.listed)

    @property
    def entries(self) -> int:
        """Number of (pair, departure event) entries, at most."""
        return self.bodies * (self.bodies - 1) * self.events

    @property
    def bytes(self) -> int:
        """Memory that building it takes, with all connections kept."""
        return self._table_bytes + BYTES_PER_CONNECTION * self.connections

    @property
    def _table_bytes(self) -> int:
        return self._with(self.bodies)

    def _with(self, slots: int) -> int:
        """Memory that the table takes with room for so many destinations of each body."""
        return kernels.size_of(self.bodies, self.events, slots) + TEMPORARY_BYTES * self.bodies**2

    def slots(self, table_bytes: float = TABLE_BYTES) -> int:
        """For how many destinations of each body there is room in so much memory."""
        free = min(table_bytes, MEMORY_SHARE * available_bytes())
        if self._table_bytes <= free:
            return self.bodies
        each = self._with(1) - self._with(0)
        return max(1, min(self.bodies, int((free - self._with(0)) / each)))

    @property
    def room_bytes(self) -> float:
        """Memory that is left for connections where not all of them fit; else +inf."""
        free = MEMORY_SHARE * available_bytes()
        return math.inf if self.bytes <= free else free - self._table_bytes

    @property
    def is_large(self) -> bool:
        """Whether its connections are so many that one wants to know beforehand."""
        return self.connections > 0 and self.bytes > LARGE_BYTES

    def __str__(self) -> str:
        connections = f"{self.connections:.2g}".replace("e+0", "e").replace("e+", "e")
        kept = "" if math.isinf(self.room_bytes) else "; what does not fit is worked out when asked"
        return (
            f"about {connections} connections of {self.bodies} bodies, which take "
            f"{self.bytes / 2**30:.2g} GiB of memory{kept}"
        )

    @property
    def fits(self) -> bool:
        """Whether there is memory for it now, with connections of some pairs kept at a time."""
        pairs = min(PAIRS_AT_ONCE, self.bodies * (self.bodies - 1))
        return BYTES_PER_CONNECTION * pairs * self.listed <= self.room_bytes


def too_large(instance: Instance, size: Size) -> str:
    """Why there is no timetable."""
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
