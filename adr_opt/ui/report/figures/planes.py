"""Where the orbital planes are, and how the chaser goes from one to the next."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....common.constants import EARTH_RADIUS_M
from ....fly.trajectory.kepler import Array
from ....plan.palette import REASONS, STATION, UNVISITED, VISITED, chaser_colours
from ....plan.plan import Plan
from ....plan.routes import Flown, routes_of, several
from ....problem.instance import Instance
from ...plot.axes import KM_M
from ...plot.fields import raan_deg
from ..text import in_chart
from .parts import Figure, column

SIDES = (
    "middle right", "top right", "top center", "top left", "middle left", "bottom left",
    "bottom center", "bottom right",
)  # fmt: skip
"""Beside a point, from the right around to the left."""


def _sides(across: Array, up: Array) -> list[str]:
    """For each point of a line the side away from its neighbours, as plotly calls it."""
    points = np.column_stack([across, up])
    widths = np.ptp(points, axis=0) if len(points) else np.ones(2)
    points = points / np.where(widths > 0.0, widths, 1.0)
    found = []
    for at, point in enumerate(points):
        away = np.zeros(2)
        for other in points[max(0, at - 1) : at + 2]:
            distance = float(np.linalg.norm(point - other))
            away += (point - other) / distance if distance > 0.0 else 0.0
        turn = math.atan2(away[1], away[0]) / (2.0 * math.pi) if away.any() else 0.25
        found.append(SIDES[round(turn * len(SIDES)) % len(SIDES)])
    return found


def planes(instance: Instance, plan: Plan) -> Figure:
    """RAAN across and inclination up, in degrees; a line follows each chaser, legs are numbered."""
    raan = raan_deg(instance)
    inclination = np.array([orbit.inclination_deg for orbit in instance.body_orbits])
    index = {name: number for number, name in enumerate(instance.names)}
    legs = [(n, leg) for n, leg in enumerate(plan.legs, start=1) if leg.destination in index]
    first, stations = instance.first_target, list(range(len(instance.stations)))
    visits = [(n, index[leg.destination]) for n, leg in legs if index[leg.destination] >= first]
    colours = chaser_colours(instance)
    reasons = {entry.target: entry.reason for entry in plan.unvisited}
    seen = {body for _, body in visits}
    missed = [body for body in range(first, raan.size) if body not in seen]

    def points(name: str, bodies: list[int], said: list[str], **more: Any) -> dict[str, Any]:
        return {
            "type": "scatter", "mode": "markers", "name": name,
            "x": column(raan[bodies], 4), "y": column(inclination[bodies], 4), "text": said,
            "hovertemplate": "%{text}<br>RAAN %{x:.3f}°, inclination %{y:.3f}°<extra></extra>",
            **more,
        }  # fmt: skip

    def line(flown: Flown) -> dict[str, Any]:
        flies = [(n, index[leg.destination]) for n, leg in flown.legs if leg.destination in index]
        home = [] if flown.chaser.is_launched else [index[flown.chaser.start_name]]
        route = [*home, *(body for _, body in flies)]
        name = flown.chaser.name
        return {
            "type": "scatter", "mode": "lines",
            "name": in_chart(name) if several(instance) else "chaser",
            "x": column(raan[route], 4), "y": column(inclination[route], 4),
            "customdata": [*(0 for _ in home), *(n for n, _ in flies)],
            "line": {"color": colours[name], "width": 1}, "opacity": 0.6,
            "hoverinfo": "skip",
        }  # fmt: skip

    def order(flown: Flown) -> dict[str, Any]:
        """The number of its leg beside each target, on the side where the chaser's line is not."""
        mine = [(n, index[leg.destination]) for n, leg in flown.legs if leg.destination in index]
        home = [] if flown.chaser.is_launched else [index[flown.chaser.start_name]]
        bodies = [*home, *(body for _, body in mine)]
        sides = _sides(raan[bodies], inclination[bodies])[len(home) :]
        shown = [
            (n, body, side) for (n, body), side in zip(mine, sides, strict=True) if body >= first
        ]
        numbers, at = [n for n, _, _ in shown], [body for _, body, _ in shown]
        colour = {"color": colours[flown.chaser.name]} if several(instance) else {}
        return {
            "type": "scatter", "mode": "markers+text", "name": "order", "showlegend": False,
            "x": column(raan[at], 4), "y": column(inclination[at], 4),
            "text": [str(n) for n in numbers], "customdata": numbers,
            "textposition": [side for _, _, side in shown],
            "textfont": {"size": 11, **colour}, "hoverinfo": "skip",
            # not seen, but texts keep off marks
            "marker": {"size": 9, "color": "rgba(0,0,0,0)"},
        }  # fmt: skip

    def body_text(body: int) -> str:
        altitude = (instance.body_orbits[body].semi_major_axis_m - EARTH_RADIUS_M) / KM_M
        return f"<b>{in_chart(instance.names[body])}</b>, {altitude:.1f} km"

    traces = [
        *(line(flown) for flown in routes_of(instance, plan)),
        points(
            "not visited", missed,
            [
                f"{body_text(body)}<br>not visited"
                + (f": {REASONS[reasons[name]]}" if (name := instance.names[body]) in reasons
                   else "")
                for body in missed
            ],
            marker={"color": UNVISITED, "size": 9, "symbol": "circle-open"},
        ),
        points(
            "visited", [body for _, body in visits],
            [f"{body_text(body)}<br>visited by leg {n}" for n, body in visits],
            customdata=[n for n, _ in visits], marker={"color": VISITED, "size": 9},
        ),
        *(order(flown) for flown in routes_of(instance, plan)),
        points(
            "station", stations, [body_text(body) for body in stations],
            marker={"color": STATION, "size": 12, "symbol": "square"},
        ),
    ]  # fmt: skip
    layout = {
        "showlegend": True,
        "xaxis": {"title": {"text": "RAAN [°]"}},
        "yaxis": {"title": {"text": "inclination [°]"}},
    }
    return {"data": traces, "layout": layout}
