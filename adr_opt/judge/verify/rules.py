"""The verifier's knowledge of rules."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from ...legs.connection_finder import ConnectionFinder
from ...problem.chasers import Chaser
from ...problem.instance import Instance
from ...problem.rules import JUDGED, Follower

FOLLOWS = Follower("verify", JUDGED)
"""A station's amount of propellant is ignored: walks may take any; so are the separation of
missions and the longest leg, which only forbid plans."""


def kept_apart(instance: Instance) -> tuple[Chaser, ...]:
    """The chasers, each available from its earliest possible launch.

    Where the instance gives an interval, they are launched in the order of the file, each so long
    after the one before, whether that one is used or not. Otherwise no launch waits for another.
    """
    apart_s, earliest_s, found = instance.mission.launch_separation_s, -math.inf, []
    if apart_s is None:
        return instance.chasers
    for chaser in instance.chasers:
        since, until = chaser.available_s
        if chaser.is_launched:
            since = max(since, earliest_s)
            earliest_s = since + apart_s
        # Not validated once more: the available time of a chaser launched too late may be empty.
        found.append(chaser.model_copy(update={"available_s": (since, until)}))
    return tuple(found)


def finders_of(
    instance: Instance, names: Collection[str], connecting: ConnectionFinder
) -> Iterator[tuple[Chaser, ConnectionFinder]]:
    """Chasers of some names with their connections, one of those that differ in their names alone.

    Each is available from its earliest possible launch, as :func:`kept_apart` has it.
    """
    seen = []
    for number, chaser in enumerate(kept_apart(instance)):
        alike = chaser.model_copy(update={"name": ""})
        if chaser.name not in names or alike in seen:
            continue
        if instance.given is None:  # given connections lead from a start by its name
            seen.append(alike)
        yield chaser, connecting.of_chaser(number)
