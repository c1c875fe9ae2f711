"""Orbits in space, on an axis with ``projection="3d"``."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...common.errors import InputError
from ...plan.palette import COLOURS, LABELS, PHASES, STATION, UNVISITED
from ...plan.plan import Plan
from ...problem.instance import Instance
from .axes import KM_M, label
from .tracks import joined, ring, tracks


def earth(ax: Any) -> Any:
    """Add the Earth as a sphere [km].

    Parameters
    ----------
    ax : mpl_toolkits.mplot3d.Axes3D

    Returns
    -------
    mpl_toolkits.mplot3d.Axes3D
    """
    _check_three(ax)
    latitude, longitude = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, 19), np.linspace(0.0, 2.0 * np.pi, 37), indexing="ij"
    )
    radius = EARTH_RADIUS_M / KM_M
    ax.plot_surface(
        radius * np.cos(latitude) * np.cos(longitude),
        radius * np.cos(latitude) * np.sin(longitude),
        radius * np.sin(latitude),
        color="#9db4c8", alpha=0.5, linewidth=0,
    )  # fmt: skip
    ax.set_aspect("equal")
    return _labelled(ax)


def orbits(ax: Any, instance: Instance) -> Any:
    """Add the orbits of the stations and of all targets [km], as the circles planned with.

    Parameters
    ----------
    ax : mpl_toolkits.mplot3d.Axes3D
    instance : Instance

    Returns
    -------
    mpl_toolkits.mplot3d.Axes3D
    """
    _check_three(ax)
    rings = joined([ring(instance, target.name) for target in instance.targets]) / KM_M
    if rings.size:
        ax.plot(*rings.T, color=UNVISITED, linewidth=0.4, label="targets")
    homes = joined([ring(instance, name) for name in instance.station_names]) / KM_M
    if homes.size:
        ax.plot(*homes.T, color=STATION, linewidth=1.2, label="station")
    ax.set_aspect("equal")
    return _labelled(ax)


def path(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add the chaser's path in the inertial frame [km], one colour per phase.

    Parameters
    ----------
    ax : mpl_toolkits.mplot3d.Axes3D
    instance : Instance
    plan : Plan

    Returns
    -------
    mpl_toolkits.mplot3d.Axes3D

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    _check_three(ax)
    found = tracks(instance, plan)
    for phase in PHASES:
        of_phase = [track.around_m for track in found if track.phase == phase]
        if of_phase:
            ax.plot(
                *(joined(of_phase) / KM_M).T, color=COLOURS[phase], linewidth=0.8,
                label=LABELS[phase],
            )  # fmt: skip
    ax.set_aspect("equal")
    return _labelled(ax)


def _check_three(ax: Any) -> None:
    if not hasattr(ax, "set_zlabel"):
        raise InputError("the axis is flat; make it with projection='3d'")


def _labelled(ax: Any) -> Any:
    label(ax, "x [km]", "y [km]")
    if not ax.get_zlabel():
        ax.set_zlabel("z [km]")
    return ax
