"""The chasers of an instance: where they start and end, when, and with what in the tank."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from .kernels.constants import STANDARD_GRAVITY_M_S2
from .orbit import Orbit
from .records import (
    LARGEST_DELTA_V_M_S,
    LARGEST_MASS_KG,
    Name,
    Record,
    Window,
    check_window,
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
    if value == "anywhere":
        return "(word)"
    for kind, model in (("station", AtStation), ("orbit", InOrbit)):
        if isinstance(value, model) or (isinstance(value, dict) and kind in value):
            return f"({kind})"
    return None


Start = Annotated[
    Annotated[Literal["anywhere"], Tag("(word)")]
    | Annotated[AtStation, Tag("(station)")]
    | Annotated[InOrbit, Tag("(orbit)")],
    Discriminator(
        _kind,
        custom_error_type="start",
        custom_error_message='must be {"station": NAME}, {"orbit": ORBIT} or "anywhere"',
    ),
]

End = Annotated[
    Annotated[Literal["anywhere"], Tag("(word)")] | Annotated[AtStation, Tag("(station)")],
    Discriminator(
        _kind,
        custom_error_type="end",
        custom_error_message='must be "anywhere" or {"station": NAME}',
    ),
]


class Tank(Record):
    """What a full tank is worth: at the start, and after refuelling."""

    delta_v_m_s: Annotated[float, Field(ge=0.0, le=LARGEST_DELTA_V_M_S)]

    @property
    def exhaust_m_s(self) -> float:
        """Nothing is known of masses, so that none makes a difference [m/s]."""
        return math.inf

    def full_m_s(self, cargo_kg: float) -> float:
        """What it is worth when it is full, with so much aboard [m/s]."""
        return self.delta_v_m_s


class TankByMass(Record):
    """A tank of so much propellant, of a chaser that has a mass without it and without cargo."""

    dry_mass_kg: Annotated[float, Field(gt=0.0, le=LARGEST_MASS_KG)]
    propellant_kg: Annotated[float, Field(ge=0.0, le=LARGEST_MASS_KG)]
    isp_s: Annotated[float, Field(gt=0.0, le=1e5)]

    @model_validator(mode="after")
    def _can_be_counted(self) -> Self:
        if self.delta_v_m_s > LARGEST_DELTA_V_M_S:
            raise ValueError(f"is worth {self.delta_v_m_s:g} m/s, more than anybody can count")
        return self

    @property
    def exhaust_m_s(self) -> float:
        """g₀ Isp [m/s]."""
        return self.isp_s * STANDARD_GRAVITY_M_S2

    @property
    def delta_v_m_s(self) -> float:
        """What it is worth when it is full and nothing is aboard [m/s]."""
        return self.full_m_s(0.0)

    def full_m_s(self, cargo_kg: float) -> float:
        """What it is worth when it is full, with so much aboard [m/s]."""
        return self.exhaust_m_s * math.log1p(self.propellant_kg / (self.dry_mass_kg + cargo_kg))


def _kind_of_tank(value: Any) -> str:
    """Which of the kinds of a tank a value is; those in brackets are for the reader alone."""
    by_mass = isinstance(value, TankByMass) or (
        isinstance(value, dict) and not TANK_BY_MASS.isdisjoint(value)
    )
    return "(mass)" if by_mass else "(delta-v)"


AnyTank = Annotated[
    Annotated[Tank, Tag("(delta-v)")] | Annotated[TankByMass, Tag("(mass)")],
    Discriminator(_kind_of_tank),
]


class Chaser(Record):
    """A spacecraft that visits targets.

    It takes along as many kits as its route leaves behind, ``kits`` at most; null for no limit.
    """

    name: Name
    start: Start
    available_s: Window = (0.0, None)
    end: End = "anywhere"
    max_targets: Annotated[int, Field(ge=0)] | None = None
    tank: AnyTank
    kits: Annotated[int, Field(ge=0)] | None = None
    kit_mass_kg: Annotated[float, Field(ge=0.0, le=LARGEST_MASS_KG)] = 0.0

    @model_validator(mode="after")
    def _weighs(self) -> Self:
        if self.kit_mass_kg > 0.0 and not isinstance(self.tank, TankByMass):
            raise ValueError(
                f"kit_mass_kg = {self.kit_mass_kg!r}: a tank that is counted in ΔV knows no "
                "masses; give its dry_mass_kg, propellant_kg and isp_s, or kit_mass_kg 0.0"
            )
        return self

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        check_window("available_s", self.available_s)
        return self

    @property
    def start_name(self) -> str:
        """Name of the body where it starts: a station, or its own for an orbit of its own.

        And its own for a chaser that is launched onto its first target, and is nowhere before.
        """
        return self.start.station if isinstance(self.start, AtStation) else self.name

    @property
    def is_launched(self) -> bool:
        """Whether it is launched onto its first target."""
        return self.start == "anywhere"


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
