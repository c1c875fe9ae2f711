"""Stays of chasers at stations."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle

from ...plan.palette import CHASERS
from ...plan.plan import Plan
from ...plan.routes import routes_of
from ...problem.chasers import AtStation
from ...problem.instance import Instance
from .chart import DAYS, Chart, ChartAxis, Line, days


@dataclass(frozen=True)
class Stay:
    """A chaser at a station.

    Attributes
    ----------
    station, chaser : str
    leg : int
        Number of the leg that brings it there; of one that starts there the leg that it leaves by,
        and 0 if it never does.
    since_s, until_s : float
        From docking, or from when it is available, to the first burn of the next leg; to the end of
        refuelling if there is none [s].
    refuelled_s : float or None
        When refuelling ends; None where it starts [s].
    """

    station: str
    chaser: str
    leg: int
    since_s: float
    until_s: float
    refuelled_s: float | None


def stays(instance: Instance, plan: Plan) -> tuple[Stay, ...]:
    """All stays at stations, by station and time.

    Parameters
    ----------
    instance : Instance
    plan : Plan
        Need not be free of violations.

    Raises
    ------
    InputError
        The plan belongs to another instance, or a route to no chaser of it.
    """
    plan.instance.refuse_other(instance)
    found = []
    for flown in routes_of(instance, plan):
        name, start = flown.chaser.name, flown.chaser.start
        if isinstance(start, AtStation):
            since = flown.chaser.available_s[0]
            first, leaves = (
                (flown.legs[0][0], flown.legs[0][1].leaves_s) if flown.legs else (0, since)
            )
            found.append(Stay(start.station, name, first, since, max(since, leaves), None))
        for at, (number, leg) in enumerate(flown.legs):
            if leg.destination in instance.station_names:
                after = flown.legs[at + 1 : at + 2]
                until = max([leg.end_s, *(its.leaves_s for _, its in after)])
                docked = leg.docked_s
                found.append(Stay(leg.destination, name, number, docked, until, leg.end_s))
    order = list(instance.station_names)
    return tuple(sorted(found, key=lambda stay: (order.index(stay.station), stay.since_s)))


def traffic_chart(instance: Instance, plan: Plan) -> Chart:
    """Cumulative refuellings against days, a line for each station with any."""
    lines, every = [], stays(instance, plan)
    for name, colour in zip(instance.station_names, cycle(CHASERS), strict=False):
        ends_s = sorted(
            stay.refuelled_s
            for stay in every
            if stay.station == name and stay.refuelled_s is not None
        )
        if ends_s:
            x = [0.0, *days(ends_s).tolist()]
            lines.append(Line(name=name, colour=colour, step=True, x=x, y=range(len(x))))
    return Chart(tuple(lines), DAYS, ChartAxis("refuellings so far"))


def also_there(stay: Stay, every: tuple[Stay, ...]) -> tuple[str, ...]:
    """Other chasers at the station during a stay."""
    return tuple(
        dict.fromkeys(
            other.chaser
            for other in every
            if other.station == stay.station
            and other.chaser != stay.chaser
            and other.since_s < stay.until_s
            and stay.since_s < other.until_s
        )
    )
