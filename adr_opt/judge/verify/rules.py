"""The verifier's knowledge of rules."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from ...legs.connection_finder import ConnectionFinder
from ...problem.chasers import Chaser
from ...problem.instance import Instance
from ...problem.rules import JUDGED, Follower
from ..check.shared import launch_times

FOLLOWS = Follower("verify", JUDGED)
"""A station's amount of propellant is ignored: walks may take any; so are the separation of
missions and the longest leg, which only forbid plans."""


def kept_apart(instance: Instance) -> tuple[Chaser, ...]:
    """The chasers, each available from its earliest possible launch."""
    launches, found = launch_times(instance), []
    for chaser in instance.chasers:
        since, until = chaser.available_s
        # Not validated once more: the available time of a chaser launched too late may be empty.
        available = launches.get(chaser.name, since), until
        found.append(chaser.model_copy(update={"available_s": available}))
    return tuple(found)


def finders_of(
    instance: Instance, names: Collection[str], connecting: ConnectionFinder
) -> Iterator[tuple[Chaser, ConnectionFinder]]:
    """The named chasers with their connections, one for each group that differs only in name.

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
