"""Disposal orbits of towed objects: a circle, or a lowered perigee."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Tag

from ..common.constants import EARTH_RADIUS_M
from ..common.records import Length, Record

CONTROLLED_M = 60e3
"""Highest perigee from which an object re-enters at once, where its burn was aimed: below it the
air holds back any object within a revolution. Usual plans of controlled re-entry aim at 0 to 60 km
(ESSB-HB-U-002, ESA space debris mitigation compliance verification guidelines)."""


def comes_down_at_once(perigee_m: float) -> bool:
    """Whether an object with a perigee radius re-enters in its first revolution [m]."""
    return perigee_m <= EARTH_RADIUS_M + CONTROLLED_M


class DisposalCircle(Record):
    """A disposal orbit: the circle of an altitude."""

    circle_m: Length


class DisposalPerigee(Record):
    """A disposal orbit: the perigee is lowered to an altitude, and the apogee stays."""

    perigee_m: Length


def _kind_of_disposal(given: Any) -> str | None:
    stated = set(given) if isinstance(given, dict) else set(getattr(given, "model_fields_set", ()))
    return {("circle_m",): "(circle)", ("perigee_m",): "(perigee)"}.get(tuple(sorted(stated)))


Disposal = Annotated[
    Annotated[DisposalCircle, Tag("(circle)")] | Annotated[DisposalPerigee, Tag("(perigee)")],
    Discriminator(
        _kind_of_disposal,
        custom_error_type="disposal",
        custom_error_message='must be {"circle_m": ALTITUDE} or {"perigee_m": ALTITUDE}',
    ),
]
"""Where a towed object is released."""
