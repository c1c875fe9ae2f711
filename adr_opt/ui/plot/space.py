"""Orbits in space, on an axis with ``projection="3d"``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...common.errors import InputError
from ...fly.trajectory.kepler import Array
from ...plan.palette import STATION, UNVISITED
from ...plan.plan import Plan
from ...problem.instance import Instance
from .chart import KM_M, Line
from .draw import add, label
from .strands import DrawnArc, joined, strands
from .tracks import ring


def earth(ax: Any) -> Any:
    """Add the Earth as a sphere [km]."""
    _check_three(ax)
    latitude, longitude = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, 19), np.linspace(0.0, 2.0 * np.pi, 37), indexing="ij"
    )
    ax.plot_surface(*on_earth(latitude, longitude), color="#9db4c8", alpha=0.5, linewidth=0)
    return drawn_in_space(ax, ())


def on_earth(latitude_rad: Array, longitude_rad: Array) -> Array:
    """Points on a spherical Earth [km], as three coordinates."""
    x, y = (
        np.cos(latitude_rad) * np.cos(longitude_rad),
        np.cos(latitude_rad) * np.sin(longitude_rad),
    )
    return EARTH_RADIUS_M / KM_M * np.stack([x, y, np.sin(latitude_rad)])


def orbits(ax: Any, instance: Instance) -> Any:
    """Add the orbits of the stations and of all targets [km], as planning circles."""
    rings = (
        rings_of(instance, "targets", [target.name for target in instance.targets], UNVISITED, 0.5),
        rings_of(instance, "station", list(instance.station_names), STATION, 1.6),
    )
    return drawn_in_space(ax, rings)


def rings_of(instance: Instance, title: str, names: list[str], colour: str, width: float) -> Line:
    """The orbits of some bodies as one line in space [km]."""
    x, y, z = in_km(joined([ring(instance, name) for name in names]))
    return Line(name=title, colour=colour, width=width, x=x, y=y, z=z, of=names)


def in_km(points_m: Array) -> Array:
    """Points in km, shape (3, points)."""
    return points_m.reshape(-1, 3).T / KM_M


def path_lines(
    instance: Instance, plan: Plan, tracks: tuple[DrawnArc, ...], width: float, *, by_chaser: bool
) -> list[Line]:
    """Flown arcs in space [km], at most one revolution of each."""
    return strands(
        instance,
        plan,
        tracks,
        lambda track: in_km(track.around_m).T,
        width,
        by_chaser=by_chaser,
        in_space=True,
    )


def _check_three(ax: Any) -> None:
    if not hasattr(ax, "set_zlabel"):
        raise InputError("the axis is flat; make it with projection='3d'")


def drawn_in_space(ax: Any, lines: Iterable[Line]) -> Any:
    """Add lines to an axis, which must be one in space.

    Raises
    ------
    InputError
        It is flat.
    """
    _check_three(ax)
    for line in lines:
        if np.size(line.x):
            add(ax, line, line.name)
    ax.set_aspect("equal")
    return label(ax, "x [km]", "y [km]", "z [km]")
