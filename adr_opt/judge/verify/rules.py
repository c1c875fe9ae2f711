"""The verifier's knowledge of rules: unknown rules are refused, not ignored."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from ...common.errors import InputError
from ...common.records import Record
from ...legs.connection_finder import ConnectionFinder
from ...problem.bodies import Station, Target
from ...problem.chasers import Chaser
from ...problem.instance import Instance
from ...problem.settings import MissionSettings

KNOWN: dict[type[Record], frozenset[str]] = {
    Instance: frozenset({
        "format", "name", "epoch", "dynamics", "stations", "targets", "chasers", "mission",
        "transfer", "objective", "keep_out_zones", "frame", "ephemerides",
    }),
    Station: frozenset({
        "name", "orbit", "max_refuellings", "max_propellant_kg", "object_id",
    }),
    Target: frozenset({
        "name", "orbit", "prize", "required", "window_s", "mass_kg", "removal", "object_id",
        "decay_m_per_day", "fit", "prize_until", "success",
    }),
    Chaser: frozenset({
        "name", "start", "available_s", "end", "max_targets", "tank", "kits", "kit_mass_kg",
        "expense", "thrust_n", "duty_cycle",
    }),
    MissionSettings: frozenset({
        "duration_s", "service_revolutions", "service_s", "refuel_revolutions",
        "disposal_altitude_m", "launch_separation_s", "mission_separation_s",
    }),
}  # fmt: skip
"""Fields whose meaning the verifier knows. Those in ``transfer`` make connections, and those in
``objective`` decide between plans with equal prizes. A station's amount of propellant is ignored:
walks may take any; so are the separation of missions and the longest leg, which only forbid plans.
A frame, designators of objects, ephemerides and
what is fitted to them beside orbits change nothing; a decay is in the connections."""

REMOVALS = frozenset({"visit", "kit", "tow"})
"""Kinds of service that the verifier knows."""


def refuse_unknown(instance: Instance) -> None:
    """Refuse an instance whose rules cannot be verified yet.

    Raises
    ------
    InputError
        The sentence says which rule.
    """
    for where, record in _records(instance):
        for field, about in type(record).model_fields.items():
            if field not in KNOWN[type(record)] and getattr(record, field) != about.default:
                raise InputError(f"not yet verifiable: {where} with a field {field}")
    for target in instance.targets:
        if target.removal not in REMOVALS:
            raise InputError(
                f"not yet verifiable: {target.name!r} has the removal {target.removal!r}"
            )


def kept_apart(instance: Instance) -> tuple[Chaser, ...]:
    """The chasers, each available from its earliest possible launch.

    They are launched in the order of the file, each so long after the one before as the instance
    says, whether that one is used or not.
    """
    apart_s, earliest_s, found = instance.mission.launch_separation_s or 0.0, -math.inf, []
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


def _records(instance: Instance) -> Iterator[tuple[str, Record]]:
    """All parts of an instance that contain rules, with their names."""
    yield "an instance", instance
    yield "a mission", instance.mission
    for station in instance.stations:
        yield "a station", station
    for target in instance.targets:
        yield "a target", target
    for chaser in instance.chasers:
        yield "a chaser", chaser
