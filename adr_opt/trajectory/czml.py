"""``.czml``: the mission for Cesium: station, targets, and the chaser's path, coloured by phase."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from .bodies import body_states
from .clock import Clock
from .kepler import Array
from .kvn import origin
from .sampling import Arc, LegPath, Trajectory

BODY_STEP_S = 300.0
"""Between samples of the station and the targets; a twentieth of a low orbit."""

BODY_DEGREE = 7
"""Of Lagrange's interpolation between them: a few decimetres of error in the middle of a track."""

ARC_DEGREE = 7

SPEED_UP = 300.0
"""Times real time when the file is opened: twenty seconds for a revolution."""


def to_czml(trajectory: Trajectory) -> str:
    """The mission as a CZML document.

    Positions are in Cesium's INERTIAL frame. Each arc is a packet with its own path, shown while
    its leg is flown, in the colour of its phase; the chaser itself is one packet over all of them.
    """
    clock = Clock(trajectory.instance)
    packets = [_document(trajectory, clock)]
    visited = set(trajectory.plan.destinations)
    for name in trajectory.instance.names:
        packets.append(_body(trajectory, clock, name, name in visited))
    packets.append(_chaser(trajectory, clock))
    for path in trajectory.legs:
        packets += [_arc(trajectory, clock, path, number) for number in range(len(path.arcs))]
    return json.dumps(packets, ensure_ascii=False, separators=(",", ":"), allow_nan=False) + "\n"


def _document(trajectory: Trajectory, clock: Clock) -> dict[str, Any]:
    interval = _interval(clock, trajectory.start_s, trajectory.end_s)
    return {
        "id": "document",
        "name": trajectory.instance.name,
        "version": "1.0",
        "description": " ".join(origin(trajectory.instance, trajectory.plan)),
        "clock": {
            "interval": interval,
            "currentTime": _time(clock, trajectory.start_s),
            "multiplier": SPEED_UP,
            "range": "LOOP_STOP",
            "step": "SYSTEM_CLOCK_MULTIPLIER",
        },
    }


def _body(trajectory: Trajectory, clock: Clock, name: str, visited: bool) -> dict[str, Any]:
    from ..plot import palette

    instance = trajectory.instance
    at_station = name in instance.station_names
    colour = palette.UNVISITED
    if at_station or visited:
        colour = palette.STATION if at_station else palette.VISITED
    span = trajectory.end_s - trajectory.start_s
    times = np.linspace(
        trajectory.start_s, trajectory.end_s, 1 + max(8, int(np.ceil(span / BODY_STEP_S)))
    )
    packet: dict[str, Any] = {
        "id": f"body/{name}",
        "name": name,
        "availability": _interval(clock, trajectory.start_s, trajectory.end_s),
        "position": _position(clock, times, body_states(instance, name, times)[0], BODY_DEGREE, 1),
        "point": {"pixelSize": 9 if at_station else 5, "color": _rgba(colour)},
    }
    if at_station or visited:
        packet["label"] = _label(name, colour)
    return packet


def _chaser(trajectory: Trajectory, clock: Clock) -> dict[str, Any]:
    return {
        "id": "chaser",
        "name": "chaser",
        "availability": _interval(clock, trajectory.start_s, trajectory.end_s),
        # One interval for each arc: interpolation must not run across a burn.
        "position": [
            {
                "interval": _interval(clock, arc.start_s, arc.end_s),
                **_position(clock, arc.times_s, arc.positions_m, ARC_DEGREE, 3),
            }
            for _, arc in trajectory.arcs()
        ],
        "point": {
            "pixelSize": 10,
            "color": [
                {
                    "interval": _interval(clock, arc.start_s, arc.end_s),
                    **_rgba(_colour(trajectory, path, arc)),
                }
                for path, arc in trajectory.arcs()
            ],
            "outlineColor": _rgba("#ffffff"),
            "outlineWidth": 2,
        },
        "label": _label("chaser", "#ffffff"),
    }


def _arc(trajectory: Trajectory, clock: Clock, path: LegPath, number: int) -> dict[str, Any]:
    arc = path.arcs[number]
    leg_s = path.arcs[-1].end_s - path.arcs[0].start_s
    return {
        "id": f"leg {path.number}/{number + 1}",
        "name": f"leg {path.number}: {path.leg.origin} → {path.leg.destination}, {arc.phase}",
        "availability": _interval(clock, path.arcs[0].start_s, path.arcs[-1].end_s),
        "position": _position(clock, arc.times_s, arc.positions_m, ARC_DEGREE, 0),
        "path": {
            "leadTime": leg_s,
            "trailTime": leg_s,
            "width": 2 if arc.phase in ("wait", "service") else 3,
            "resolution": trajectory.step_s,
            "material": {"solidColor": {"color": _rgba(_colour(trajectory, path, arc))}},
        },
    }


def _colour(trajectory: Trajectory, path: LegPath, arc: Arc) -> str:
    from ..plot import palette

    phase = arc.phase
    if phase == "service" and path.leg.destination in trajectory.instance.station_names:
        phase = "refuelling"
    return palette.COLOURS[phase]


def _position(
    clock: Clock, times: Array, positions: Array, degree: int, digits: int
) -> dict[str, Any]:
    """Samples at seconds after the first of them [m], with ``digits`` after the point."""
    start = float(times[0])
    samples = np.column_stack([np.round(times - start, 6), np.round(positions, digits)])
    return {
        "epoch": _time(clock, start),
        "referenceFrame": "INERTIAL",
        "interpolationAlgorithm": "LAGRANGE",
        "interpolationDegree": degree,
        "cartesian": samples.ravel().tolist(),
    }


def _label(text: str, colour: str) -> dict[str, Any]:
    return {
        "text": text,
        "font": "12px sans-serif",
        "fillColor": _rgba(colour),
        "horizontalOrigin": "LEFT",
        "pixelOffset": {"cartesian2": [10, 0]},
    }


def _rgba(colour: str) -> dict[str, Any]:
    return {"rgba": [int(colour[i : i + 2], 16) for i in (1, 3, 5)] + [255]}


def _interval(clock: Clock, start_s: float, end_s: float) -> str:
    return f"{_time(clock, start_s)}/{_time(clock, end_s)}"


def _time(clock: Clock, time_s: float) -> str:
    return clock.label(time_s) + "Z"
