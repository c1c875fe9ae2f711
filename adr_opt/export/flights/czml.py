"""``.czml``: the mission for Cesium, with station, targets, and the chaser's path by phase."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...common.constants import DAY_S
from ...fly.trajectory.axes import Axes, axes_of
from ...fly.trajectory.bodies import body_states
from ...fly.trajectory.clock import UtcClock
from ...fly.trajectory.kepler import Array, revolution
from ...fly.trajectory.sampling import SHORTEST_ARC_S, STEP_S, Arc, LegPath, Trajectory
from ...plan.routes import owners, several
from .kvn import origin

Span = tuple[float, float]

CESIUM = "ICRF"
"""The frame that Cesium calls INERTIAL."""

BODY_STEP_S = 300.0
"""Interval between samples of bodies: a twentieth of a low orbit."""

MOST_BODY_STATES = 400_000
"""Maximum number of states of all bodies: twenty megabytes of file. Beyond it, a body is shown only
during legs that begin or end at it, and not at all without such legs."""

BODY_DEGREE = 7
"""Degree of Lagrange interpolation between samples, with errors of decimetres amid a track."""

ARC_DEGREE = 7

LONG_ARC_S = DAY_S
"""Duration of arcs beyond which only the current revolution is drawn: weeks of them would form a
shell around the Earth."""

SPEED_UP = 300.0
"""Initial speed relative to real time: twenty seconds per revolution."""


def to_czml(trajectory: Trajectory) -> str:
    """The mission as a CZML document.

    Positions are in Cesium's INERTIAL frame, the ICRF, which those of an instance that names its
    own frame are turned to. Each arc is a packet with its own path, shown while
    its leg is flown, in the colour of its phase; the chaser itself is one packet over all of them.
    Where there are several chasers, each is such a packet, and arcs are in the colour of theirs.
    """
    clock, axes = UtcClock(trajectory.instance), axes_of(trajectory.instance, CESIUM)
    trajectory = _turned(trajectory, axes)
    shown = _when_shown(trajectory)
    packets = [_document(trajectory, clock, axes, len(shown))]
    visited = set(trajectory.plan.destinations)
    packets += [
        _body(trajectory, clock, axes, name, name in visited, intervals)
        for name, intervals in shown.items()
    ]
    crew = _crew(trajectory)
    packets += [_chaser(trajectory, clock, chaser) for chaser in crew]
    for chaser in crew:
        for path in chaser.legs:
            arcs = range(len(path.arcs))
            packets += [_arc(trajectory, clock, chaser, path, number) for number in arcs]
    return json.dumps(packets, ensure_ascii=False, separators=(",", ":"), allow_nan=False) + "\n"


def _turned(trajectory: Trajectory, axes: Axes) -> Trajectory:
    """The flight in other axes; bodies stay in those of the instance."""
    if axes.matrix is None:
        return trajectory
    legs = []
    for path in trajectory.legs:
        arcs = (
            replace(
                arc,
                positions_m=axes.turned(arc.positions_m),
                velocities_m_s=axes.turned(arc.velocities_m_s),
            )
            for arc in path.arcs
        )
        legs.append(replace(path, arcs=tuple(arcs)))
    return replace(trajectory, legs=tuple(legs))


def _when_shown(trajectory: Trajectory) -> dict[str, list[Span]]:
    """Bodies in the file, each with its start and end times [s]."""
    names = trajectory.instance.names
    start, end = trajectory.start_s, trajectory.end_s
    if len(names) * (end - start) <= MOST_BODY_STATES * BODY_STEP_S:
        return {name: [(start, end)] for name in names}
    shown: dict[str, list[Span]] = {name: [] for name in names}
    for path in sorted(trajectory.legs, key=lambda path: path.arcs[0].start_s):
        begin, until = path.arcs[0].start_s, path.arcs[-1].end_s
        for name in {path.leg.origin, path.leg.destination}:
            spans = shown[name]
            goes_on = bool(spans) and spans[-1][1] >= begin - SHORTEST_ARC_S
            if goes_on:
                begun, ended = spans.pop()
                spans.append((begun, max(ended, until)))
            else:
                spans.append((begin, until))
    return {name: spans for name, spans in shown.items() if spans}


def _document(trajectory: Trajectory, clock: UtcClock, axes: Axes, bodies: int) -> dict[str, Any]:
    interval = _interval(clock, trajectory.start_s, trajectory.end_s)
    said = origin(trajectory.instance, trajectory.plan, axes)
    if bodies < len(trajectory.instance.names):
        said.append(
            f"Of {len(trajectory.instance.names)} bodies the {bodies} that legs begin or end at "
            "are shown, each during these legs: all of them all the time would be too much."
        )
    return {
        "id": "document",
        "name": trajectory.instance.name,
        "version": "1.0",
        "description": " ".join(said),
        "clock": {
            "interval": interval,
            "currentTime": _time(clock, trajectory.start_s),
            "multiplier": SPEED_UP,
            "range": "LOOP_STOP",
            "step": "SYSTEM_CLOCK_MULTIPLIER",
        },
    }


def _body(
    trajectory: Trajectory, clock: UtcClock, axes: Axes, name: str, visited: bool, shown: list[Span]
) -> dict[str, Any]:
    from ...plan import palette

    instance = trajectory.instance
    at_station = name in instance.station_names
    colour = palette.UNVISITED
    if at_station or visited:
        colour = palette.STATION if at_station else palette.VISITED
    tracks, intervals = [], []
    for start, end in shown:
        times = np.linspace(start, end, 1 + max(8, int(np.ceil((end - start) / BODY_STEP_S))))
        positions = axes.turned(body_states(instance, name, times)[0])
        tracks.append(_position(clock, times, positions, BODY_DEGREE, 1))
        intervals.append(_interval(clock, start, end))
    whole = len(shown) == 1
    packet: dict[str, Any] = {
        "id": f"body/{name}",
        "name": name,
        "availability": intervals[0] if whole else intervals,
        "position": tracks[0]
        if whole
        else [
            {"interval": interval, **track}
            for interval, track in zip(intervals, tracks, strict=True)
        ],
        "point": {"pixelSize": 9 if at_station else 5, "color": _rgba(colour)},
    }
    if at_station or visited:
        packet["label"] = _label(name, colour)
    return packet


class _Chaser(NamedTuple):
    """A chaser with legs.

    Attributes
    ----------
    id, name : str
        Of its packet. The first is a number where there are several: what a reference may say is
        less than what a name may be.
    colour : str or None
        Its own, where there are several.
    legs : tuple of LegPath
    """

    id: str
    name: str
    colour: str | None
    legs: tuple[LegPath, ...]

    def arcs(self) -> Iterator[tuple[LegPath, Arc]]:
        """Its arcs with their legs, in time order."""
        for path in self.legs:
            for arc in path.arcs:
                yield path, arc


def _crew(trajectory: Trajectory) -> list[_Chaser]:
    """The chasers of the legs."""
    from ...plan.palette import chaser_colours

    instance = trajectory.instance
    if not several(instance):
        return [_Chaser("chaser", "chaser", None, trajectory.legs)]
    whose, colours = owners(instance, trajectory.plan), chaser_colours(instance)
    found = []
    for number, chaser in enumerate(instance.chasers, start=1):
        legs = tuple(path for path in trajectory.legs if whose[path.number] == chaser.name)
        if legs:
            found.append(_Chaser(f"chaser/{number}", chaser.name, colours[chaser.name], legs))
    return found


def _chaser(trajectory: Trajectory, clock: UtcClock, chaser: _Chaser) -> dict[str, Any]:
    return {
        "id": chaser.id,
        "name": chaser.name,
        "availability": _interval(
            clock, chaser.legs[0].arcs[0].start_s, chaser.legs[-1].arcs[-1].end_s
        ),
        # One interval for each arc: interpolation must not run across a burn.
        "position": [
            {
                "interval": _interval(clock, arc.start_s, arc.end_s),
                **_position(clock, arc.times_s, arc.positions_m, ARC_DEGREE, 3),
            }
            for _, arc in chaser.arcs()
        ],
        "point": {
            "pixelSize": 10,
            "color": [
                {
                    "interval": _interval(clock, arc.start_s, arc.end_s),
                    **_rgba(_colour(trajectory, path, arc)),
                }
                for path, arc in chaser.arcs()
            ],
            "outlineColor": _rgba(chaser.colour or "#ffffff"),
            "outlineWidth": 2,
        },
        "label": _label(chaser.name, chaser.colour or "#ffffff"),
    }


def _arc(
    trajectory: Trajectory, clock: UtcClock, chaser: _Chaser, path: LegPath, number: int
) -> dict[str, Any]:
    arc = path.arcs[number]
    drawn_s = path.arcs[-1].end_s - path.arcs[0].start_s
    shown = path.arcs[0].start_s, path.arcs[-1].end_s
    colour = chaser.colour or _colour(trajectory, path, arc)
    title = f"leg {path.number}: {path.leg.origin} → {path.leg.destination}, {arc.phase}"
    position: dict[str, Any] = {"reference": f"{chaser.id}#position"}
    if arc.end_s - arc.start_s > LONG_ARC_S:
        drawn_s = 0.5 * revolution(arc.positions_m[0], arc.velocities_m_s[0])
        shown = arc.start_s, arc.end_s
    else:
        position = _position(clock, arc.times_s, arc.positions_m, ARC_DEGREE, 0)
    return {
        "id": f"leg {path.number}/{number + 1}",
        "name": title if chaser.colour is None else f"{chaser.name}, {title}",
        "availability": _interval(clock, *shown),
        "position": position,
        "path": {
            "leadTime": drawn_s,
            "trailTime": drawn_s,
            "width": 2 if arc.phase in ("wait", "service") else 3,
            "resolution": min(trajectory.step_s, STEP_S),
            "material": {"solidColor": {"color": _rgba(colour)}},
        },
    }


def _colour(trajectory: Trajectory, path: LegPath, arc: Arc) -> str:
    from ...plan.phases import COLOURS

    phase = arc.phase
    if phase == "service" and path.leg.destination in trajectory.instance.station_names:
        phase = "refuelling"
    return COLOURS[phase]


def _position(
    clock: UtcClock, times: Array, positions: Array, degree: int, digits: int
) -> dict[str, Any]:
    """Samples at seconds after the first [m], with ``digits`` decimals."""
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


def _interval(clock: UtcClock, start_s: float, end_s: float) -> str:
    return f"{_time(clock, start_s)}/{_time(clock, end_s)}"


def _time(clock: UtcClock, time_s: float) -> str:
    return clock.label(time_s) + "Z"
