"""How large a timetable is going to be: what it takes is known before it is built."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..common.constants import DAY_S, MU_M3_S2
from ..common.memory import available_bytes
from ..kernels.tables import timetable as kernels
from ..plan.leg_kinds import leg_kinds
from ..problem.instance import Instance
from .connections import ConnectionFinder, are_listed

MEMORY_SHARE = 0.7
"""Part of the free memory that building a timetable may take; planners need some too."""

LARGE_BYTES = 2.0**28
"""Who builds connections that take more is told beforehand: some seconds' work."""

BYTES_PER_CONNECTION = 30
"""Memory that a connection takes that is kept."""

PAIRS_AT_ONCE = 32
"""Where connections do not fit, those of at least so many pairs are kept."""

SAMPLED_PAIRS = 8
"""Of so many pairs the connections are counted to estimate those of all."""

SAMPLED_STEPS, SAMPLED_EVENTS = 1000, 5000
"""A sample is no finer than so many steps of the grid and departure events in a mission."""

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


def estimate(instance: Instance) -> Size:
    """How large the timetable of an instance is going to be."""
    duration, bodies = instance.mission.duration_s, len(instance.names)
    if instance.given is not None:
        most, rows = instance.given.sizes(instance.names)
        return Size(bodies, most + 1, rows / max(1, bodies * (bodies - 1)))
    shortest = _shortest_spacing_s(instance)
    if not are_listed(instance):
        return Size(bodies, int(duration / shortest) + 2)
    settings = instance.transfer
    events = duration / max(shortest, settings.departure_spacing_s) + 2
    if settings.max_drift_s > 0.0:
        events += duration / settings.drift_step_s
    return Size(bodies, int(events), _listed(instance))


def _shortest_spacing_s(instance: Instance) -> float:
    """Half a revolution of the lowest body: there is no more than one departure event in it [s]."""
    lowest = min(orbit.semi_major_axis_m for orbit in instance.body_orbits)
    return math.pi * math.sqrt(lowest**3 / MU_M3_S2)


def _listed(instance: Instance) -> float:
    """Connections of a pair in the mean, by a sample of pairs.

    Where a single pair would take minutes, the sample has a coarser grid: there are as many short
    transfers as events, and as many long ones as pairs of times.
    """
    settings, bodies = instance.transfer, len(instance.names)
    duration = instance.mission.duration_s
    spacing = max(_shortest_spacing_s(instance), settings.departure_spacing_s)
    events = max(1.0, duration / SAMPLED_EVENTS / spacing)
    times = max(1.0, duration / SAMPLED_STEPS / settings.drift_step_s)
    if events > 1.0:
        settings = settings.replace(departure_spacing_s=events * spacing)
    coarser = settings.replace(drift_step_s=times * settings.drift_step_s)
    sample = ConnectionFinder(instance.replace(transfer=coarser))
    # Pairs all over the field, since how far planes are apart decides what is worth flying.
    rng = np.random.default_rng(0)
    listed = [0.0]
    gridded = [number for number, kind in enumerate(leg_kinds()) if kind.on_time_grid]
    for number in range(SAMPLED_PAIRS if bodies > 1 else 0):
        i, j = rng.choice(bodies, 2, replace=False)
        found = sample.find(i, j, sample.planning_resolution_m_s)
        long = np.isin(found.family, gridded).sum()
        short = found.departure.size - long
        listed[number:] = [events * short + times**2 * long]
    return float(np.mean(listed))


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
