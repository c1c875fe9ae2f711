"""Plots along the courses of chasers: altitude, nodes, and the path in space."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ...common.constants import DAY_S, EARTH_RADIUS_M
from ...common.errors import InputError
from ...fly.trajectory.kepler import Array
from ...plan.palette import STATION, UNVISITED, ZONE
from ...plan.plan import Plan
from ...problem.instance import Instance
from .chart import DAYS, KM_M, Box, Chart, ChartAxis, Line, add, days, draw, label
from .nodes import nodes_chart
from .strands import DrawnArc, joined, ring, strands, tracks
from .thrust_arcs import thrust_arcs

ALTITUDES = ChartAxis("altitude [km]")


def altitude_chart(
    instance: Instance, plan: Plan, tracks: tuple[DrawnArc, ...], *, by_chaser: bool
) -> Chart:
    """Altitudes of flown arcs [km] against days; ``by_chaser`` as in :func:`.strands`."""

    def course(track: DrawnArc) -> Array:
        return np.column_stack([days(track.times_s), track.altitudes_m / KM_M])

    lines = strands(instance, plan, tracks, course, 1.8, by_chaser=by_chaser)
    return Chart(tuple(lines), DAYS, ALTITUDES)


def zones(instance: Instance) -> tuple[Box, ...]:
    """The keep-out zones as boxes."""
    return tuple(
        Box(
            name="keep-out zone",
            colour=ZONE,
            phase="zone",
            of=(zone,),
            x=(zone.start_s / DAY_S, zone.end_s / DAY_S),
            y=(zone.min_altitude_m / KM_M, zone.max_altitude_m / KM_M),
        )
        for zone in instance.keep_out_zones
    )


def keep_out_zones(ax: Any, instance: Instance) -> Any:
    """Add the keep-out zones as shaded boxes, altitude [km] against time [days]."""
    return draw(ax, Chart(zones(instance), DAYS, ALTITUDES))


def earth(ax: Any) -> Any:
    """Add the Earth as a sphere [km]."""
    _check_three(ax)
    latitude, longitude = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, 19), np.linspace(0.0, 2.0 * np.pi, 37), indexing="ij"
    )
    x, y = np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude)
    sphere = EARTH_RADIUS_M / KM_M * np.stack([x, y, np.sin(latitude)])
    ax.plot_surface(*sphere, color="#9db4c8", alpha=0.5, linewidth=0)
    return drawn_in_space(ax, ())


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


def _check_three(ax: Any) -> None:
    if not hasattr(ax, "set_zlabel"):
        raise InputError("the axis is flat; make it with projection='3d'")


def drawn_in_space(ax: Any, lines: Iterable[Line]) -> Any:
    """Add lines to an axis, which must be three-dimensional.

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


def arcs_of(instance: Instance, plan: Plan) -> tuple[DrawnArc, ...]:
    """A plan ready to be drawn: flown or, with low thrust, from its arcs.

    Raises
    ------
    InputError
        The plan belongs to another instance, or leads nowhere.
    """
    return thrust_arcs(instance, plan) if instance.has_low_thrust else tracks(instance, plan)


def altitude(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add the chaser's altitude [km] against time [days], one colour per phase.

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    found = arcs_of(instance, plan)
    return draw(ax, altitude_chart(instance, plan, found, by_chaser=False))


def nodes(ax: Any, instance: Instance, plan: Plan | None = None) -> Any:
    """Add RAAN [deg] against time [days], relative to the bodies' common drift.

    Targets are thin lines. With a plan, those that it visits differ from the others, and thick
    lines, one colour per phase, follow the chaser: on a drift orbit its node crosses to the next.

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    if plan is not None:
        plan.instance.refuse_other(instance)
    found = () if plan is None else arcs_of(instance, plan)
    return draw(ax, nodes_chart(instance, plan, found, by_chaser=False))


def path(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add the chaser's path in the inertial frame [km], one colour per phase.

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    found = arcs_of(instance, plan)

    def course(track: DrawnArc) -> Array:
        return in_km(track.around_m).T

    return drawn_in_space(ax, strands(instance, plan, found, course, 1.1, by_chaser=False))
