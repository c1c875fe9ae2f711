"""Targets by their planes, and costs between all of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...common.constants import HOUR_S
from ...common.errors import InputError
from ...fly.flight.flyable import refuse_foreign
from ...legs.matrices import Matrices
from ...plan.palette import STATION, UNVISITED, VISITED, chaser_colours
from ...plan.plan import Plan
from ...plan.routes import routes_of, several
from ...problem.instance import Instance
from .axes import label, plain


def raan_deg(instance: Instance) -> np.ndarray[Any, np.dtype[np.float64]]:
    """RAAN of the bodies without a jump between them, shape (bodies,) [deg].

    Within half a turn of the first body's, so that planes near 0° and near 360° are side by side.
    """
    raan = np.array([orbit.raan_deg for orbit in instance.body_orbits])
    around: np.ndarray[Any, np.dtype[np.float64]] = np.mod(raan - raan[0] + 180.0, 360.0) - 180.0
    home = float(np.mod(raan[0] + 180.0, 360.0) - 180.0)
    return home + around


def planes(ax: Any, instance: Instance, plan: Plan | None = None) -> Any:
    """Add the orbital planes as points, RAAN across and inclination up [deg].

    With a plan, targets that it visits differ from the others, and a line follows each chaser from
    plane to plane.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    instance : Instance
    plan : Plan, optional

    Returns
    -------
    matplotlib.axes.Axes
    """
    raan = raan_deg(instance)
    inclination = np.array([orbit.inclination_deg for orbit in instance.body_orbits])
    index = {name: number for number, name in enumerate(instance.names)}
    stations = slice(len(instance.stations))
    visited = np.zeros(raan.size, dtype=bool)
    if plan is not None:
        refuse_foreign(instance, plan)
        colours = chaser_colours(instance)
        for flown in routes_of(instance, plan):
            name = flown.chaser.name
            route = [] if flown.chaser.is_launched else [index[flown.chaser.start_name]]
            route += [index[leg.destination] for _, leg in flown.legs if leg.destination in index]
            visited[route] = True
            ax.plot(
                raan[route], inclination[route], color=colours[name], linewidth=0.8, zorder=1,
                label=plain(name) if several(instance) else "chaser",
            )  # fmt: skip
    others = ~visited
    others[: instance.first_target] = False
    visited[: instance.first_target] = False
    ax.plot(
        raan[others], inclination[others], linestyle="none", marker="o", fillstyle="none",
        color=UNVISITED, label="target" if plan is None else "not visited",
    )  # fmt: skip
    if plan is not None:
        ax.plot(
            raan[visited], inclination[visited], linestyle="none", marker="o", color=VISITED,
            label="visited",
        )  # fmt: skip
    ax.plot(
        raan[stations], inclination[stations], linestyle="none", marker="s", color=STATION,
        label="station",
    )  # fmt: skip
    label(ax, "RAAN [deg]", "inclination [deg]")
    return ax


def matrix(ax: Any, matrices: Matrices, departure: int = 0, quantity: str = "delta_v") -> Any:
    """Add ΔV [m/s] or duration [h] of all transfers at one ready time as an image.

    Rows are origins, columns destinations, the stations first; pairs without a transfer stay empty.
    The image is ``ax.images[-1]``, for a colour bar.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    matrices : Matrices
    departure : int
        Which of ``matrices.departures``.
    quantity : {"delta_v", "duration"}

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        Another quantity, or there is no such departure.
    """
    if quantity not in ("delta_v", "duration"):
        raise InputError(f"quantity = {quantity!r}: must be 'delta_v' or 'duration'")
    if not -len(matrices.departures) <= departure < len(matrices.departures):
        raise InputError(
            f"departure = {departure}: must be less than {len(matrices.departures)}, the number "
            "of departures in the matrices"
        )
    costs = getattr(matrices, quantity)[departure]
    if quantity == "duration":
        costs = costs / HOUR_S
    shown = np.where(np.isfinite(costs), costs, np.nan)
    np.fill_diagonal(shown, np.nan)  # a body itself is no transfer
    ax.imshow(shown, interpolation="none")
    label(ax, "destination", "origin")
    return ax
