"""Prizes that fall with the end of the service."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated

from pydantic import AfterValidator, Field

LARGEST_PRIZE = 1e12
LEAST_PRIZE = 1e-12
"""Least prize, which keeps sums and quotients of prizes within floating-point range."""


def _is_nothing_or_enough(prize: float) -> float:
    if 0.0 < prize < LEAST_PRIZE:
        raise ValueError(f"must be 0 or at least {LEAST_PRIZE:g}")
    return prize


Prize = Annotated[
    float,
    Field(
        ge=0.0,
        le=LARGEST_PRIZE,
        json_schema_extra={"anyOf": [{"const": 0.0}, {"minimum": LEAST_PRIZE}]},
    ),
    AfterValidator(_is_nothing_or_enough),
]

PrizeUntil = tuple[Annotated[float, Field(ge=0.0)], Prize]
"""A time [s], and the prize of services that end by then."""


def _falls(levels: Sequence[PrizeUntil]) -> Sequence[PrizeUntil]:
    for (before_s, higher), (after_s, lower) in pairwise(levels):
        if after_s <= before_s:
            raise ValueError(f"its times must rise, but {after_s:g} s follows {before_s:g} s")
        if lower > higher:
            raise ValueError(
                f"prizes may only fall with time, but {lower:g} follows {higher:g} after "
                f"{before_s:g} s"
            )
    return levels


PrizesUntil = Annotated[
    tuple[PrizeUntil, ...], Field(strict=False, min_length=1), AfterValidator(_falls)
]
"""Times in ascending order with falling prizes, each of services that end by its time."""


def prize_at(prize: float, levels: Sequence[PrizeUntil], end_s: float) -> float:
    """The prize of a service by its end.

    Parameters
    ----------
    prize : float
        Of services that end after all levels.
    levels : sequence of (float, float)
        Times [s] and prizes.
    end_s : float
        End of the service, with the tow if there is one [s].
    """
    return next((level for until_s, level in levels if end_s <= until_s), prize)
