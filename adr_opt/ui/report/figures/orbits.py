"""Figures of orbits in space, and of their planes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....common.constants import EARTH_RADIUS_M
from ....fly.trajectory.kepler import Array
from ....fly.trajectory.sampling import SHORTEST_ARC_S
from ....plan.palette import REASONS, STATION, UNVISITED, VISITED, chaser_colours
from ....plan.phases import COLOURS
from ....plan.plan import Plan
from ....plan.routes import Flown, owners, routes_of
from ....problem.instance import Instance
from ...plot.chart import KM_M, Chart, ChartAxis, Line, Marks, Series
from ...plot.courses import in_km, on_earth, path_lines, rings_of
from ...plot.nodes import planes_chart, raan_deg, way
from ...plot.strands import POINTS_OF_A_RING, DrawnArc
from ..text import clock, in_chart
from .plotly_traces import SILENT, Figure, column, figure, leg_title, named, of_arcs, said, trace

MOST_RINGS = 200
"""Maximum number of orbits drawn; beyond it, some of those not visited are omitted."""

WINDOW_FILL = 1.6
"""Size of the farthest orbit; beyond this, the window would cut it off."""

SPACE = Chart((), ChartAxis("x [km]", 1), ChartAxis("y [km]", 1))


def orbits(instance: Instance, plan: Plan, tracks: tuple[DrawnArc, ...]) -> Figure:
    """The Earth, the orbits of all bodies and the chaser's path, in km and to scale.

    The frame is the inertial one of the elements. Orbits are the circles that are planned with;
    of every arc of the chaser at most one revolution is drawn.
    """
    (_, homes), (_, seen), (_, missed) = kinds_shown(instance, plan)
    lines = path_lines(instance, plan, tracks, 3.0, by_chaser=True)
    traces: list[dict[str, Any]] = [
        _earth(),
        _rings(rings_of(instance, "orbits not visited", missed, UNVISITED, 1.0), 0.45),
        _rings(rings_of(instance, "orbits visited", seen, VISITED, 1.0), 0.55),
        _rings(rings_of(instance, "station's orbit", homes, STATION, 4.0), 1.0),
        *(trace(line, SPACE) | of_arcs(line, "") for line in lines),
    ]
    arrivals = _arrivals(instance, plan, tracks)
    texts = [f"{leg_title(plan, leg)}<br>arrives {clock(time_s)}" for leg, time_s in arrivals.of]
    traces.append(trace(arrivals, SPACE) | named(instance, False) | said("%{text}", texts))
    layout = {"scene": _scene(instance, tracks), **named(instance, True)}
    return {"data": traces, "layout": layout}


def kinds_shown(instance: Instance, plan: Plan) -> tuple[tuple[str, list[str]], ...]:
    """Bodies whose orbits are drawn, by kind."""
    names, visited = [target.name for target in instance.targets], set(plan.destinations)
    return (
        ("station", list(instance.station_names)),
        ("visited", [name for name in names if name in visited]),
        ("not visited", [name for name in names if name not in visited][:MOST_RINGS]),
    )


def _arrivals(instance: Instance, plan: Plan, tracks: tuple[DrawnArc, ...]) -> Marks:
    """Positions of the chaser on docking after each leg."""
    whose, colours = owners(instance, plan), chaser_colours(instance)
    docked: dict[int, DrawnArc] = {}
    for track in tracks:
        if track.times_s[0] >= plan.legs[track.leg - 1].docked_s - SHORTEST_ARC_S:
            docked.setdefault(track.leg, track)

    def colour(leg: int) -> str:
        if leg in whose:
            return colours[whose[leg]]
        refuels = plan.legs[leg - 1].destination in instance.station_names
        return COLOURS["refuelling" if refuels else "service"]

    x, y, z = in_km(np.array([track.around_m[0] for track in docked.values()]))
    return Marks(
        name="arrivals",
        colour=COLOURS["service"],
        size=4.0,
        x=x,
        y=y,
        z=z,
        legs=list(docked),
        of=[(leg, track.times_s[0]) for leg, track in docked.items()],
        colours=[colour(leg) for leg in docked],
    )


def _rings(line: Line, opacity: float) -> dict[str, Any]:
    """Orbits of bodies, whose points are named by the page."""
    names = {"names": [in_chart(name) for name in line.of], "each": POINTS_OF_A_RING + 1}
    return trace(line, SPACE) | {"opacity": opacity, "meta": names} | said("orbit of %{text}")


def _earth() -> dict[str, Any]:
    """A sphere of triangles: a plotly surface would be refined, and slow without a GPU."""
    rows, columns = 25, 48
    latitude, longitude = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, rows),
        np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False),
        indexing="ij",
    )
    sphere = dict(zip("xyz", on_earth(latitude, longitude), strict=True))
    number = np.arange(rows * columns).reshape(rows, columns)
    south, north = number[:-1], number[1:]
    south_east, north_east = np.roll(south, -1, axis=1), np.roll(north, -1, axis=1)
    corners = np.concatenate(
        [
            np.stack([south, south_east, north_east], axis=2).reshape(-1, 3),
            np.stack([south, north_east, north], axis=2).reshape(-1, 3),
        ]
    )
    return {
        "type": "mesh3d",
        "name": "Earth",
        **{axis: column(values.ravel(), 1) for axis, values in sphere.items()},
        **{corner: corners[:, at].tolist() for at, corner in enumerate("ijk")},
        "color": "#8ba6bd",
        "hoverinfo": "skip",
        "showlegend": False,
        # The page paints day and night, so no lamp of the library lights it.
        "lighting": {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0, "fresnel": 0.0},
    }


def _scene(instance: Instance, tracks: tuple[DrawnArc, ...]) -> dict[str, Any]:
    """View at 55° to the normal of the first chaser's initial plane, slightly from the north.

    Without perspective, or a low orbit's near half hides behind the Earth's rim.
    """
    orbit = instance.body_orbits[instance.starts[0]]
    i, o = np.radians(orbit.inclination_deg), np.radians(orbit.raan_deg)
    normal = np.array([np.sin(i) * np.sin(o), -np.sin(i) * np.cos(o), np.cos(i)])
    side = np.array([np.cos(o), np.sin(o), 0.0])
    eye = np.cos(np.radians(55.0)) * normal + np.sin(np.radians(55.0)) * side
    eye += np.array([0.0, 0.0, 0.25])
    farthest = max(
        [
            *(orbit.semi_major_axis_m for orbit in instance.body_orbits),
            *(EARTH_RADIUS_M + float(track.altitudes_m.max()) for track in tracks),
        ]
    )
    hidden = {
        "visible": False,
        "showspikes": False,
        "showbackground": False,
        "range": [-farthest / KM_M, farthest / KM_M],
    }
    return {
        "aspectmode": "manual",
        "aspectratio": {axis: WINDOW_FILL for axis in "xyz"},
        "xaxis": hidden,
        "yaxis": hidden,
        "zaxis": hidden,
        "camera": {
            "eye": dict(zip("xyz", np.round(1.5 * eye, 4).tolist(), strict=True)),
            "projection": {"type": "orthographic"},
        },
    }


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
        return said("%{text}<br>RAAN %{x:.3f}°, inclination %{y:.3f}°", texts)

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
