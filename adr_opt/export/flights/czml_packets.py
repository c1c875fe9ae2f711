"""Parts of packets of CZML: document, positions, labels, colours and intervals of time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...common.constants import DAY_S
from ...fly.trajectory.clock import UtcClock
from ...fly.trajectory.kepler import Array

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


def document(
    clock: UtcClock, name: str, said: Iterable[str], start_s: float, end_s: float
) -> dict[str, Any]:
    """The packet that a document begins with: what it is of, and its clock."""
    return {
        "id": "document",
        "name": name,
        "version": "1.0",
        "description": " ".join(said),
        "clock": {
            "interval": lasting(clock, start_s, end_s),
            "currentTime": instant(clock, start_s),
            "multiplier": SPEED_UP,
            "range": "LOOP_STOP",
            "step": "SYSTEM_CLOCK_MULTIPLIER",
        },
    }


def body_packet(
    name: str, colour: str, tracks: Mapping[str, dict[str, Any]], *, large: bool, named: bool
) -> dict[str, Any]:
    """A body, shown in the intervals of its tracks, with a label if ``named``."""
    whole = len(tracks) == 1
    packet: dict[str, Any] = {
        "id": f"body/{name}",
        "name": name,
        "availability": next(iter(tracks)) if whole else list(tracks),
        "position": next(iter(tracks.values()))
        if whole
        else [{"interval": when, **track} for when, track in tracks.items()],
        "point": {"pixelSize": 9 if large else 5, "color": rgba(colour)},
    }
    if named:
        packet["label"] = labelled(name, colour)
    return packet


def chaser_packet(
    id: str,
    name: str,
    outline: str,
    shown: str,
    tracks: Mapping[str, dict[str, Any]],
    colours: Iterable[tuple[str, str]],
) -> dict[str, Any]:
    """A chaser, with a track for each of its arcs: interpolation must not run across a burn.

    ``colours`` are intervals and its colour in them.
    """
    return {
        "id": id,
        "name": name,
        "availability": shown,
        "position": [{"interval": when, **track} for when, track in tracks.items()],
        "point": {
            "pixelSize": 10,
            "color": [{"interval": when, **rgba(colour)} for when, colour in colours],
            "outlineColor": rgba(outline),
            "outlineWidth": 2,
        },
        "label": labelled(name, outline),
    }


def path_line(drawn_s: float, width: int, resolution_s: float, colour: object) -> dict[str, Any]:
    """The line of an arc, for some time before and after the chaser is there [s]."""
    return {
        "leadTime": drawn_s,
        "trailTime": drawn_s,
        "width": width,
        "resolution": resolution_s,
        "material": {"solidColor": {"color": colour}},
    }


def sampled(
    clock: UtcClock, times: Array, positions: Array, degree: int, digits: int
) -> dict[str, Any]:
    """Samples at seconds after the first [m], with ``digits`` decimals."""
    start = float(times[0])
    samples = np.column_stack([np.round(times - start, 6), np.round(positions, digits)])
    return {
        "epoch": instant(clock, start),
        "referenceFrame": "INERTIAL",
        "interpolationAlgorithm": "LAGRANGE",
        "interpolationDegree": degree,
        "cartesian": samples.ravel().tolist(),
    }


def labelled(text: str, colour: str) -> dict[str, Any]:
    """A label beside a point."""
    return {
        "text": text,
        "font": "12px sans-serif",
        "fillColor": rgba(colour),
        "horizontalOrigin": "LEFT",
        "pixelOffset": {"cartesian2": [10, 0]},
    }


def rgba(colour: str) -> dict[str, Any]:
    """A colour like ``#rrggbb``."""
    return {"rgba": [int(colour[i : i + 2], 16) for i in (1, 3, 5)] + [255]}


def lasting(clock: UtcClock, start_s: float, end_s: float) -> str:
    """An interval of time."""
    return f"{instant(clock, start_s)}/{instant(clock, end_s)}"


def instant(clock: UtcClock, time_s: float) -> str:
    """A point of time."""
    return clock.label(time_s) + "Z"
