"""The bodies of an instance that a chaser goes to: stations and targets."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from .orbit import Orbit
from .records import Name, Positive, Record, Window, check_window, not_yet

LARGEST_PRIZE = 1e12
LEAST_PRIZE = 1e-12
"""Prizes are summed and divided: far beyond any use, and near enough for arithmetic to hold."""


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

Removal = Annotated[
    Literal["visit", "kit"], not_yet(lambda word: word == "tow", 'write "visit" or "kit"')
]


class Station(Record):
    """Where chasers refuel, and may start; it may have no orbit where connections are given."""

    name: Name
    orbit: Orbit | None = None


class Target(Record):
    """A debris object that may be visited, and what servicing it is worth.

    Its service begins not before ``window_s`` opens and ends before it closes. ``required``: a plan
    has to service it. ``removal`` "kit": the chaser leaves a kit with it, and goes on without.
    ``mass_kg`` is for what carries it. It may have no orbit where connections are given.
    """

    name: Name
    orbit: Orbit | None = None
    prize: Prize = 1.0
    required: bool = False
    window_s: Window = (0.0, None)
    mass_kg: Positive | None = None
    removal: Removal = "visit"

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        check_window("window_s", self.window_s)
        return self
