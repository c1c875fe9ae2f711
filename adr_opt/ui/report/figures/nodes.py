"""Nodes against time, with the arcs on which the chaser drifts."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....plan.palette import LABELS, STATION, UNVISITED, VISITED
from ....plan.plan import Plan
from ....problem.instance import Instance
from ...plot.nodes import Nodes, axis_title, nodes_of, of_body, of_track
from ...plot.tracks import Track, joined
from ..text import in_chart
from .parts import Figure, column, days, legend, named, repeated, strands, time_axis

LEAST_ROOM_DEG = 0.05


def nodes(instance: Instance, plan: Plan, tracks: tuple[Track, ...]) -> Figure:
    """RAAN in degrees against days, less the common drift; bodies thin, the chaser thick."""
    shown = nodes_of(instance)
    visited = set(plan.destinations)
    kinds: dict[str, list[int]] = {"not visited": [], "visited": [], "station": []}
    for body, name in enumerate(instance.names):
        if name in instance.station_names:
            kinds["station"].append(body)
        elif body >= instance.first_target:
            kinds["visited" if name in visited else "not visited"].append(body)
    colours = {"not visited": UNVISITED, "visited": VISITED, "station": STATION}
    traces = [
        _bodies(instance, shown, title, bodies, colours[title])
        for title, bodies in kinds.items()
        if bodies
    ]
    traces += legend(instance)
    for phase, found, colour, about in strands(instance, plan, tracks):
        lines = [of_track(shown, track) for track in found]
        traces.append(
            {
                "type": "scatter", "mode": "lines", **about,
                "x": days(joined([times for times, _ in lines])),
                "y": column(joined([angles for _, angles in lines]), 4),
                "customdata": repeated(
                    [track.leg for track in found], [times.size for times, _ in lines]
                ),
                "line": {"color": colour, "width": 4},
                "hovertemplate": f"{LABELS[phase]}, %{{text}}<br>%{{y:.2f}}° at day %{{x:.2f}}"
                "<extra></extra>",
            }
        )  # fmt: skip
    layout = {
        "xaxis": time_axis(instance, plan),
        "yaxis": {"title": {"text": axis_title(shown, "°")}, **_range(traces)},
        **named(instance, True),
    }
    return {"data": traces, "layout": layout}


def _range(traces: list[dict[str, Any]]) -> dict[str, Any]:
    """Where the chaser and the bodies that it goes to are; of the others what is near them."""
    near = [
        angle
        for trace in traces
        if trace["name"] != "not visited"
        for angle in trace["y"]
        if angle is not None
    ]
    if not near:
        return {}
    room = max(0.08 * (max(near) - min(near)), LEAST_ROOM_DEG)
    return {"range": [round(min(near) - room, 4), round(max(near) + room, 4)]}


def _bodies(
    instance: Instance, shown: Nodes, title: str, bodies: list[int], colour: str
) -> dict[str, Any]:
    until_s = instance.mission.duration_s
    lines = [of_body(instance, shown, body, until_s) for body in bodies]
    said = [
        in_chart(instance.names[body])
        for body, (times, _) in zip(bodies, lines, strict=True)
        for _ in range(times.size + 1)
    ]
    return {
        "type": "scatter", "mode": "lines", "name": title,
        "x": days(joined([times for times, _ in lines])),
        "y": column(joined([np.asarray(angles) for _, angles in lines]), 4),
        "text": said, "line": {"color": colour, "width": 1}, "opacity": 0.75,
        "hovertemplate": "%{text}<br>%{y:.2f}° at day %{x:.2f}<extra></extra>",
    }  # fmt: skip
