"""Disposal orbits of towed objects: a circle, or a lowered perigee."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Tag

from ..common.records import Length, Record


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
