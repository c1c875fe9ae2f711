"""The chasers of an instance: where they start and end, when, and with what in the tank."""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from .orbit import Orbit
from .records import (
    LARGEST_DELTA_V_M_S,
    Name,
    Record,
    Window,
    check_window,
    not_yet,
)

TANK_BY_MASS = {"dry_mass_kg", "propellant_kg", "isp_s"}


class AtStation(Record):
    """At a station, which has its name."""

    station: Name


class InOrbit(Record):
    """In an orbit of its own, which is a body by the name of the chaser."""

    orbit: Orbit


def _kind(value: Any) -> str | None:
    """Which of the kinds of a place a value is; those in brackets are for the reader alone."""
    if isinstance(value, str):
        return "(word)"
    for kind, model in (("station", AtStation), ("orbit", InOrbit)):
        if isinstance(value, model) or (isinstance(value, dict) and kind in value):
            return f"({kind})"
    return None


Start = Annotated[
    Annotated[AtStation, Tag("(station)")] | Annotated[InOrbit, Tag("(orbit)")],
    Discriminator(
        _kind,
        custom_error_type="start",
        custom_error_message='must be {"station": NAME} or {"orbit": ORBIT}',
    ),
    not_yet(lambda place: place == "anywhere", 'write {"station": NAME} or {"orbit": ORBIT}'),
]

End = Annotated[
    Annotated[Literal["anywhere"], Tag("(word)")] | Annotated[AtStation, Tag("(station)")],
    Discriminator(
        _kind,
        custom_error_type="end",
        custom_error_message='must be "anywhere" or {"station": NAME}',
    ),
]


def _is_by_mass(tank: Any) -> bool:
    return isinstance(tank, dict) and not TANK_BY_MASS.isdisjoint(tank)


class Tank(Record):
    """What a full tank is worth: at the start, and after refuelling."""

    delta_v_m_s: Annotated[float, Field(ge=0.0, le=LARGEST_DELTA_V_M_S)]


class Chaser(Record):
    """A spacecraft that visits targets."""

    name: Name
    start: Start
    available_s: Window = (0.0, None)
    end: End = "anywhere"
    max_targets: Annotated[int, Field(ge=0)] | None = None
    tank: Annotated[Tank, not_yet(_is_by_mass, "give its delta_v_m_s", "a tank by mass")]
    kits: Annotated[None, not_yet(lambda kits: kits is not None, "write null", "carrying kits")] = (
        None
    )
    kit_mass_kg: Annotated[
        float,
        Field(json_schema_extra={"const": 0.0}),
        not_yet(lambda mass: mass != 0.0, "write 0.0", "carrying kits"),
    ] = 0.0

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        check_window("available_s", self.available_s)
        return self

    @property
    def start_name(self) -> str:
        """Name of the body where it starts: a station, or its own for an orbit of its own."""
        return self.start.station if isinstance(self.start, AtStation) else self.name


def free_name(taken: Collection[str]) -> str:
    """The name of the one chaser of an instance that does not name it: "chaser", or a numbered one.

    Parameters
    ----------
    taken : collection of str
        Names of the bodies.
    """
    name, number = "chaser", 0
    while name in taken:
        number += 1
        name = f"chaser-{number}"
    return name
