"""A plan as phases: activities of the chaser with start and end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from ...legs.service_limits import service_begins
from ...plan.plan import Leg, LowThrustArc, Plan
from ...problem.instance import Instance


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
    for burn, after in pairwise(leg.burns):
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
