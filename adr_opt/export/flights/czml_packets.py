"""Parts of packets of CZML: document, positions, labels, colours and intervals of time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from ...common.constants import DAY_S
from ...fly.trajectory.clock import UtcClock
from ...fly.trajectory.kepler import Array, revolution
from ...fly.trajectory.sampling import Arc
from ...plan.palette import chaser_colours
from ...plan.routes import several
from ...problem.instance import Instance

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


LegT = TypeVar("LegT")


class ShownChaser(NamedTuple, Generic[LegT]):
    """A chaser with legs.

    Attributes
    ----------
    id, name : str
        Of its packet. The first is a number where there are several: what a reference may say is
        less than what a name may be.
    colour : str or None
        Its own, where there are several.
    legs : tuple
    """

    id: str
    name: str
    colour: str | None
    legs: tuple[LegT, ...]


def crew_of(
    instance: Instance, legs: Sequence[LegT], chaser_of: Callable[[LegT], str | None]
) -> list[ShownChaser[LegT]]:
    """The chasers of some legs."""
    if not several(instance):
        return [ShownChaser("chaser", "chaser", None, tuple(legs))]
    colours, found = chaser_colours(instance), []
    for number, chaser in enumerate(instance.chasers, start=1):
        own = tuple(leg for leg in legs if chaser_of(leg) == chaser.name)
        if own:
            shown = ShownChaser(f"chaser/{number}", chaser.name, colours[chaser.name], own)
            found.append(shown)
    return found


def document(
    clock: UtcClock, name: str, said: Iterable[str], start_s: float, end_s: float
) -> dict[str, Any]:
    """The first packet of a document: its name and its clock."""
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


def arc_packet(
    clock: UtcClock,
    its: ShownChaser[Any],
    leg: tuple[int, str, str],
    number: int,
    arc: Arc,
    span: Span,
    colour: str,
    step_s: float,
) -> dict[str, Any]:
    """The path of an arc while its leg is flown; of a long one the revolution of the chaser.

    Parameters
    ----------
    clock : UtcClock
    its : ShownChaser
    leg : (int, str, str)
        Its number, origin and destination.
    number : int
        Of the arc in its leg.
    arc : Arc
        In the axes of Cesium.
    span : (float, float)
        Begin and end of the leg [s].
    colour : str
        Of the arc, where the chaser has none.
    step_s : float
        Resolution [s].
    """
    at, origin, destination = leg
    title = f"leg {at}: {origin} → {destination}, {arc.phase}"
    shown, drawn_s = span, span[1] - span[0]
    if arc.end_s - arc.start_s > LONG_ARC_S:
        shown = arc.start_s, arc.end_s
        drawn_s = 0.5 * revolution(arc.positions_m[0], arc.velocities_m_s[0])
        position: dict[str, Any] = {"reference": f"{its.id}#position"}
    else:
        position = sampled(clock, arc.times_s, arc.positions_m, ARC_DEGREE, 0)
    width = 2 if arc.phase in ("wait", "service") else 3
    return {
        "id": f"leg {at}/{number}",
        "name": title if its.colour is None else f"{its.name}, {title}",
        "availability": lasting(clock, *shown),
        "position": position,
        "path": path_line(drawn_s, width, step_s, rgba(its.colour or colour)),
    }


def path_line(drawn_s: float, width: int, resolution_s: float, colour: object) -> dict[str, Any]:
    """The line of an arc, shown for some time before and after the chaser passes [s]."""
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
    """Samples at seconds after the first [m], with ``digits`` decimals.

    Parameters
    ----------
    clock : UtcClock
    times : (n,) float64
        Since the epoch, ascending [s].
    positions : (n, 3) float64
        In the axes of the document [m].
    degree : int
        Of the polynomial between samples.
    digits : int
    """
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
