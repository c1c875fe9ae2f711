"""Allowed values that look like a mistake of units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from ..common.constants import DAY_S, EARTH_RADIUS_M, HOUR_S
from .chasers import InOrbit, TankByMass
from .disposal import DisposalCircle
from .instance import Instance

HEAVY_KG = 10_000.0
"""Mass above which a thrust of several newtons is plausible."""

Values = Iterable[tuple[str, float]]
"""Fields of an instance, each with its value."""


class Doubt(NamedTuple):
    """A value outside the usual: its field, and the likely slip."""

    field: str
    value: float
    slip: str

    def __str__(self) -> str:
        return f"{self.field} = {self.value:g}: {self.slip}"


class Usual(NamedTuple):
    """The usual range of a quantity; 0 is always usual.

    Attributes
    ----------
    values : callable
        Of an instance.
    least, most : float
    slip : str
        What a value outside it suggests.
    """

    values: Callable[[Instance], Values]
    least: float
    most: float
    slip: str


def _tanks(instance: Instance) -> Iterator[tuple[str, float]]:
    for number, chaser in enumerate(instance.chasers):
        yield f"chasers[{number}].tank.delta_v_m_s", chaser.tank.delta_v_m_s


def _thrusts(instance: Instance) -> Iterator[tuple[str, float]]:
    for number, chaser in enumerate(instance.chasers):
        tank = chaser.tank
        if chaser.thrust_n is not None and isinstance(tank, TankByMass):
            if tank.dry_mass_kg + tank.propellant_kg < HEAVY_KG:
                yield f"chasers[{number}].thrust_n", chaser.thrust_n


def _chemical(instance: Instance) -> Iterator[tuple[str, float]]:
    for number, chaser in enumerate(instance.chasers):
        if chaser.thrust_n is None and isinstance(chaser.tank, TankByMass):
            yield f"chasers[{number}].tank.isp_s", chaser.tank.isp_s


def _altitudes(instance: Instance) -> Iterator[tuple[str, float]]:
    places = [("mission", instance.mission.disposal)]
    places += [(f"targets[{at}]", each.disposal) for at, each in enumerate(instance.targets)]
    for place, disposal in places:
        if isinstance(disposal, DisposalCircle):
            yield f"{place}.disposal.circle_m", disposal.circle_m
    for name in ("min_altitude_m", "max_altitude_m"):
        yield f"transfer.{name}", getattr(instance.transfer, name)
        for number, zone in enumerate(instance.keep_out_zones):
            yield f"keep_out_zones[{number}].{name}", getattr(zone, name)


def _heights(instance: Instance) -> Iterator[tuple[str, float]]:
    for number, station in enumerate(instance.stations):
        if station.orbit is not None:
            at = f"stations[{number}].orbit.semi_major_axis_m"
            yield at, station.orbit.semi_major_axis_m
    for number, chaser in enumerate(instance.chasers):
        if isinstance(chaser.start, InOrbit):
            at = f"chasers[{number}].start.orbit.semi_major_axis_m"
            yield at, chaser.start.orbit.semi_major_axis_m
        if chaser.launch is not None:
            at = f"chasers[{number}].start.launch.altitude_m"
            yield at, EARTH_RADIUS_M + chaser.launch.altitude_m


def _durations(instance: Instance) -> Iterator[tuple[str, float]]:
    yield "mission.duration_s", instance.mission.duration_s


def _windows(instance: Instance) -> Iterator[tuple[str, float]]:
    if instance.mission.duration_s < DAY_S:
        return
    for number, target in enumerate(instance.targets):
        last, closes = len(target.windows) - 1, target.windows[-1][1]
        if closes is not None:
            field = "window_s" if target.windows_s is None else f"windows_s[{last}]"
            yield f"targets[{number}].{field}[1]", closes


USUAL = (
    Usual(_tanks, 50.0, math.inf, "less than most legs take; is it in km/s? The field is in m/s"),
    Usual(_thrusts, 0.0, 5.0, "no electric engine has it; is it in mN? The field is in N"),
    Usual(_chemical, 0.0, 1000.0, "no chemical engine has it; is it an exhaust speed in m/s?"),
    Usual(_altitudes, 50e3, math.inf, "within the atmosphere; is it in km? The field is in m"),
    Usual(
        _heights,
        EARTH_RADIUS_M + 100e3,
        EARTH_RADIUS_M + 50e6,
        "an altitude within the atmosphere or beyond all high orbits; is it in another unit?",
    ),
    Usual(_durations, HOUR_S, math.inf, "less than a revolution; is it in days? The field is in s"),
    Usual(_windows, HOUR_S, math.inf, "over almost at once; is it in days? The field is in s"),
)
"""Limits are generous: values outside are sometimes meant, so they cause a note, not an error."""


def doubts(instance: Instance) -> tuple[Doubt, ...]:
    """Values that look like slips of units, the first of each kind."""
    found = []
    for usual in USUAL:
        odd = (
            Doubt(field, value, usual.slip)
            for field, value in usual.values(instance)
            if value != 0.0 and not usual.least <= value <= usual.most
        )
        found.extend([doubt for doubt, _ in zip(odd, range(1), strict=False)])
    return tuple(found)
