"""Rules between the parts of an instance; each raises ``ValueError`` and names the field."""

from __future__ import annotations

from collections.abc import Sequence

from .bodies import Station, Target
from .chasers import AtStation, Chaser
from .settings import MissionSettings


def check_names(
    stations: Sequence[Station], targets: Sequence[Target], chasers: Sequence[Chaser]
) -> None:
    """All bodies and chasers have names of their own."""
    seen = set()
    named: tuple[tuple[str, Sequence[Station | Target | Chaser]], ...] = (
        ("stations", stations), ("targets", targets), ("chasers", chasers),
    )  # fmt: skip
    for field, them in named:
        for number, one in enumerate(them):
            if one.name in seen:
                raise ValueError(
                    f"field {field}[{number}].name = {one.name!r}: another body has this name; "
                    "give each its own"
                )
            seen.add(one.name)


def check_stations(stations: Sequence[Station], chasers: Sequence[Chaser]) -> None:
    """Chasers start and end at stations that there are."""
    known = [station.name for station in stations]
    for number, chaser in enumerate(chasers):
        for field in ("start", "end"):
            place = getattr(chaser, field)
            if isinstance(place, AtStation) and place.station not in known:
                listed = ", ".join(map(repr, known)) or "there is none"
                raise ValueError(
                    f"field chasers[{number}].{field}.station = {place.station!r}: unknown "
                    f"station; name one of the stations: {listed}"
                )


def check_orbits(
    stations: Sequence[Station],
    targets: Sequence[Target],
    mission: MissionSettings,
    *,
    is_given: bool,
) -> None:
    """All bodies have an orbit where it is asked for: not where connections are given."""
    fields: tuple[tuple[str, Sequence[Station | Target], str, str], ...] = (
        ("stations", stations, "refuel_revolutions", "write 0.0"),
        ("targets", targets, "service_revolutions", "give service_s instead"),
    )
    for field, bodies, time, instead in fields:
        for number, body in enumerate(bodies):
            if body.orbit is not None:
                continue
            if not is_given:
                raise ValueError(f"field {field}[{number}].orbit: missing; add it")
            stated = getattr(mission, time)
            if stated:
                raise ValueError(
                    f"field mission.{time} = {stated!r}: {body.name!r} has no orbit and so no "
                    f"period; {instead}"
                )
