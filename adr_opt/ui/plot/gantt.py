"""A plan as phases, and its timeline as a Gantt chart."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ...legs.service_limits import service_begins
from ...plan.phases import COLOURS, LABELS, PHASES
from ...plan.plan import Leg, LowThrustArc, Plan
from ...plan.routes import routes_of, several
from ...problem.instance import Instance
from .chart import DAYS, Bars, Chart, ChartAxis, days, draw


@dataclass(frozen=True)
class Segment:
    """One phase of one leg.

    Attributes
    ----------
    leg : int
        Number of the leg, from 1.
    phase : str
        One of :data:`.PHASES`.
    start_s, end_s : float
        Times since the epoch [s].
    """

    leg: int
    phase: str
    start_s: float
    end_s: float

    @property
    def duration_s(self) -> float:
        """Duration of the phase [s]."""
        return self.end_s - self.start_s


def segments(instance: Instance, plan: Plan) -> tuple[Segment, ...]:
    """Phases of a plan in time order, without those of zero duration.

    Read off the plan as it is: a burn begins its phase, which lasts until the next burn; without
    burns, where connections are given, the transfer is one phase. A leg of low thrust has two arcs
    of thrust and the drift orbit in between. A chaser that has docked before a window opens, or
    before the stated arrival, waits at its destination; so does one that tows it, and the next leg
    follows upon the tow without a wait.

    Parameters
    ----------
    instance : Instance
    plan : Plan
        Need not be free of violations.
    """
    plan.instance.refuse_other(instance)
    found: list[Segment] = []
    number = 0
    for route in plan.routes:
        waits = True
        for leg in route.legs:
            number += 1
            found += _of_leg(instance, number, leg, waits=waits)
            waits = leg.tow is None
    return tuple(segment for segment in found if segment.duration_s > 0.0)


def _of_leg(instance: Instance, number: int, leg: Leg, *, waits: bool) -> Iterator[Segment]:
    begins = service_begins(instance, leg)
    stay = "refuelling" if leg.destination in instance.station_names else "service"
    if waits and not leg.traits.from_nowhere:
        yield Segment(number, "wait", leg.ready_s, leg.leaves_s)
    for burn, after in pairwise(leg.impulses):
        yield Segment(number, burn.phase, burn.time_s, after.time_s)
    if leg.manoeuvres is not None and len(leg.manoeuvres) == 2:
        yield from _of_thrust(number, leg, *leg.manoeuvres)
    elif not (leg.traits.has_burns or leg.traits.from_nowhere):
        yield Segment(number, "transfer", leg.leaves_s, leg.docked_s)
    yield Segment(number, "wait", leg.docked_s, begins)
    yield Segment(number, stay, begins, leg.end_s)
    if leg.tow is not None:
        yield Segment(number, "wait", leg.end_s, leg.tow.start_s)
        yield Segment(number, "tow", leg.tow.start_s, leg.tow.end_s)


def _of_thrust(
    number: int, leg: Leg, first: LowThrustArc, second: LowThrustArc
) -> Iterator[Segment]:
    yield Segment(number, "thrust", first.start_s, first.end_s)
    yield Segment(number, "drift", first.end_s, second.start_s)
    yield Segment(number, "thrust", second.start_s, second.end_s)
    yield Segment(number, "approach", second.end_s, leg.docked_s)


def phase_bars(found: Iterable[Segment], row_of: Callable[[int], int]) -> list[Bars]:
    """Segments of each phase as bars, in the row of their leg."""
    of_phase: dict[str, list[Segment]] = {phase: [] for phase in PHASES}
    for segment in found:
        of_phase[segment.phase].append(segment)
    return [
        Bars(
            name=LABELS[phase],
            colour=COLOURS[phase],
            phase=phase,
            of=bars,
            legs=[bar.leg for bar in bars],
            x=days([bar.start_s for bar in bars]),
            y=[row_of(bar.leg) for bar in bars],
            lengths=days([bar.duration_s for bar in bars]),
        )
        for phase, bars in of_phase.items()
        if bars
    ]


WINDOWS, WINDOW_COLOUR, WINDOW_SHARE = "may be captured", "#e9d9a0", 0.96
"""Bands behind the phases, a little wider."""


def window_bars(instance: Instance, plan: Plan, row_of: Callable[[int], int]) -> Iterator[Bars]:
    """Windows of targets, clipped to the duration of their leg."""
    limited = {
        target.name: instance.intervals_of(target)
        for target in instance.targets
        if instance.is_limited(target)
    }
    found = [
        Segment(number, WINDOWS, max(opens, leg.leaves_s), min(closes, leg.end_s))
        for number, leg in enumerate(plan.legs, start=1)
        for opens, closes in limited.get(leg.destination, np.empty((0, 2))).tolist()
        if opens < leg.end_s and closes > leg.leaves_s
    ]
    if found:
        yield Bars(
            name=WINDOWS,
            colour=WINDOW_COLOUR,
            of=found,
            legs=[band.leg for band in found],
            x=days([band.start_s for band in found]),
            y=[row_of(band.leg) for band in found],
            lengths=days([band.duration_s for band in found]),
            share=WINDOW_SHARE,
        )


def gantt_chart(instance: Instance, plan: Plan, *, headed: bool) -> Chart:
    """One row per leg, named by its destination, first on top, with a bar for each phase.

    Behind them are bands of the windows of the target.

    Parameters
    ----------
    instance : Instance
    plan : Plan
    headed : bool
        Whether the legs of each of several chasers come below a row with its name; otherwise the
        name stands before the destination of its first leg.
    """
    rows: list[str] = []
    headings: list[int] = []
    row_of: dict[int, int] = {}
    for flown in routes_of(instance, plan):
        who = flown.chaser.name if several(instance) else ""
        if who and headed:
            rows.append(who)
            headings.append(len(rows))
        for at, (number, leg) in enumerate(flown.legs):
            is_named = who and not headed and at == 0
            rows.append(f"{who}: {leg.destination}" if is_named else leg.destination)
            row_of[number] = len(rows)
    bars = phase_bars(segments(instance, plan), row_of.__getitem__)
    bands = window_bars(instance, plan, row_of.__getitem__)
    return Chart(
        (*bands, *bars), DAYS, ChartAxis("destination", rows=tuple(rows), headings=tuple(headings))
    )


def gantt(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add one row per leg, first on top, with its phases as bars against time [days].

    Where there are several chasers, the first leg of each has its name beside the destination.

    Raises
    ------
    InputError
        The plan belongs to another instance.
    """
    return draw(ax, gantt_chart(instance, plan, headed=False))
