"""Policies that follow a plan."""

from __future__ import annotations

from collections.abc import Sequence

from ...problem.uncertainty import Uncertainty
from .flight import Halt, Situation
from .flying_chasers import FINISHED, refused
from .intended import Intended, PlannedHop
from .mission_facts import Hop, MissionFacts


class Follow:
    """Follows the plan: its connections, or the next ones if the chaser is late.

    A chaser that is late takes the best connection to the same body by the value of time. Its
    route ends before the first leg that it cannot pay or that would end too late.
    """

    def __init__(
        self, facts: MissionFacts, intended: Intended, uncertainty: Uncertainty, seed: int = 0
    ) -> None:
        self._routes = intended.routes
        self._next = [0] * len(intended.routes)

    def next_leg(self, now: Situation) -> Hop | Halt:
        """The planned leg, or a later connection to the same body."""
        chaser = now.craft.chaser
        at = self._next[chaser]
        if at == len(self._routes[chaser]):
            return Halt(FINISHED)
        self._next[chaser] = at + 1
        found = planned_hop(now, self._routes[chaser], at)
        return Halt("duration") if found is None else found

    def tries_again(self, now: Situation, target: int, tries: int) -> bool:
        """Tries again as often as allowed."""
        return True


class Skip(Follow):
    """Follows the plan, and leaves out targets that it cannot afford or reach in time."""

    def next_leg(self, now: Situation) -> Hop | Halt:
        """The leg to the first planned body that can still be visited."""
        craft, chaser = now.craft, now.craft.chaser
        reason = FINISHED
        for at in range(self._next[chaser], len(self._routes[chaser])):
            self._next[chaser] = at + 1
            found = planned_hop(now, self._routes[chaser], at)
            if found is None:
                reason = "duration"
            elif found.destination != craft.body:
                why = refused(now.facts, craft, found)
                if not why:
                    return found
                if why != "rules":  # a station after targets that were left out, which had reasons
                    reason = why
        return Halt(reason)


def planned_hop(now: Situation, route: Sequence[PlannedHop], at: int) -> Hop | None:
    """A planned leg if the chaser is at its start in time, else the best connection."""
    craft, planned = now.craft, route[at]
    if craft.body == planned.origin and craft.towed == planned.towed:
        launches = now.facts.chasers[craft.chaser].is_launched and not craft.made
        if launches or planned.departs(craft.free_s):
            return planned.hop
    return now.facts.best(craft.body, planned.hop.destination, craft.free_s, towed=craft.towed)
