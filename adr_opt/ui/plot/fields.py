"""Targets by orbital plane, and costs between all of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...common.constants import HOUR_S
from ...common.errors import InputError
from ...legs.matrices import Matrices
from ...plan.palette import STATION, UNVISITED, VISITED, chaser_colours
from ...plan.plan import Plan
from ...plan.routes import Flown, routes_of, several
from ...problem.instance import Instance
from .chart import Chart, ChartAxis, Line, Marks, Series
from .draw import draw, label


def raan_deg(instance: Instance) -> np.ndarray[Any, np.dtype[np.float64]]:
    """RAAN of the bodies, unwrapped to avoid jumps, shape (bodies,) [deg].

    Within half a turn of the first body's, so that planes near 0° and near 360° are side by side.
    """
    raan = np.array([orbit.raan_deg for orbit in instance.body_orbits])
    around: np.ndarray[Any, np.dtype[np.float64]] = np.mod(raan - raan[0] + 180.0, 360.0) - 180.0
    home = float(np.mod(raan[0] + 180.0, 360.0) - 180.0)
    return home + around


def way(instance: Instance, flown: Flown) -> tuple[list[int], list[int]]:
    """Numbers of the bodies that a chaser visits from its start, each with its leg or 0."""
    index = {name: number for number, name in enumerate(instance.names)}
    home = [] if flown.chaser.is_launched else [(0, flown.chaser.start_name)]
    there = [*home, *((number, leg.destination) for number, leg in flown.legs)]
    known = [(number, index[name]) for number, name in there if name in index]
    return [number for number, _ in known], [body for _, body in known]


def planes_chart(instance: Instance, plan: Plan | None) -> Chart:
    """RAAN across and inclination up, in degrees; a line follows each chaser."""
    raan, first = raan_deg(instance), instance.first_target
    inclination = np.array([orbit.inclination_deg for orbit in instance.body_orbits])
    colours = chaser_colours(instance)

    def at(bodies: list[int], legs: Sequence[int] | None = None) -> dict[str, Any]:
        of = list(zip(legs or [0] * len(bodies), bodies, strict=True))
        return {"x": raan[bodies], "y": inclination[bodies], "of": of, "legs": legs}

    series: list[Series] = []
    visits: list[tuple[int, int]] = []
    for flown in () if plan is None else routes_of(instance, plan):
        name, (legs, bodies) = flown.chaser.name, way(instance, flown)
        said = name if several(instance) else "chaser"
        series.append(Line(name=said, colour=colours[name], width=1.0, **at(bodies, legs)))
        visits += [
            (leg, body) for leg, body in zip(legs, bodies, strict=True) if leg and body >= first
        ]
    seen = {body for _, body in visits}
    others = [body for body in range(first, raan.size) if body not in seen]
    missed = "target" if plan is None else "not visited"
    series.append(Marks(name=missed, colour=UNVISITED, symbol="circle-open", **at(others)))
    if plan is not None:
        there = at([body for _, body in visits], [leg for leg, _ in visits])
        series.append(Marks(name="visited", colour=VISITED, **there))
    stations = at(list(range(len(instance.stations))))
    series.append(Marks(name="station", colour=STATION, symbol="square", size=12, **stations))
    return Chart(tuple(series), ChartAxis("RAAN [°]", 4), ChartAxis("inclination [°]", 4))


def planes(ax: Any, instance: Instance, plan: Plan | None = None) -> Any:
    """Add the orbital planes as points, with RAAN across and inclination up [deg].

    With a plan, targets that it visits differ from the others, and a line follows each chaser from
    plane to plane.
    """
    if plan is not None:
        plan.instance.refuse_other(instance)
    return draw(ax, planes_chart(instance, plan))


def matrix(ax: Any, matrices: Matrices, departure: int = 0, quantity: str = "delta_v") -> Any:
    """Add ΔV [m/s] or duration [h] of all transfers at one ready time as an image.

    Rows are origins, columns destinations, the stations first; pairs without a transfer stay empty.
    The image is ``ax.images[-1]``, for a colour bar.

    Parameters
    ----------
    matrices : Matrices
    departure : int
        Which of ``matrices.departures``.
    quantity : {"delta_v", "duration"}

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
    return label(ax, "destination", "origin")
