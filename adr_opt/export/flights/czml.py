"""``.czml``: the mission for Cesium, with station, targets, and the chaser's path by phase."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np

from ...fly.trajectory.axes import Axes, axes_of
from ...fly.trajectory.bodies import body_states
from ...fly.trajectory.clock import UtcClock
from ...fly.trajectory.sampling import SHORTEST_ARC_S, STEP_S, Arc, LegPath, Trajectory
from ...plan.routes import owners
from .czml_packets import (
    ARC_DEGREE,
    BODY_DEGREE,
    BODY_STEP_S,
    CESIUM,
    MOST_BODY_STATES,
    ShownChaser,
    Span,
    arc_packet,
    body_packet,
    chaser_packet,
    crew_of,
    document,
    lasting,
    sampled,
)
from .kvn import origin


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
    whose = owners(trajectory.instance, trajectory.plan)
    crew = crew_of(trajectory.instance, trajectory.legs, lambda leg: whose.get(leg.number))
    packets += [_chaser(trajectory, clock, its) for its in crew]
    for its in crew:
        for leg in its.legs:
            arcs = range(len(leg.arcs))
            packets += [_arc(trajectory, clock, its, leg, number) for number in arcs]
    return json.dumps(packets, ensure_ascii=False, separators=(",", ":"), allow_nan=False) + "\n"


def _turned(trajectory: Trajectory, axes: Axes) -> Trajectory:
    """The flight in other axes; bodies stay in the instance's."""
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
    said = origin(trajectory.instance, trajectory.plan, axes)
    if bodies < len(trajectory.instance.names):
        said.append(
            f"Of {len(trajectory.instance.names)} bodies the {bodies} that legs begin or end at "
            "are shown, each during those legs only, to limit the size of the file."
        )
    start, end = trajectory.start_s, trajectory.end_s
    return document(clock, trajectory.instance.name, said, start, end)


def _body(
    trajectory: Trajectory, clock: UtcClock, axes: Axes, name: str, visited: bool, shown: list[Span]
) -> dict[str, Any]:
    from ...plan import palette

    instance = trajectory.instance
    at_station = name in instance.station_names
    colour = palette.UNVISITED
    if at_station or visited:
        colour = palette.STATION if at_station else palette.VISITED
    tracks = {}
    for start, end in shown:
        times = np.linspace(start, end, 1 + max(8, int(np.ceil((end - start) / BODY_STEP_S))))
        positions = axes.turned(body_states(instance, name, times)[0])
        tracks[lasting(clock, start, end)] = sampled(clock, times, positions, BODY_DEGREE, 1)
    return body_packet(name, colour, tracks, large=at_station, named=at_station or visited)


def _chaser(trajectory: Trajectory, clock: UtcClock, its: ShownChaser[LegPath]) -> dict[str, Any]:
    arcs = [(path, arc) for path in its.legs for arc in path.arcs]
    spans = [(lasting(clock, arc.start_s, arc.end_s), path, arc) for path, arc in arcs]
    tracks = {
        when: sampled(clock, arc.times_s, arc.positions_m, ARC_DEGREE, 3) for when, _, arc in spans
    }
    colours = [(when, _colour(trajectory, path, arc)) for when, path, arc in spans]
    shown = lasting(clock, its.legs[0].arcs[0].start_s, its.legs[-1].arcs[-1].end_s)
    return chaser_packet(its.id, its.name, its.colour or "#ffffff", shown, tracks, colours)


def _arc(
    trajectory: Trajectory, clock: UtcClock, its: ShownChaser[LegPath], leg: LegPath, number: int
) -> dict[str, Any]:
    arc, span = leg.arcs[number], (leg.arcs[0].start_s, leg.arcs[-1].end_s)
    ends = leg.number, leg.leg.origin, leg.leg.destination
    step_s = min(trajectory.step_s, STEP_S)
    colour = _colour(trajectory, leg, arc)
    return arc_packet(clock, its, ends, number + 1, arc, span, colour, step_s)


def _colour(trajectory: Trajectory, path: LegPath, arc: Arc) -> str:
    from ...plan.phases import COLOURS

    phase = arc.phase
    if phase == "service" and path.leg.destination in trajectory.instance.station_names:
        phase = "refuelling"
    return COLOURS[phase]
