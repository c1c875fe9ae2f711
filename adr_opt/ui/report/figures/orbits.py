"""Orbits around the Earth, with the chaser's path."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....common.constants import EARTH_RADIUS_M
from ....fly.trajectory.sampling import SHORTEST_ARC_S
from ....plan.palette import STATION, UNVISITED, VISITED, chaser_colours
from ....plan.phases import COLOURS
from ....plan.plan import Plan
from ....plan.routes import owners
from ....problem.instance import Instance
from ...plot.chart import KM_M, Chart, ChartAxis, Line, Marks
from ...plot.space import in_km, on_earth, path_lines, rings_of
from ...plot.strands import POINTS_OF_A_RING, DrawnArc
from ..text import clock, in_chart
from .parts import Figure, column, leg_title, named, of_arcs, said, trace

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
