"""Numbers of a fit of mean elements to an ephemeris, beyond the elements themselves."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ..common.records import Record

LARGEST_DECAY_M_PER_DAY = 1e5

Decay = Annotated[float, Field(ge=-LARGEST_DECAY_M_PER_DAY, le=LARGEST_DECAY_M_PER_DAY)]
"""Daily decrease of a semi-major axis [m]; negative for an increase."""

Offset = Annotated[tuple[float, float], Field(strict=False)]
"""Vector towards the ascending node and a quarter of a revolution later."""


class Fit(Record):
    """Fitted numbers of a body.

    ``eccentricity_offset``: constant part of the mean eccentricity vector, towards the ascending
    node and a quarter of a revolution later, to which that of the orbit is added; it is the work of
    odd zonal harmonics, above all J3.
    """

    eccentricity_offset: Offset = (0.0, 0.0)
