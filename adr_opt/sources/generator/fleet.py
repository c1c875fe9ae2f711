"""Stations and chasers: a family's own, and additional random ones."""

from __future__ import annotations

from ...problem.bodies import Station
from ...problem.chasers import AtStation, Chaser, InOrbit, Start, Tank
from ...problem.orbit import Orbit
from .families import Family
from .stream import Uniform, stream

PURPOSE = 100
"""First stream of additional stations and starts, which leave the field of a seed unchanged."""


def stations_of(kind: Family, seed: int, count: int) -> tuple[Station, ...]:
    """The station of a family, and additional ones at random target positions."""
    if kind.station is None or count == 0:
        return ()
    uniform = stream(seed, PURPOSE + kind.purpose)
    orbits = [kind.station, *(kind.draw_target(uniform) for _ in range(count - 1))]
    return tuple(
        Station(name="station" if number == 1 else f"station-{number}", orbit=orbit)
        for number, orbit in enumerate(orbits, start=1)
    )


def chasers_of(
    kind: Family, seed: int, count: int, first: Orbit | None, stations: tuple[Station, ...]
) -> tuple[Chaser, ...]:
    """Identical chasers: at stations in turn, or in their own orbits, the first of which is given.

    Or those that the family draws.
    """
    if kind.draw_chaser is not None:
        return tuple(kind.draw_chaser(number) for number in range(count))
    uniform = stream(seed, 2 * PURPOSE + kind.purpose)
    tank = Tank(delta_v_m_s=kind.delta_v_m_s)
    return tuple(
        Chaser(
            name="chaser" if count == 1 else f"chaser-{number + 1}",
            start=_start(kind, number, first, stations, uniform),
            tank=tank,
        )
        for number in range(count)
    )


def _start(
    kind: Family, number: int, first: Orbit | None, stations: tuple[Station, ...], uniform: Uniform
) -> Start:
    if first is None:
        return AtStation(station=stations[number % len(stations)].name)
    if number == 0 or kind.draw_start is None:
        return InOrbit(orbit=first)
    return InOrbit(orbit=kind.draw_start(uniform))
