"""Bodies of an instance that chasers visit: stations and targets.

A target has a prize, which may fall with the end of its service, and needs a kind of service, which
may take a kit or a flight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, ClassVar, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from ..common.records import LARGEST_MASS_KG, Count, Name, Omitting, Window, check_window
from .capture_windows import intervals_of, joined, windows_from
from .disposal import Disposal
from .orbit import Decay, Fit, Orbit


@dataclass(frozen=True)
class ServiceKind:
    """A kind of service.

    Attributes
    ----------
    name : str
        What instances call it, as ``removal`` of a target.
    counted : str
        What of it may make loads count, as a word; empty if nothing does.
    takes_kit : bool
        Whether the chaser leaves a kit with the object.
    is_flown : bool
        Whether the chaser carries the object away afterwards; how is for :mod:`adr_opt.plan.tows`
        to say.
    """

    name: str
    counted: str = ""
    takes_kit: bool = False
    is_flown: bool = False


SERVICES = {
    kind.name: kind
    for kind in (
        ServiceKind("visit"),
        ServiceKind("kit", "kits", takes_kit=True),
        ServiceKind("tow", "tows", is_flown=True),
    )
}
"""All kinds by name."""


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


LARGEST_AREA_TO_MASS = 1e3
"""Largest ratio of area to mass of an object [m²/kg]."""

ObjectId = Annotated[str, Field(pattern=r"^[!-~]([ -~]*[!-~])?$", max_length=80)]
"""Object identifier as in CCSDS messages: printable ASCII, mostly like ``1997-051C``."""

Removal = Literal["visit", "kit", "tow"]


class Station(Omitting):
    """A refuelling station, where chasers may start.

    Every arrival of a chaser refuels it, also at the end of its route.

    Attributes
    ----------
    name : str
    orbit : Orbit or None
        None only where connections are given.
    max_refuellings : int or None
        Maximum number of refuellings, of all chasers together.
    max_propellant_kg : float or None
        Propellant that it gives out at most, to all chasers together [kg].
    object_id : str or None
        International designator, for exports.
    """

    name: Name
    orbit: Orbit | None = None
    max_refuellings: Count | None = None
    max_propellant_kg: Annotated[float, Field(ge=0.0, le=LARGEST_MASS_KG)] | None = None
    object_id: ObjectId | None = None

    @property
    def is_limited(self) -> bool:
        """Whether the station's supply of propellant or refuellings is limited."""
        return self.max_refuellings is not None or self.max_propellant_kg is not None

    OMITTED: ClassVar = ("max_refuellings", "max_propellant_kg", "object_id")


class Target(Omitting):
    """A debris object that may be visited, and the prize for servicing it.

    Attributes
    ----------
    name : str
    orbit : Orbit or None
        None only where connections are given.
    prize : float
    required : bool
        Whether every plan must service it.
    window_s : (float, float or None)
        Earliest beginning and latest end of the service; None for no end [s].
    windows_s : tuple of (float, float or None), or None
        Several windows, in place of that [s].
    capture_s : float or None
        Time from the beginning of the service that must lie within one window; None for all of the
        service [s].
    mass_kg : float or None
        [kg]; required for a tow.
    removal : {"visit", "kit", "tow"}
        "kit": the chaser leaves a kit with the object and goes on. "tow": it carries the object to
        its disposal orbit and goes on from there.
    object_id : str or None
        International designator, for exports.
    decay_m_per_day : float or None
        Daily decrease of the semi-major axis, which makes the phase quadratic in time [m/day].
    fit : Fit or None
        Further numbers of a fit of the orbit to an ephemeris.
    prize_until : tuple of (float, float), or None
        Times [s] and falling prizes, each of a service that ends by its time, with the tow if there
        is one; ``prize`` is left after the last.
    success : float or None
        Chance that a capture succeeds, for rehearsals and plans with a confidence.
    disposal : DisposalCircle, DisposalPerigee or None
        Where it is towed, in place of the mission's; with a kit, where that brings it afterwards.
    area_to_mass_m2_kg : float or None
        Area over mass, for the lifetime of the released object [m²/kg].
    """

    name: Name
    orbit: Orbit | None = None
    prize: Prize = 1.0
    required: bool = False
    window_s: Window = (0.0, None)
    windows_s: Annotated[tuple[Window, ...], Field(strict=False, min_length=1)] | None = None
    capture_s: Annotated[float, Field(ge=0.0)] | None = None
    mass_kg: Annotated[float, Field(gt=0.0, le=LARGEST_MASS_KG)] | None = None
    removal: Removal = "visit"
    object_id: ObjectId | None = None
    decay_m_per_day: Decay | None = None
    fit: Fit | None = None
    prize_until: PrizesUntil | None = None
    success: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    disposal: Disposal | None = None
    area_to_mass_m2_kg: Annotated[float, Field(gt=0.0, le=LARGEST_AREA_TO_MASS)] | None = None

    @property
    def windows(self) -> tuple[Window, ...]:
        """All windows stated at the target, ascending and disjoint [s]."""
        return (self.window_s,) if self.windows_s is None else self.windows_s

    def prize_at(self, end_s: float) -> float:
        """The prize of a service by its end, with the tow if there is one [s]."""
        return prize_at(self.prize, self.prize_until or (), end_s)

    @property
    def prizes(self) -> tuple[float, ...]:
        """All prizes that the target may be worth, the greatest first."""
        return (*(level for _, level in self.prize_until or ()), self.prize)

    @property
    def greatest_prize(self) -> float:
        """The prize of the earliest service."""
        return self.prizes[0]

    @property
    def service(self) -> ServiceKind:
        """The kind of service."""
        return SERVICES[self.removal]

    OMITTED: ClassVar = (
        *("object_id", "decay_m_per_day", "fit", "prize_until", "success", "disposal"),
        *("area_to_mass_m2_kg", "windows_s", "capture_s"),
    )

    @model_validator(mode="after")
    def _has_what_decays(self) -> Self:
        for field in ("decay_m_per_day", "fit"):
            if self.orbit is None and getattr(self, field) is not None:
                raise ValueError(f"field {field}: there is no orbit; give one, or leave it out")
        return self

    @model_validator(mode="after")
    def _falls(self) -> Self:
        if self.prize_until is not None and self.prize > self.prize_until[-1][1]:
            raise ValueError(
                f"field prize = {self.prize!r}: what is left after prize_until may not exceed its "
                f"last prize, {self.prize_until[-1][1]!r}"
            )
        return self

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        check_window("window_s", self.window_s)
        for number, window in enumerate(self.windows_s or ()):
            check_window(f"windows_s[{number}]", window)
        if self.windows_s is not None:
            if self.window_s != (0.0, None):
                raise ValueError(
                    "field windows_s: there is window_s as well; put it into the list, or leave it "
                    "out"
                )
            merged = windows_from(joined([intervals_of(self.windows_s)]))
            object.__setattr__(self, "windows_s", merged)
        return self
