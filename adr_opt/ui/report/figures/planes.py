"""The chart of the planes of orbits, with the order of visits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....common.constants import EARTH_RADIUS_M
from ....fly.trajectory.kepler import Array
from ....plan.palette import REASONS
from ....plan.plan import Plan
from ....plan.routes import Flown, routes_of
from ....problem.instance import Instance
from ...plot.chart import KM_M, Line, Series
from ...plot.nodes import planes_chart, raan_deg, way
from ..text import in_chart
from .plotly_traces import SILENT, Figure, column, figure, said

SIDES = (
    "middle right",
    "top right",
    "top center",
    "top left",
    "middle left",
    "bottom left",
    "bottom center",
    "bottom right",
)
"""Positions beside a point, from the right around to the left."""


def _sides(across: Array, up: Array) -> list[str]:
    """Side of each point of a line away from its neighbours, in plotly's terms."""
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
    """RAAN across and inclination up, in degrees; a line with numbered legs for each chaser."""
    reasons = {entry.target: entry.reason for entry in plan.unvisited}

    def told(leg: int, body: int) -> str:
        name = instance.names[body]
        altitude = (instance.body_orbits[body].semi_major_axis_m - EARTH_RADIUS_M) / KM_M
        text = f"<b>{in_chart(name)}</b>, {altitude:.1f} km"
        if leg:
            return f"{text}<br>visited by leg {leg}"
        if name in instance.station_names:
            return text
        why = f": {REASONS[reasons[name]]}" if name in reasons else ""
        return f"{text}<br>not visited{why}"

    def more(one: Series) -> dict[str, Any]:
        if isinstance(one, Line):
            return {"opacity": 0.6} | SILENT
        texts = [told(leg, body) for leg, body in one.of]
        ids = [instance.names[body] for _, body in one.of]
        return {"ids": ids} | said("%{text}<br>RAAN %{x:.3f}°, inclination %{y:.3f}°", texts)

    made = figure(planes_chart(instance, plan), more, showlegend=True)
    made["data"][-1:-1] = [_order(instance, flown) for flown in routes_of(instance, plan)]
    return made


def _order(instance: Instance, flown: Flown) -> dict[str, Any]:
    """Number of the leg beside each target, on the side away from the chaser's line."""
    legs, bodies = way(instance, flown)
    across = raan_deg(instance)[bodies]
    up = np.array([instance.body_orbits[body].inclination_deg for body in bodies])
    shown = [
        at
        for at, (leg, body) in enumerate(zip(legs, bodies, strict=True))
        if leg and body >= instance.first_target
    ]
    numbers, sides = [legs[at] for at in shown], _sides(across, up)
    return {
        "type": "scatter",
        "mode": "markers+text",
        "name": "order",
        "showlegend": False,
        "x": column(across[shown], 4),
        "y": column(up[shown], 4),
        "text": [str(number) for number in numbers],
        "customdata": numbers,
        "textposition": [sides[at] for at in shown],
        "textfont": {"size": 11},
        **SILENT,
        # not seen, but texts keep off marks
        "marker": {"size": 9, "color": "rgba(0,0,0,0)"},
    }
