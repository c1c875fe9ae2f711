"""Refined plans for Cesium: osculating paths, with low thrust in the colour of its windows."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from ...fly.refine.bodies import Whereabouts
from ...fly.refine.ephemeris import EphemerisTrack, tracks
from ...fly.trajectory.axes import Axes
from ...fly.trajectory.clock import UtcClock
from ...fly.trajectory.sampling import LONG_STEP_S, SHORTEST_ARC_S, STEP_S, Arc
from ...plan import palette
from ...plan.phases import COLOURS
from ...plan.refined_plan import RefinedLeg, RefinedPlan
from ...problem.instance import Instance
from .czml_packets import (
    ARC_DEGREE,
    BODY_DEGREE,
    BODY_STEP_S,
    LONG_ARC_S,
    MOST_BODY_STATES,
    ShownChaser,
    arc_packet,
    body_packet,
    chaser_packet,
    crew_of,
    document,
    lasting,
    rgba,
    sampled,
)

HIGHLIGHT_PIXELS = 18


class RefinedLegs(NamedTuple):
    """Some legs of a refined plan, of any chasers; at least one.

    ``bodies`` says where the bodies are.
    """

    refined: RefinedPlan
    legs: Sequence[RefinedLeg]
    bodies: Whereabouts


class _Leg(NamedTuple):
    """A leg with its arcs."""

    leg: RefinedLeg
    tracks: tuple[EphemerisTrack, ...]


def usual_step(legs: Sequence[RefinedLeg]) -> float:
    """Time between states: a minute, or five where some leg takes more than a day [s]."""
    return LONG_STEP_S if any(leg.done_s - leg.ready_s > LONG_ARC_S for leg in legs) else STEP_S


def to_czml(
    instance: Instance, shown: RefinedLegs, axes: Axes, said: Sequence[str], step_s: float
) -> str:
    """Some legs of a refined plan as a CZML document.

    Parameters
    ----------
    instance : Instance
    shown : RefinedLegs
    axes : Axes
        Those of Cesium.
    said : sequence of str
        Sentences that say what the document is of.
    step_s : float
        Largest time between states [s].
    """
    clock, legs = UtcClock(instance), shown.legs
    start_s, end_s = min(leg.ready_s for leg in legs), max(leg.done_s for leg in legs)
    packets = [document(clock, instance.name, said, start_s, end_s)]
    packets += _bodies(instance, shown, axes, clock)
    for its in _crew(instance, shown, step_s):
        packets.append(_chaser(its, axes, clock))
        for leg in its.legs:
            for number, track in enumerate(leg.tracks, start=1):
                packets.append(_arc(its, leg, number, track.arc, axes, clock))
            if _windows(leg.leg):
                packets.append(_thrust(its, leg.leg, clock))
    return json.dumps(packets, ensure_ascii=False, separators=(",", ":"), allow_nan=False) + "\n"


def _crew(instance: Instance, shown: RefinedLegs, step: float) -> list[ShownChaser[_Leg]]:
    """The chasers of some legs."""
    flown = [
        _Leg(leg, tracks(shown.refined, leg=leg.leg, step_s=step, bodies=shown.bodies))
        for leg in shown.legs
    ]
    return crew_of(instance, flown, lambda leg: leg.leg.chaser)


def _bodies(
    instance: Instance, its: RefinedLegs, axes: Axes, clock: UtcClock
) -> Iterator[dict[str, Any]]:
    """Bodies of the legs, shown throughout or, in a long mission, while their legs are flown."""
    legs = its.legs
    part = its.refined.replace(legs=tuple(legs))
    names = list(its.bodies.bodies)
    names = [name for name in names if any(name in (leg.origin, leg.destination) for leg in legs)]
    spans = [(leg.ready_s, leg.done_s) for leg in legs]
    whole = (
        len(names) * (max(end for _, end in spans) - min(start for start, _ in spans))
        <= MOST_BODY_STATES * BODY_STEP_S
    )
    for name in names:
        at_station = name in instance.station_names
        colour = palette.STATION if at_station else palette.VISITED
        own = [leg.leg for leg in legs if name in (leg.origin, leg.destination)]
        shown = {}
        for number in [None] if whole else own:
            for track in tracks(part, body=name, leg=number, step_s=BODY_STEP_S, bodies=its.bodies):
                shown[_span(clock, track.arc)] = sampled(
                    clock, track.arc.times_s, axes.turned(track.arc.positions_m), BODY_DEGREE, 1
                )
        yield body_packet(name, colour, shown, large=at_station, named=True)


def _chaser(its: ShownChaser[_Leg], axes: Axes, clock: UtcClock) -> dict[str, Any]:
    found: dict[str, dict[str, Any]] = {}
    colours: list[tuple[str, str]] = []
    for leg in its.legs:
        for track in leg.tracks:
            arc = track.arc
            found[_span(clock, arc)] = sampled(
                clock, arc.times_s, axes.turned(arc.positions_m), ARC_DEGREE, 3
            )
            colours += _colours(leg.leg, arc, clock)
    start_s, end_s = its.legs[0].tracks[0].arc.start_s, its.legs[-1].tracks[-1].arc.end_s
    shown = lasting(clock, start_s, end_s)
    return chaser_packet(its.id, its.name, its.colour or "#ffffff", shown, found, colours)


def _arc(
    its: ShownChaser[_Leg], leg: _Leg, number: int, arc: Arc, axes: Axes, clock: UtcClock
) -> dict[str, Any]:
    """The path of an arc."""
    turned = replace(arc, positions_m=axes.turned(arc.positions_m))
    span = leg.tracks[0].arc.start_s, leg.tracks[-1].arc.end_s
    ends = leg.leg.leg, leg.leg.origin, leg.leg.destination
    return arc_packet(clock, its, ends, number, turned, span, _colour(leg.leg, arc), STEP_S)


def _thrust(its: ShownChaser[_Leg], leg: RefinedLeg, clock: UtcClock) -> dict[str, Any]:
    """A halo of the chaser, available in the windows of thrust of a leg."""
    halo = rgba(COLOURS["thrust"])
    halo["rgba"][3] = 128
    return {
        "id": f"leg {leg.leg}/thrust",
        "name": f"leg {leg.leg}: {leg.origin} → {leg.destination}, thrust",
        "availability": [lasting(clock, *window) for window in _windows(leg)],
        "position": {"reference": f"{its.id}#position"},
        "point": {"pixelSize": HIGHLIGHT_PIXELS, "color": halo},
    }


def _windows(leg: RefinedLeg) -> tuple[tuple[float, float], ...]:
    """Windows of thrust, those due to rounding left out."""
    windows = () if leg.thrust is None else leg.thrust.windows_s
    return tuple((start, end) for start, end in windows if end - start >= SHORTEST_ARC_S)


def _colours(leg: RefinedLeg, arc: Arc, clock: UtcClock) -> Iterator[tuple[str, str]]:
    """Intervals of an arc with the colours of the chaser's phases."""
    if leg.thrust is None or arc.phase != "transfer":
        yield _span(clock, arc), _colour(leg, arc)
        return
    now = arc.start_s
    for start, end in _windows(leg):
        if start > now:
            yield lasting(clock, now, start), COLOURS["drift"]
        yield lasting(clock, start, end), COLOURS["thrust"]
        now = end
    if arc.end_s > now:
        yield lasting(clock, now, arc.end_s), COLOURS["drift"]


def _colour(leg: RefinedLeg, arc: Arc) -> str:
    """Colour of an arc of a leg."""
    drifts = leg.thrust is not None and arc.phase == "transfer"
    return COLOURS["drift" if drifts else arc.phase]


def _span(clock: UtcClock, arc: Arc) -> str:
    return lasting(clock, arc.start_s, arc.end_s)
