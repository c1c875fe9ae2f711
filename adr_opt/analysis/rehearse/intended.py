"""The plan of a rehearsal: the planned connections of each chaser."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from ...common.constants import SLACK_S
from ...common.errors import InputError
from ...kernels.rules.loads import most_kits
from ...plan.cargo import kits_of
from ...plan.plan import Leg, Plan
from ...plan.routes import routes_of
from ...problem.chasers import Chaser
from .mission_facts import ChaserLimits, Hop, MissionFacts


class PlannedHop(NamedTuple):
    """A planned leg, with its start."""

    origin: int
    towed: bool
    hop: Hop

    def departs(self, free_s: float) -> bool:
        """Whether a chaser that is free at a time can fly the leg."""
        return self.hop.departure >= free_s - SLACK_S


Route = tuple[PlannedHop, ...]


@dataclass(frozen=True)
class Intended:
    """Planned legs of each chaser, in the order of the instance.

    Attributes
    ----------
    plan : Plan or None
    routes : tuple of tuple of PlannedHop
    kits : tuple of int
        Aboard at the start.
    """

    plan: Plan | None
    routes: tuple[Route, ...]
    kits: tuple[int, ...]

    @cached_property
    def targets(self) -> frozenset[int]:
        """Bodies that the plan leads to."""
        return frozenset(each.hop.destination for route in self.routes for each in route)


def intended(facts: MissionFacts, plan: Plan) -> Intended:
    """The plan as connections.

    Raises
    ------
    InputError
        It is of another instance, or of another model.
    """
    instance = facts.instance
    if plan.instance.sha256 != instance.sha256:
        raise InputError("the plan belongs to another instance; give the one it was made for")
    if plan.has_former_drifts:
        raise InputError("the plan has drift legs of a former model; plan again")
    flown = {each.chaser.name: each for each in routes_of(instance, plan)}
    routes, kits = list[Route](), list[int]()
    for what in facts.chasers:
        legs = [leg for _, leg in flown[what.name].legs]
        names = [leg.destination for leg in legs]
        routes.append(hops_of(facts, legs, what.start, towed=False))
        kits.append(_aboard(what, instance.chasers[len(kits)], kits_of(instance, names)))
    return Intended(plan, tuple(routes), tuple(kits))


def _aboard(what: ChaserLimits, chaser: Chaser, planned: int) -> int:
    """Kits aboard: those of the plan, or the maximum if they weigh nothing."""
    most = int(most_kits(what.loads))
    return min(planned, most) if chaser.kit_mass_kg > 0.0 else most


def hops_of(facts: MissionFacts, legs: Sequence[Leg], start: int, *, towed: bool) -> Route:
    """Legs of a plan from a body as connections."""
    found, body = [], start
    for leg in legs:
        hop = facts.of_leg(leg, body, towed=towed)
        found.append(PlannedHop(body, towed, hop))
        body, towed = hop.destination, hop.destination in facts.tow_s
    return tuple(found)
