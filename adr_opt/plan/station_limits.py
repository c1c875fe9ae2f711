"""Station supplies shared by all chasers, and their use by routes.

See docs/model.md section 5.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from ..problem.chasers import Chaser, TankByMass
from ..problem.instance import Instance
from .cargo import followed

Use = tuple[float, ...]
"""Amounts used of each limit."""

FloatArray = npt.NDArray[np.float64]


class StationLimits:
    """Limits of an instance's stations: refuellings, and kilograms of propellant.

    Parameters
    ----------
    instance : Instance

    Attributes
    ----------
    most : (limits,) float64
        Supply of each: refuellings of a station, or propellant [kg].
    of_body : (bodies,) float64
        Maximum number of visits of each body: targets once, a station by its refuellings.
    """

    def __init__(self, instance: Instance) -> None:
        self._instance = instance
        limits = [
            (station.name, weighs, float(limit))
            for station in instance.stations
            for weighs, limit in (
                (False, station.max_refuellings),
                (True, station.max_propellant_kg),
            )
            if limit is not None
        ]
        self._limits = tuple((name, weighs) for name, weighs, _ in limits)
        self.most: FloatArray = np.array([limit for *_, limit in limits])
        self.of_body: FloatArray = np.ones(len(instance.names))
        self.of_body[: len(instance.stations)] = [
            math.inf if station.max_refuellings is None else station.max_refuellings
            for station in instance.stations
        ]

    def __bool__(self) -> bool:
        return bool(self._limits)

    @property
    def nothing(self) -> Use:
        """Use by a route without refuellings."""
        return (0.0,) * len(self._limits)

    def use(self, chaser: Chaser, legs: Sequence[tuple[str, float]]) -> Use:
        """Use by a chaser that flies some legs.

        Parameters
        ----------
        chaser : Chaser
        legs : sequence of (str, float)
            Destination and ΔV [m/s] of each.
        """
        if not self:
            return ()
        stages, tank = followed(self._instance, chaser, legs), chaser.usable
        taken = []
        for name, weighs in self._limits:
            stops = [at for at, (body, _) in enumerate(legs) if body == name]
            if not weighs:
                taken.append(float(len(stops)))
                continue
            assert isinstance(tank, TankByMass)  # the instance has seen to it
            # Before it the chaser weighs as much without propellant as after it.
            taken.append(
                math.fsum(
                    tank.propellant_kg
                    - without * math.expm1(after.on_arrival_m_s / tank.exhaust_m_s)
                    for after in (stages[at + 1] for at in stops)
                    for without in (tank.dry_mass_kg + after.kits * chaser.kit_mass_kg,)
                )
            )
        return tuple(taken)

    def refuellings(self, stops: Sequence[int]) -> Use:
        """Use by refuellings at these stations, propellant excluded."""
        names = self._instance.station_names
        return tuple(
            0.0 if weighs else float(sum(names[stop] == name for stop in stops))
            for name, weighs in self._limits
        )

    def left(self, uses: Iterable[Use]) -> FloatArray:
        """Remaining supply of each limit; negative if overused."""
        left = np.array(self.most)
        for use in uses:
            left -= use
        return left

    def allow(self, uses: Iterable[Use]) -> bool:
        """Whether the supplies suffice for all of them."""
        return not self or bool((self.left(uses) >= 0.0).all())

    def exhausted(self, left: FloatArray) -> tuple[int, ...]:
        """Numbers of the stations whose remaining supplies allow no refuelling."""
        names = self._instance.station_names
        return tuple(
            names.index(name)
            for (name, weighs), rest in zip(self._limits, left, strict=True)
            if (rest <= 0.0 if weighs else rest < 1.0)
        )

    def total(self, prices: FloatArray) -> float:
        """Value of all limited supplies at prices of shape (bodies,)."""
        paid = prices > 0.0
        return math.fsum(self.of_body[paid] * prices[paid])

    @property
    def stations(self) -> tuple[int, ...]:
        """Numbers of the stations with limits."""
        return tuple(sorted({self._instance.station_names.index(name) for name, _ in self._limits}))
