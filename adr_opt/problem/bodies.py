"""Bodies of an instance that chasers visit: stations and targets."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from ..common.records import LARGEST_MASS_KG, Count, Name, Record, Window, check_window, without
from .falling_prizes import Prize, PrizesUntil, prize_at
from .fit import Decay, Fit
from .orbit import Orbit
from .services import SERVICES, ServiceKind

ObjectId = Annotated[str, Field(pattern=r"^[!-~]([ -~]*[!-~])?$", max_length=80)]
"""Object identifier as in messages: printable ASCII, mostly like ``1997-051C``."""

Removal = Literal["visit", "kit", "tow"]


class Station(Record):
    """A refuelling station, where chasers may start; without an orbit if connections are given.

    It fills at most ``max_refuellings`` tanks of all chasers together, and gives out at most
    ``max_propellant_kg`` for that; null for no limit. Neither field is in files that do not state
    it, nor is ``object_id``, as of a target. Chasers refuel on every arrival, also at the end
    of its route.
    """

    name: Name
    orbit: Orbit | None = None
    max_refuellings: Count | None = None
    max_propellant_kg: Annotated[float, Field(ge=0.0, le=LARGEST_MASS_KG)] | None = None
    object_id: ObjectId | None = None

    @property
    def is_limited(self) -> bool:
        """Whether its supply is limited."""
        return self.max_refuellings is not None or self.max_propellant_kg is not None

    @model_serializer(mode="wrap")
    def _without_no_limit(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without(write(self), "max_refuellings", "max_propellant_kg", "object_id")


class Target(Record):
    """A debris object that may be visited, and the prize for servicing it.

    Its service begins not before ``window_s`` opens and ends before it closes. ``required``: a plan
    has to service it. ``removal`` "kit": the chaser leaves a kit with it, and goes on without;
    "tow": it carries the object, which has ``mass_kg``, down to the disposal altitude of the
    mission and goes on from there. It may have no orbit where connections are given. ``object_id``
    is its international designator, for exports. ``decay_m_per_day``: by what its semi-major axis
    shrinks, which makes its phase quadratic in time. ``fit``: further numbers of a fit of its orbit
    to an ephemeris. ``prize_until``: times and falling prizes, each of a service that ends by its
    time, with the tow if there is one; ``prize`` is what is left after the last. ``success``: the
    chance that a capture succeeds, for rehearsals and plans with a confidence. None of the five is
    in files that do not state it.
    """

    name: Name
    orbit: Orbit | None = None
    prize: Prize = 1.0
    required: bool = False
    window_s: Window = (0.0, None)
    mass_kg: Annotated[float, Field(gt=0.0, le=LARGEST_MASS_KG)] | None = None
    removal: Removal = "visit"
    object_id: ObjectId | None = None
    decay_m_per_day: Decay | None = None
    fit: Fit | None = None
    prize_until: PrizesUntil | None = None
    success: Annotated[float, Field(ge=0.0, le=1.0)] | None = None

    def prize_at(self, end_s: float) -> float:
        """The prize of a service by its end, with the tow if there is one [s]."""
        return prize_at(self.prize, self.prize_until or (), end_s)

    @property
    def prizes(self) -> tuple[float, ...]:
        """All prizes that it may be worth, falling."""
        return (*(level for _, level in self.prize_until or ()), self.prize)

    @property
    def greatest_prize(self) -> float:
        """The prize of the earliest service."""
        return self.prizes[0]

    @property
    def service(self) -> ServiceKind:
        """The kind of service."""
        return SERVICES[self.removal]

    @model_serializer(mode="wrap")
    def _without_unset(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without(write(self), "object_id", "decay_m_per_day", "fit", "prize_until", "success")

    @model_validator(mode="after")
    def _has_what_decays(self) -> Self:
        for field in ("decay_m_per_day", "fit"):
            if self.orbit is None and getattr(self, field) is not None:
                raise ValueError(f"field {field}: there is no orbit to which it belongs")
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
        return self
