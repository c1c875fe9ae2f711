"""One rehearsal: a mission flown in a world by a policy (docs/model.md section 13)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

from ...kernels.core.windows import service_begin
from ...kernels.rules.loads import after_service
from ...plan.leg_kinds import leg_kinds
from ...problem.world import DrawnWorld
from .flying_chasers import (
    DRY,
    FAILED,
    GONE,
    LATE,
    REFUELLED,
    SERVICED,
    FlyingChaser,
    Made,
    as_planned,
    beginning,
    full_of,
    refused,
)
from .mission_facts import Hop, MissionFacts
from .tries import TryWorths


class Halt(NamedTuple):
    """A decision to fly no further, with the reason."""

    reason: str


@dataclass
class Situation:
    """The state that a policy sees when a chaser is free.

    Attributes
    ----------
    facts : MissionFacts
    craft : FlyingChaser
        The chaser that decides.
    chasers : tuple of FlyingChaser
        All of them; one that is under way as it will be if the leg goes as planned.
    closed : set of int
        Targets that are serviced, given up, gone, or on the way to which a chaser is.
    """

    facts: MissionFacts
    craft: FlyingChaser
    chasers: tuple[FlyingChaser, ...]
    closed: set[int]


class MissionPolicy(Protocol):
    """Interface of policies, which decide what a free chaser does; one object per rehearsal."""

    def next_leg(self, now: Situation) -> Hop | Halt:
        """The next leg of ``now.craft``; a leg that is refused ends the chaser's route.

        Those are refused that :func:`.flying_chasers.refused` names.
        """
        ...

    def tries_again(self, now: Situation, target: int, tries: int) -> bool:
        """Whether to try again at a target after some failed tries."""
        ...


@dataclass
class FlownMission:
    """A rehearsed mission.

    Attributes
    ----------
    chasers : list of FlyingChaser
        At the end.
    prize : float
    expected : float
        The same without the luck of captures: what the tries made were worth on average.
    serviced : list of int
        In order of the ends of services.
    """

    chasers: list[FlyingChaser]
    prize: float = 0.0
    expected: float = 0.0
    serviced: list[int] = field(default_factory=list)


def rehearsed(
    facts: MissionFacts, world: DrawnWorld, policy: MissionPolicy, kits: tuple[int, ...]
) -> FlownMission:
    """Fly a mission in a world.

    Parameters
    ----------
    facts : MissionFacts
    world : DrawnWorld
    policy : MissionPolicy
    kits : tuple of int
        Aboard of each chaser.
    """
    chasers, planned = list[FlyingChaser](), list[FlyingChaser]()
    for number, what in enumerate(facts.chasers):
        slip = world.slip_s(what.name) if what.is_launched else 0.0
        usable = world.usable_share(what.name, 1)
        since = what.limits.ready
        chasers.append(beginning(facts, number, kits[number], since + slip, usable))
        # As planned: what is known of a chaser until it is free.
        planned.append(beginning(facts, number, kits[number], since, 1.0))
    worths = TryWorths(facts.instance, world.uncertainty)
    return _Rehearsal(facts, world, policy, worths, chasers, planned, set()).flown()


def flown_on(
    now: Situation, world: DrawnWorld, policy: MissionPolicy, worths: TryWorths
) -> FlownMission:
    """Fly the rest of a mission in a world, from a state that a policy sees.

    Legs under way go as planned.

    Parameters
    ----------
    now : Situation
        Left as it is.
    world : DrawnWorld
        Of what has still to happen.
    policy : MissionPolicy
    worths : TryWorths
        Of the same uncertainty.

    Returns
    -------
    FlownMission
        With the prizes of the rest alone.
    """
    chasers, planned = ([craft.copied() for craft in now.chasers] for _ in range(2))
    closed = set(now.closed)
    return _Rehearsal(now.facts, world, policy, worths, chasers, planned, closed).flown()


class _Rehearsal:
    """The state of a rehearsal in progress."""

    def __init__(
        self,
        facts: MissionFacts,
        world: DrawnWorld,
        policy: MissionPolicy,
        worths: TryWorths,
        chasers: list[FlyingChaser],
        planned: list[FlyingChaser],
        closed: set[int],
    ) -> None:
        self._facts, self._world, self._policy = facts, world, policy
        self._worths, self._closed = worths, closed
        self._reopened: list[tuple[float, int]] = []
        self._chasers, self._planned = chasers, planned
        self._flown = FlownMission(chasers)

    def flown(self) -> FlownMission:
        """Fly until no chaser continues."""
        while True:
            free = [craft for craft in self._chasers if not craft.ended]
            if not free:
                self._flown.serviced.sort(key=self._end_of)
                return self._flown
            craft = min(free, key=lambda each: (each.free_s, each.chaser))
            now = self._now(craft)
            chosen = self._policy.next_leg(now)
            if isinstance(chosen, Halt):
                craft.ended = chosen.reason
                continue
            if self._facts.chasers[craft.chaser].is_launched and not craft.made:
                at_s = max(chosen.departure, craft.free_s)
                chosen = chosen._replace(departure=at_s, arrival=at_s)
            reason = refused(self._facts, craft, chosen)
            if chosen.destination in self._closed or chosen.destination == craft.body:
                reason = "rules"
            if reason:
                craft.ended = reason
                continue
            self._fly(now, craft, chosen)

    def _end_of(self, target: int) -> float:
        return next(
            made.end_s
            for craft in self._chasers
            for made in craft.made
            if made.hop.destination == target and made.outcome == SERVICED
        )

    def _now(self, craft: FlyingChaser) -> Situation:
        time = craft.free_s
        for when, target in self._reopened:
            if when <= time:
                self._closed.discard(target)
        self._reopened = [each for each in self._reopened if each[0] > time]
        seen = tuple(
            each
            if each is craft or (each.free_s <= time and not self._is_unknown(each, time))
            else self._planned[each.chaser]
            for each in self._chasers
        )
        return Situation(self._facts, craft, seen, self._closed)

    @staticmethod
    def _is_unknown(craft: FlyingChaser, time: float) -> bool:
        return craft.ended == DRY and bool(craft.made) and craft.made[-1].end_s > time

    def _fly(self, now: Situation, craft: FlyingChaser, hop: Hop) -> None:
        """Fly a leg with the cost and the stay that the world draws."""
        facts, world, j = self._facts, self._world, hop.destination
        what, kind = facts.chasers[craft.chaser], leg_kinds()[hop.family].name
        origin, ready = craft.body, craft.free_s
        self._planned[craft.chaser] = as_planned(facts, craft, hop)
        name = facts.names[j]
        if j < facts.stations:
            visit = craft.refuellings.get(j, 0) + 1
            factor = world.station_factor(kind, what.name, name, visit)
            craft.refuellings[j] = visit
        else:
            factor = world.leg_factor(kind, name)
            self._closed.add(j)
        cost = factor * hop.delta_v
        craft.body, craft.towed = j, False
        untowed: float | None = None

        def made(end: float, outcome: str, tries: int = 0) -> None:
            stay = end, craft.free_s, craft.left, craft.left if untowed is None else untowed
            craft.made.append(Made(origin, hop, ready, cost, *stay, outcome, tries))

        if cost > craft.left:
            cost, craft.left, craft.ended = craft.left, 0.0, DRY
            craft.free_s = hop.arrival
            made(hop.arrival, DRY)
            if j >= facts.stations:
                self._reopened.append((hop.arrival, j))
            return
        craft.left -= cost
        begin = float(service_begin(what.limits.windows, j, hop.arrival))
        if j < facts.stations:
            craft.filling += 1
            untowed = craft.left
            usable = world.usable_share(what.name, craft.filling)
            craft.left, craft.since = usable * full_of(what, craft.kits), 0
            craft.free_s = begin + float(what.limits.service[j])
            made(craft.free_s, REFUELLED)
            return
        craft.since += 1
        if world.is_gone(name):
            craft.free_s = begin
            self._flown.expected += self._worths.on_arrival(j, gone=True)
            made(begin, GONE)
            return
        self._flown.expected += self._worths.on_arrival(j, gone=False)
        tow_s = facts.tow_s.get(j, 0.0)
        took = world.service_s(name, float(what.limits.service[j]) - tow_s)
        left, kits = craft.left, craft.kits
        if what.loads is not None:
            left, kits = after_service(what.loads, j, craft.kits, craft.left)
        tries, end = 0, begin
        while True:
            tries, end = tries + 1, end + took
            if end + tow_s > what.limits.duration:
                craft.free_s, craft.ended = end, LATE
                made(end, LATE, tries)
                return
            if left < 0.0:  # not enough to tow it after a dear leg
                craft.free_s, craft.ended = end, DRY
                made(end, DRY, tries)
                return
            caught = world.succeeds(name, tries)
            self._flown.expected += self._worths.of_try(j, tries, caught=caught)
            if caught:
                break
            again = float(service_begin(what.limits.windows, j, end))
            more = tries < world.uncertainty.tries_of(name) and again < math.inf
            craft.free_s = end
            if not (more and self._policy.tries_again(now, j, tries)):
                made(end, FAILED, tries)
                return
            end = again
        untowed = craft.left
        craft.left, craft.kits = float(left), int(kits)
        craft.serviced += 1
        craft.towed = j in facts.tow_s
        craft.free_s = end + tow_s
        self._flown.prize += facts.prizes[j]
        self._flown.serviced.append(j)
        made(end, SERVICED, tries)
