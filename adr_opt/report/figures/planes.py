"""Where the orbital planes are, and how the chaser goes from one to the next."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...instance import Instance
from ...kernels.constants import EARTH_RADIUS_M
from ...plan import Plan
from ...plot.axes import KM_M, chaser_colours
from ...plot.fields import raan_deg
from ...plot.palette import REASONS, STATION, UNVISITED, VISITED
from ...routes import Flown, routes_of, several
from ..text import in_chart
from .parts import Figure, column


def planes(instance: Instance, plan: Plan) -> Figure:
    """RAAN across and inclination up, in degrees; a line follows each chaser."""
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
