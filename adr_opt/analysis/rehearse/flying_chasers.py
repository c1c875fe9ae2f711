"""Chasers in a rehearsal: their position, resources and flown legs."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

from ...common.constants import SLACK_S
from ...kernels.core.windows import service_begin
from ...kernels.rules.loads import after_service, first_tank, full_tank
from ...problem.world import OUTCOMES
from .mission_facts import ChaserLimits, Hop, MissionFacts

SERVICED, REFUELLED, FAILED, GONE, LATE, DRY = OUTCOMES
"""Outcomes of a leg; the last four are losses."""

FINISHED = "finished"
"""Reason of a chaser that has completed its plan."""


class Made(NamedTuple):
    """A leg as flown, with the stay after it.

    Attributes
    ----------
    origin : int
    hop : Hop
    ready_s : float
        Since when the chaser was free [s].
    delta_v : float
        What it took [m/s].
    end_s, free_s : float
        End of the service or of the last try, and of a tow after it [s].
    left : float
        ΔV left then [m/s].
    untowed : float
        ΔV left on arrival, before a tow or refuelling [m/s].
    outcome : str
        One of the names above.
    tries : int
    """

    origin: int
    hop: Hop
    ready_s: float
    delta_v: float
    end_s: float
    free_s: float
    left: float
    untowed: float
    outcome: str
    tries: int = 0


@dataclass(slots=True)
class FlyingChaser:
    """A chaser at a moment of a rehearsal.

    Attributes
    ----------
    chaser : int
    body : int
        Where it is, or is going to be.
    towed : bool
        Whether it is on the disposal orbit of that object.
    free_s : float
        Since when it is free there [s].
    left : float
        ΔV left, with the slack of a tank [m/s].
    kits : int
        Aboard.
    since : int
        Targets come to since the last refuelling.
    serviced : int
    filling : int
        Number of its tank, from 1.
    refuellings : dict of int to int
        Legs to each station so far.
    made : list of Made
    ended : str
        Why it flies no more; empty if it does.
    """

    chaser: int
    body: int
    towed: bool
    free_s: float
    left: float
    kits: int
    since: int = 0
    serviced: int = 0
    filling: int = 1
    refuellings: dict[int, int] = field(default_factory=dict)
    made: list[Made] = field(default_factory=list)
    ended: str = ""

    def copied(self) -> FlyingChaser:
        """A copy that shares no mutable data."""
        return replace(self, refuellings=dict(self.refuellings), made=list(self.made))


def beginning(
    facts: MissionFacts, chaser: int, kits: int, since_s: float, usable: float
) -> FlyingChaser:
    """A chaser before its first leg.

    Parameters
    ----------
    facts : MissionFacts
    chaser : int
    kits : int
        Aboard.
    since_s : float
        When it may fly [s].
    usable : float
        Share of its first tank that can be used.
    """
    what = facts.chasers[chaser]
    full = full_of(what, kits)
    left = (full if what.loads is None else float(first_tank(what.loads, full, kits))) - what.spent
    return FlyingChaser(chaser, what.start, False, since_s, left - (1.0 - usable) * full, kits)


def full_of(what: ChaserLimits, kits: int) -> float:
    """ΔV of a full tank with kits aboard, with the slack [m/s]."""
    return what.budget if what.loads is None else float(full_tank(what.loads, what.budget, kits))


def refused(facts: MissionFacts, craft: FlyingChaser, hop: Hop) -> str:
    """Why a leg may not begin, judged by its planned values; empty if it may.

    ``delta-v``: the tank does not hold what it is planned to take, or what follows; ``duration``:
    its service would end late; ``late``: it departs before the chaser is free; ``capacity``: no
    kit, or enough targets; ``rules`` where no plan has such a leg.
    """
    what, j = facts.chasers[craft.chaser], hop.destination
    if hop.departure < craft.free_s - SLACK_S and not (what.is_launched and not craft.made):
        return "late"
    limits = what.limits
    if not service_begin(limits.windows, j, hop.arrival) + limits.service[j] <= limits.duration:
        return "duration"
    if hop.delta_v > craft.left:
        return "delta-v"
    if j < facts.stations:
        return "" if craft.since > 0 else "rules"
    if what.most_targets is not None and craft.serviced >= what.most_targets:
        return "capacity"
    if what.loads is not None:
        left, kits = after_service(what.loads, j, craft.kits, craft.left - hop.delta_v)
        if kits < 0:
            return "capacity"
        if left < 0.0:
            return "delta-v"
    return ""


def as_planned(facts: MissionFacts, craft: FlyingChaser, hop: Hop) -> FlyingChaser:
    """The chaser after a leg that goes as planned, with the stay after it."""
    what, j, planned = facts.chasers[craft.chaser], hop.destination, craft.copied()
    begin = float(service_begin(what.limits.windows, j, hop.arrival))
    planned.body, planned.towed = j, j in facts.tow_s
    planned.free_s = begin + float(what.limits.service[j])
    planned.left = untowed = craft.left - hop.delta_v
    if j < facts.stations:
        planned.left, planned.since = full_of(what, craft.kits), 0
        planned.filling += 1
    else:
        planned.since, planned.serviced = craft.since + 1, craft.serviced + 1
        if what.loads is not None:
            left, kits = after_service(what.loads, j, craft.kits, planned.left)
            planned.left, planned.kits = max(float(left), 0.0), int(kits)
    outcome = REFUELLED if j < facts.stations else SERVICED
    end_s = planned.free_s - facts.tow_s.get(j, 0.0)
    planned.made.append(
        Made(
            craft.body,
            hop,
            craft.free_s,
            hop.delta_v,
            end_s,
            planned.free_s,
            planned.left,
            untowed,
            outcome,
        )
    )
    return planned
