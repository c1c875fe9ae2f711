"""Numbering of the bodies of an instance.

The stations come first, in order, then the orbits of their own where chasers start, then the
targets, in order.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from ..common.constants import EARTH_RADIUS_M
from .bodies import Station, Target
from .chasers import AtStation, Chaser, InOrbit
from .orbit import Orbit

LEO = Orbit(
    semi_major_axis_m=EARTH_RADIUS_M + 700e3,
    eccentricity=0.0,
    inclination_deg=98.0,
    raan_deg=0.0,
    argument_of_perigee_deg=0.0,
    true_anomaly_deg=0.0,
)
"""Arbitrary low orbit, for start bodies whose orbit depends on the plan."""


@dataclass(frozen=True)
class Numbering:
    """Bodies of stations, chasers and targets, in order of their numbers."""

    stations: tuple[Station, ...]
    chasers: tuple[Chaser, ...]
    targets: tuple[Target, ...]

    @property
    def bodies(self) -> tuple[tuple[Station, ...], tuple[Chaser, ...], tuple[Target, ...]]:
        """Stations, chasers and targets, as one key for caching."""
        return self.stations, self.chasers, self.targets

    @cached_property
    def start_bodies(self) -> dict[str, Orbit]:
        """Chasers' own start orbits, by name of the chaser.

        One that is launched into an orbit has that with any node, and one that is launched anywhere
        has none: an orbit stands there so that each body has one, and no transfer leads to it or
        from it.
        """
        some = (self.targets[0].orbit if self.targets else None) or LEO
        return {
            chaser.name: some if chaser.start == "anywhere" else chaser.start.orbit
            for chaser in self.chasers
            if not isinstance(chaser.start, AtStation)
        }

    @cached_property
    def first_target(self) -> int:
        """Number of the first target."""
        return len(self.stations) + len(self.start_bodies)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies."""
        return (
            *(station.name for station in self.stations),
            *self.start_bodies,
            *(target.name for target in self.targets),
        )

    @cached_property
    def orbits(self) -> tuple[Orbit | None, ...]:
        """Orbits of the bodies; None for bodies without one."""
        return (
            *(station.orbit for station in self.stations),
            *self.start_bodies.values(),
            *(target.orbit for target in self.targets),
        )

    @cached_property
    def decays_m_per_day(self) -> tuple[float, ...]:
        """Daily decrease of the bodies' semi-major axes [m/day]."""
        starts = [chaser.start for chaser in self.chasers if chaser.name in self.start_bodies]
        return (
            *(0.0 for _ in self.stations),
            *((isinstance(at, InOrbit) and at.decay_m_per_day) or 0.0 for at in starts),
            *(target.decay_m_per_day or 0.0 for target in self.targets),
        )

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """Number of each chaser's start body."""
        names = self.names
        return tuple(names.index(chaser.start_name) for chaser in self.chasers)
