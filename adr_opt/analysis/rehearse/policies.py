"""Policies by name, and those that keep to a plan.

A policy of another package is an entry point of the group ``adr_opt.rehearsal_policies``: a
callable that takes a :class:`.ground.Ground`, a :class:`.intended.Intended` and a seed, and gives a
:class:`.flight.Policy` for one rehearsal.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.metadata import entry_points

from ...common.errors import InputError
from ...common.packages import load
from .crafts import FINISHED, refused
from .flight import Policy, Situation, Stop
from .ground import Ground, Hop
from .intended import Intended, Route
from .replanning import AtDeviations, AtEveryService

ENTRY_POINTS = "adr_opt.rehearsal_policies"

PolicyMaker = Callable[[Ground, Intended, int], Policy]


class Follow:
    """Keeps to the plan: its connections, or the next ones where the chaser is late.

    A chaser that is late takes the best connection to the same body by the value of time. Its
    route ends before the first leg that it cannot pay or that would end too late.
    """

    def __init__(self, ground: Ground, intended: Intended, seed: int = 0) -> None:
        self._routes = intended.routes
        self._next = [0] * len(intended.routes)

    def next_leg(self, now: Situation) -> Hop | Stop:
        """The planned leg, or a later connection to the same body."""
        chaser = now.craft.chaser
        at = self._next[chaser]
        if at == len(self._routes[chaser]):
            return Stop(FINISHED)
        self._next[chaser] = at + 1
        found = planned_hop(now, self._routes[chaser], at)
        return Stop("duration") if found is None else found

    def tries_again(self, now: Situation, target: int, tries: int) -> bool:
        """As often as it is allowed."""
        return True


class Skip(Follow):
    """Keeps to the plan, and leaves out what it cannot pay or reach in time."""

    def next_leg(self, now: Situation) -> Hop | Stop:
        """The leg to the first planned body that can still be visited."""
        craft, chaser = now.craft, now.craft.chaser
        reason = FINISHED
        for at in range(self._next[chaser], len(self._routes[chaser])):
            self._next[chaser] = at + 1
            found = planned_hop(now, self._routes[chaser], at)
            if found is None:
                reason = "duration"
            elif found.destination != craft.body:
                why = refused(now.ground, craft, found)
                if not why:
                    return found
                reason = why
        return Stop(reason)


def planned_hop(now: Situation, route: Route, at: int) -> Hop | None:
    """A planned leg if the chaser is where it begins and in time, else the best one there is."""
    craft, planned = now.craft, route[at]
    if craft.body == planned.origin and craft.towed == planned.towed:
        launches = now.ground.chasers[craft.chaser].is_launched and not craft.made
        if launches or planned.departs(craft.free_s):
            return planned.hop
    return now.ground.best(craft.body, planned.hop.destination, craft.free_s, towed=craft.towed)


BUILT_IN: Mapping[str, PolicyMaker] = {
    "follow": Follow, "skip": Skip, "replan": AtDeviations, "beam": AtEveryService,
}  # fmt: skip

NEED_PLAN = frozenset({"follow", "skip"})
"""Policies that keep to a plan that is given."""


def policy_of(name: str) -> PolicyMaker:
    """The policy of a name.

    Raises
    ------
    InputError
        There is none.
    """
    if name in BUILT_IN:
        return BUILT_IN[name]
    others = {entry.name: entry for entry in entry_points(group=ENTRY_POINTS)}
    if name not in others:
        known = ", ".join(sorted({*BUILT_IN, *others}))
        raise InputError(f"policy {name!r} is unknown; use one of: {known}")
    made: PolicyMaker = load(others[name])
    return made
