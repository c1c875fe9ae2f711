"""Chasers of an instance: start, end, availability and tank."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationError, model_validator

from ..common.constants import EARTH_RADIUS_M, STANDARD_GRAVITY_M_S2
from ..common.errors import InputError
from ..common.records import (
    LARGEST_DELTA_V_M_S,
    LARGEST_EXPENSE,
    LARGEST_LENGTH_M,
    LARGEST_MASS_KG,
    LARGEST_THRUST_N,
    Count,
    Name,
    Omitting,
    Record,
    Window,
    check_window,
)
from ..common.sentences import sentence
from .orbit import Decay, Orbit

TANK_BY_MASS = {"dry_mass_kg", "propellant_kg", "isp_s"}

TOO_HEAVY_M_S = 1.0
"""ΔV charged beyond a full tank if the launcher cannot lift the chaser with its kits [m/s]."""

TWO_KINDS = (
    "a tank is Tank(delta_v_m_s=…), counted in ΔV, or TankByMass(dry_mass_kg=…, propellant_kg=…, "
    "isp_s=…), by mass"
)


class AtStation(Record):
    """Start or end at a station, given by name."""

    station: Name


class InOrbit(Omitting):
    """Start in an orbit of its own, which is a body under the chaser's name.

    ``decay_m_per_day`` is that of a target at which it waits; in no file that does not state it.
    """

    orbit: Orbit
    decay_m_per_day: Decay | None = None

    OMITTED: ClassVar = ("decay_m_per_day",)


class InsertionOrbit(Omitting):
    """A circle that a launcher reaches at any time, in the plane of any node.

    Attributes
    ----------
    altitude_m : float
        [m].
    inclination_deg : float
        [deg].
    launcher : tuple of (float, float) or None
        Altitudes [m], ascending, and the mass that is lifted to each, with propellant and kits
        [kg]; linear between them. None for no limit.
    """

    altitude_m: Annotated[float, Field(gt=0.0, le=LARGEST_LENGTH_M)]
    inclination_deg: Annotated[float, Field(ge=0.0, le=180.0)]
    launcher: (
        Annotated[
            tuple[Annotated[tuple[float, float], Field(strict=False)], ...],
            Field(strict=False, min_length=1),
        ]
        | None
    ) = None

    @model_validator(mode="after")
    def _reaches(self) -> Self:
        if self.launcher is None:
            return self
        heights = [altitude for altitude, _ in self.launcher]
        if heights != sorted(set(heights)) or min(kg for _, kg in self.launcher) < 0:
            raise ValueError(
                f"launcher = {self.launcher!r}: give rows [altitude_m, mass_kg], altitudes "
                "ascending and masses of at least 0"
            )
        if not heights[0] <= self.altitude_m <= heights[-1]:
            raise ValueError(
                f"altitude_m = {self.altitude_m!r}: the launcher is given from {heights[0]!r} to "
                f"{heights[-1]!r}; give it for that altitude as well"
            )
        return self

    OMITTED: ClassVar = ("launcher",)

    @property
    def most_kg(self) -> float:
        """Largest mass of a chaser at launch; infinite without a launcher [kg]."""
        if self.launcher is None:
            return math.inf
        altitudes, masses = np.transpose(self.launcher)
        return float(np.interp(self.altitude_m, altitudes, masses))


class LaunchedInto(Record):
    """Start by a launch into an orbit, with the node of the first target at that time."""

    launch: InsertionOrbit

    @property
    def orbit(self) -> Orbit:
        """The circle, with an arbitrary node and place."""
        return Orbit(
            semi_major_axis_m=EARTH_RADIUS_M + self.launch.altitude_m,
            eccentricity=0.0,
            inclination_deg=self.launch.inclination_deg,
            raan_deg=0.0,
            argument_of_perigee_deg=0.0,
            true_anomaly_deg=0.0,
        )


def _kind(value: Any) -> str | None:
    """Tag of the kind of place that a value describes; tags in brackets are for readers only."""
    if value == "anywhere":
        return "(word)"
    kinds = ("station", AtStation), ("orbit", InOrbit), ("launch", LaunchedInto)
    for kind, model in kinds:
        if isinstance(value, model) or (isinstance(value, dict) and kind in value):
            return f"({kind})"
    return None


Start = Annotated[
    Annotated[Literal["anywhere"], Tag("(word)")]
    | Annotated[AtStation, Tag("(station)")]
    | Annotated[InOrbit, Tag("(orbit)")]
    | Annotated[LaunchedInto, Tag("(launch)")],
    Discriminator(
        _kind,
        custom_error_type="start",
        custom_error_message='must be {"station": NAME}, {"orbit": ORBIT}, {"launch": LAUNCH} or '
        '"anywhere"',
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


class _OfTwoKinds(Omitting):
    """Base of both kinds of tank: an error in Python is one sentence that names them."""

    def __init__(self, /, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise InputError(f"{type(self).__name__}: {sentence(error)}; {TWO_KINDS}") from None

    # Within a file pydantic does without it, and names the place there.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]


class Tank(_OfTwoKinds):
    """A tank counted in ΔV, full after refuelling.

    Attributes
    ----------
    delta_v_m_s : float
        ΔV of the full tank [m/s].
    initial_delta_v_m_s : float or None
        ΔV at the start, if the tank is not full then [m/s].
    """

    delta_v_m_s: Annotated[float, Field(ge=0.0, le=LARGEST_DELTA_V_M_S)]
    initial_delta_v_m_s: Annotated[float, Field(ge=0.0)] | None = None

    @model_validator(mode="after")
    def _holds_it(self) -> Self:
        _check_initial("initial_delta_v_m_s", self.initial_delta_v_m_s, self.delta_v_m_s)
        return self

    OMITTED: ClassVar = ("initial_delta_v_m_s",)

    def keeping(self, reserve_m_s: float) -> Tank:
        """The tank less a reserve [m/s]."""
        initial = self.initial_delta_v_m_s
        return Tank(
            delta_v_m_s=self.delta_v_m_s - reserve_m_s,
            initial_delta_v_m_s=None if initial is None else initial - reserve_m_s,
        )

    def spent_with_m_s(self, cargo_kg: float, most_kg: float) -> float:
        """ΔV missing from a full tank at the start, with cargo aboard [m/s]."""
        initial = self.initial_delta_v_m_s
        return 0.0 if initial is None else self.delta_v_m_s - initial

    @property
    def exhaust_m_s(self) -> float:
        """Exhaust speed; infinite, as masses are unknown and make no difference [m/s]."""
        return math.inf

    def full_m_s(self, cargo_kg: float) -> float:
        """ΔV of a full tank, with cargo aboard [m/s]."""
        return self.delta_v_m_s


def _check_initial(field: str, initial: float | None, full: float) -> None:
    if initial is not None and initial > full:
        raise ValueError(f"{field} = {initial!r}: a full tank holds {full!r}; give no more")


class TankByMass(_OfTwoKinds):
    """A tank counted in propellant, full after refuelling.

    Attributes
    ----------
    dry_mass_kg : float
        Mass of the chaser without propellant and kits [kg].
    propellant_kg : float
        Propellant of the full tank [kg].
    isp_s : float
        Specific impulse [s].
    initial_propellant_kg : float or None
        Propellant at the start, if the tank is not full then [kg].
    """

    dry_mass_kg: Annotated[float, Field(gt=0.0, le=LARGEST_MASS_KG)]
    propellant_kg: Annotated[float, Field(ge=0.0, le=LARGEST_MASS_KG)]
    isp_s: Annotated[float, Field(gt=0.0, le=1e5)]
    initial_propellant_kg: Annotated[float, Field(ge=0.0)] | None = None

    @model_validator(mode="after")
    def _holds_it(self) -> Self:
        _check_initial("initial_propellant_kg", self.initial_propellant_kg, self.propellant_kg)
        return self

    OMITTED: ClassVar = ("initial_propellant_kg",)

    def keeping(self, reserve_m_s: float) -> TankByMass:
        """The tank without the propellant that gives a chaser without kits some ΔV [m/s].

        That counts as dry mass, since it is never burnt.
        """
        kept_kg = self.dry_mass_kg * math.expm1(reserve_m_s / self.exhaust_m_s)
        initial = self.initial_propellant_kg
        return TankByMass(
            dry_mass_kg=self.dry_mass_kg + kept_kg,
            propellant_kg=self.propellant_kg - kept_kg,
            isp_s=self.isp_s,
            initial_propellant_kg=None if initial is None else initial - kept_kg,
        )

    def first_kg(self, cargo_kg: float, most_kg: float) -> float:
        """Propellant at the start within a mass limit; negative if too heavy without any [kg]."""
        initial = self.initial_propellant_kg
        first_kg = self.propellant_kg if initial is None else initial
        return min(first_kg, most_kg - self.dry_mass_kg - cargo_kg)

    def spent_with_m_s(self, cargo_kg: float, most_kg: float) -> float:
        """ΔV missing from a full tank at the start, with cargo aboard, as of :meth:`first_kg`.

        More than all of it where cargo is too heavy [m/s].
        """
        first_kg, full_m_s = self.first_kg(cargo_kg, most_kg), self.full_m_s(cargo_kg)
        if first_kg == self.propellant_kg:
            return 0.0
        if first_kg < 0.0:
            return full_m_s + TOO_HEAVY_M_S
        return full_m_s - self.exhaust_m_s * math.log1p(first_kg / (self.dry_mass_kg + cargo_kg))

    @model_validator(mode="after")
    def _can_be_counted(self) -> Self:
        if self.delta_v_m_s > LARGEST_DELTA_V_M_S:
            raise ValueError(f"is worth {self.delta_v_m_s:g} m/s, which is too large")
        return self

    @property
    def exhaust_m_s(self) -> float:
        """g₀ Isp [m/s]."""
        return self.isp_s * STANDARD_GRAVITY_M_S2

    @property
    def delta_v_m_s(self) -> float:
        """ΔV of a full tank without cargo [m/s]."""
        return self.full_m_s(0.0)

    def full_m_s(self, cargo_kg: float) -> float:
        """ΔV of a full tank, with cargo aboard [m/s]."""
        return self.exhaust_m_s * math.log1p(self.propellant_kg / (self.dry_mass_kg + cargo_kg))


def _kind_of_tank(value: Any) -> str:
    """Tag of the kind of tank that a value describes; tags in brackets are for readers only."""
    by_mass = isinstance(value, TankByMass) or (
        isinstance(value, dict) and not TANK_BY_MASS.isdisjoint(value)
    )
    return "(mass)" if by_mass else "(delta-v)"


AnyTank = Annotated[
    Annotated[Tank, Tag("(delta-v)")] | Annotated[TankByMass, Tag("(mass)")],
    Discriminator(_kind_of_tank),
]


Price = Annotated[float, Field(ge=0.0, le=LARGEST_EXPENSE)]


class Expense(Record):
    """Cost of using a chaser, by the mass it carries at the start, in any currency.

    fixed + per_kg · c + per_kg_squared · c², with c [kg] the kits that its route leaves behind and
    the least propellant that it can be flown with, up to the first refuelling.
    """

    fixed: Price = 0.0
    per_kg: Price = 0.0
    per_kg_squared: Price = 0.0

    @property
    def counts_mass(self) -> bool:
        """Whether it depends on the carried mass."""
        return self.per_kg > 0.0 or self.per_kg_squared > 0.0

    def of(self, carried_kg: float) -> float:
        """Expense of a chaser that is used and carries some mass at the start."""
        return self.fixed + (self.per_kg + self.per_kg_squared * carried_kg) * carried_kg


NO_EXPENSE = Expense()
"""Expense of a chaser that states none."""


class Chaser(Omitting):
    """A spacecraft that visits targets.

    Attributes
    ----------
    name : str
    start : AtStation, InOrbit, LaunchedInto or "anywhere"
        "anywhere": launched onto its first target, at no cost.
    available_s : (float, float or None)
        Window in which it may fly; None for no end [s].
    end : AtStation or "anywhere"
        Where its route must end.
    max_targets : int or None
        Maximum number of targets.
    max_visits_between_refuels : int or None
        Maximum number of targets before the first refuelling, and between two.
    tank : Tank or TankByMass
    end_of_life_m_s : float or None
        ΔV kept for its own disposal at all times [m/s].
    kits : int or None
        Maximum number of kits aboard; it carries as many as its route leaves behind.
    kit_mass_kg : float
        Mass of a kit [kg].
    expense : Expense or None
        Cost of using it, where the objective counts expenses.
    thrust_n : float or None
        Low thrust for all its transfers (docs/model.md section 11); None for impulses [N].
    duty_cycle : float or None
        Largest share of the time in which that thrust is on; None for 1.
    """

    name: Name
    start: Start
    available_s: Window = (0.0, None)
    end: End = "anywhere"
    max_targets: Count | None = None
    max_visits_between_refuels: Annotated[Count, Field(ge=1)] | None = None
    tank: AnyTank
    end_of_life_m_s: Annotated[float, Field(gt=0.0, le=LARGEST_DELTA_V_M_S)] | None = None
    kits: Count | None = None
    kit_mass_kg: Annotated[float, Field(ge=0.0, le=LARGEST_MASS_KG)] = 0.0
    expense: Expense | None = None
    thrust_n: Annotated[float, Field(gt=0.0, le=LARGEST_THRUST_N)] | None = None
    duty_cycle: Annotated[float, Field(gt=0.0, le=1.0)] | None = None

    @property
    def most_visits(self) -> tuple[int | None, ...]:
        """Limits on the number of targets visited without refuelling."""
        return self.max_targets, self.max_visits_between_refuels

    OMITTED: ClassVar = (
        *("max_visits_between_refuels", "end_of_life_m_s", "expense", "thrust_n"),
        "duty_cycle",
    )

    @model_validator(mode="before")
    @classmethod
    def _has_no_exceptions(cls, given: Any) -> Any:
        if isinstance(given, dict) and "max_exceptions" in given:
            raise ValueError(
                "max_exceptions: limits of exceptions were removed in 1.1; leave it out"
            )
        return given

    @model_validator(mode="after")
    def _can_thrust(self) -> Self:
        if self.thrust_n is None:
            if self.duty_cycle is not None:
                raise ValueError(
                    f"duty_cycle = {self.duty_cycle!r}: the chaser has no thrust; give thrust_n, "
                    "too, or leave it out"
                )
        elif not isinstance(self.tank, TankByMass):
            raise ValueError(
                f"thrust_n = {self.thrust_n!r}: the tank is given in ΔV, without masses; give its "
                "dry_mass_kg, propellant_kg and isp_s"
            )
        return self

    @model_validator(mode="after")
    def _can_be_weighed(self) -> Self:
        counts = self.expense is not None and self.expense.counts_mass
        if counts and not isinstance(self.tank, TankByMass):
            raise ValueError(
                "expense depends on the carried mass, but the tank is given in ΔV; give its "
                "dry_mass_kg, propellant_kg and isp_s, or per_kg and per_kg_squared 0.0"
            )
        return self

    @model_validator(mode="after")
    def _weighs(self) -> Self:
        if self.kit_mass_kg > 0.0 and not isinstance(self.tank, TankByMass):
            raise ValueError(
                f"kit_mass_kg = {self.kit_mass_kg!r}: the tank is given in ΔV, without "
                "masses; give its dry_mass_kg, propellant_kg and isp_s, or kit_mass_kg 0.0"
            )
        return self

    @model_validator(mode="after")
    def _is_lifted(self) -> Self:
        if self.most_kg == math.inf:
            return self
        if not isinstance(self.tank, TankByMass):
            raise ValueError(
                "start.launch.launcher limits masses, but the tank is given in ΔV; give its "
                "dry_mass_kg, propellant_kg and isp_s, or leave the launcher out"
            )
        if self.tank.dry_mass_kg > self.most_kg:
            raise ValueError(
                f"tank.dry_mass_kg = {self.tank.dry_mass_kg!r}: the launcher lifts "
                f"{self.most_kg:g} kg to that altitude; launch lower, or make the chaser lighter"
            )
        return self

    @model_validator(mode="after")
    def _keeps_no_more_than_it_has(self) -> Self:
        most = self.tank.delta_v_m_s - self.tank.spent_with_m_s(0.0, self.most_kg)
        if self.end_of_life_m_s is not None and self.end_of_life_m_s >= most:
            raise ValueError(
                f"end_of_life_m_s = {self.end_of_life_m_s!r}: the tank has {most:g} m/s at the "
                "start; keep less of it"
            )
        return self

    @model_validator(mode="after")
    def _begins_with_it(self) -> Self:
        if self.spent_m_s > 0.0 and isinstance(self.start, AtStation):
            raise ValueError(
                "field tank: its content at the start is given, but the station where it starts "
                "fills it; start in an orbit, or leave it out"
            )
        return self

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        check_window("available_s", self.available_s)
        return self

    @property
    def usable(self) -> Tank | TankByMass:
        """The tank less the reserve for the chaser's own disposal: what the mission may use."""
        kept_m_s = self.end_of_life_m_s
        return self.tank if kept_m_s is None else self.tank.keeping(kept_m_s)

    @property
    def launch(self) -> InsertionOrbit | None:
        """The launch into an orbit with which the chaser starts; None for any other start."""
        return self.start.launch if isinstance(self.start, LaunchedInto) else None

    @property
    def awaits_launch(self) -> bool:
        """Whether the chaser starts with a launch, and so is not in orbit before its first leg."""
        return self.is_launched or self.launch is not None

    @property
    def most_kg(self) -> float:
        """Largest mass at the start; infinite if no launcher limits it [kg]."""
        return math.inf if self.launch is None else self.launch.most_kg

    def spent_with_m_s(self, cargo_kg: float) -> float:
        """ΔV missing from a full tank at the start, with cargo aboard [m/s]."""
        return self.usable.spent_with_m_s(cargo_kg, self.most_kg)

    @property
    def spent_m_s(self) -> float:
        """ΔV missing from a full tank at the start, without cargo [m/s]."""
        return self.spent_with_m_s(0.0)

    @property
    def lacks_by_mass(self) -> bool:
        """Whether its tank is not full at the start and the ΔV missing depends on masses.

        Then what lacks goes with the kits that are taken along, or must not be counted as flown.
        """
        weighs = self.kit_mass_kg > 0.0 or (self.expense is not None and self.expense.counts_mass)
        return weighs and (self.spent_m_s > 0.0 or self.most_kg < math.inf)

    @property
    def start_name(self) -> str:
        """Name of the body where it starts: a station, or its own name for an orbit of its own.

        And its own for one that is launched, and is nowhere before.
        """
        return self.start.station if isinstance(self.start, AtStation) else self.name

    @property
    def priced(self) -> Expense:
        """Its expense; zero if none is stated."""
        return self.expense or NO_EXPENSE

    @property
    def starts_at_station(self) -> bool:
        """Whether it starts at a station."""
        return isinstance(self.start, AtStation)

    @property
    def is_launched(self) -> bool:
        """Whether it is launched directly to its first target."""
        return self.start == "anywhere"


def availability(chasers: Sequence[Chaser], separation_s: float | None) -> tuple[Window, ...]:
    """Time window of each chaser, with launches kept apart [s].

    Those that are launched are so in their order, each as soon as it may: to wait at the first
    target is no worse. Whether those before it are used or not, each has its place in the order.
    Without a separation (None, which is not 0) no launch waits for another one.
    """
    if separation_s is None:
        return tuple(chaser.available_s for chaser in chasers)
    found, next_s = [], -math.inf
    for chaser in chasers:
        since, until = chaser.available_s
        if chaser.is_launched:
            since = max(since, next_s)
            next_s = since + separation_s
        found.append((since, until))
    return tuple(found)


def free_name(taken: Collection[str]) -> str:
    """Name of an instance's only chaser if it has none: "chaser", or a numbered one.

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
