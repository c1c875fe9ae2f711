"""A flight as its burns: the basis of state messages and scripts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from ...fly.trajectory.axes import Axes
from ...fly.trajectory.kepler import Array
from ...fly.trajectory.sampling import Trajectory
from ...plan.cargo import followed
from ...plan.plan import Leg
from ...plan.refined_plan import RefinedLeg
from ...plan.routes import routes_of
from ...plan.tows import removals_by_name
from ...problem.chasers import Chaser, TankByMass
from ...problem.instance import Instance
from .kvn import origin, who


class Impulse(Protocol):
    """A burn of a plan or of a refined one."""

    @property
    def time_s(self) -> float:
        """Time of the burn [s]."""
        ...

    @property
    def delta_v_m_s(self) -> Sequence[float]:
        """ΔV as a vector, in the frame of the elements [m/s]."""
        ...

    @property
    def size_m_s(self) -> float:
        """ΔV of the burn [m/s]."""
        ...

    @property
    def phase(self) -> str:
        """The phase begun by the burn."""
        ...


@dataclass(frozen=True)
class ThrustWindow:
    """A window of low thrust.

    Attributes
    ----------
    times_s : (n,) float64
        Both ends included [s].
    forces_n : (n, 3) float64
        At these times in the frame of the elements, linear between them [N].
    before_kg : float
        Mass at the beginning [kg].
    flow_kg_s : float
        Mass flow, as long as the window lasts [kg/s].
    """

    times_s: Array
    forces_n: Array
    before_kg: float
    flow_kg_s: float

    @property
    def start_s(self) -> float:
        """Start of the window [s]."""
        return float(self.times_s[0])

    @property
    def end_s(self) -> float:
        """End of the window [s]."""
        return float(self.times_s[-1])

    @property
    def after_kg(self) -> float:
        """Mass at the end of the window [kg]."""
        return self.before_kg - self.flow_kg_s * (self.end_s - self.start_s)


@dataclass(frozen=True)
class CourseLeg:
    """One leg.

    Attributes
    ----------
    number : int
        From 1, as in the plan; 0 for a launch that is no leg of it.
    origin, destination : str
    arrival_s, end_s : float
        End of the approach, and of the service [s].
    impulses, removal : tuple of Impulse
        Those of the transfer, and those after the service, with the object.
    windows : tuple of ThrustWindow
        Of low thrust, before all burns.
    """

    number: int
    origin: str
    destination: str
    arrival_s: float
    end_s: float
    impulses: tuple[Impulse, ...]
    removal: tuple[Impulse, ...] = ()
    windows: tuple[ThrustWindow, ...] = ()

    @classmethod
    def of(cls, number: int, leg: Leg | RefinedLeg) -> CourseLeg:
        """A leg of a plan or of a refined plan."""
        ends = leg.origin, leg.destination, leg.arrival_s, leg.end_s
        return cls(number, *ends, leg.impulses, leg.removal_burns)

    @property
    def all_impulses(self) -> tuple[Impulse, ...]:
        """Impulses of the transfer and of the removal after it."""
        return (*self.impulses, *self.removal)

    @property
    def title(self) -> str:
        """Number and bodies of the leg, in words."""
        return f"leg {self.number}, {self.origin} to {self.destination}"


@dataclass(frozen=True)
class Burnt:
    """Mass before a burn, a towed object included, and its propellant [kg]."""

    before_kg: float
    lost_kg: float


@dataclass(frozen=True)
class Propulsion:
    """Propulsion of low thrust: a chaser's mass without propellant, and its exhaust speed."""

    dry_kg: float
    exhaust_m_s: float


@dataclass(frozen=True)
class FlightCourse:
    """The flight of one chaser.

    Attributes
    ----------
    instance : Instance
    chaser : str or None
        Whose it is, where there are several.
    legs : tuple of CourseLeg
        At least one.
    said : tuple of str
        Sentences that say what the flight is of.
    burnt : mapping of int to tuple of Burnt
        For each leg, by its number, one for each of its burns; empty where masses are not known.
    propulsion : Propulsion or None
        Of a flight with low thrust; masses are then known.
    """

    instance: Instance
    chaser: str | None
    legs: tuple[CourseLeg, ...]
    said: tuple[str, ...]
    burnt: Mapping[int, tuple[Burnt, ...]] = field(default_factory=dict)
    propulsion: Propulsion | None = None

    def begins_kg(self, leg: CourseLeg) -> float | None:
        """Mass at the beginning of a leg; None if unknown [kg]."""
        if leg.windows:
            return leg.windows[0].before_kg
        burnt = self.burnt.get(leg.number, ())
        return burnt[0].before_kg if burnt else None


def burnt_of(
    instance: Instance, chaser: Chaser, route: Iterable[CourseLeg]
) -> dict[int, tuple[Burnt, ...]]:
    """Propellant use of a chaser's burns over all legs; empty without a tank by mass.

    The tank is filled at stations, kits stay with targets, and what is towed counts while it is.
    """
    tank, legs = chaser.tank, tuple(route)
    if not isinstance(tank, TankByMass):
        return {}
    flown = [(leg.destination, math.fsum(burn.size_m_s for burn in leg.impulses)) for leg in legs]
    stages, removals = followed(instance, chaser, flown), removals_by_name(instance, None)
    found: dict[int, tuple[Burnt, ...]] = {}
    for leg, before, after in zip(legs, stages, stages[1:], strict=False):
        found[leg.number] = burnt_from(before.mass_kg or 0.0, leg.impulses, tank.exhaust_m_s)
        if leg.removal:
            mass_kg = (
                (after.mass_kg or 0.0) + after.removal_kg + removals[leg.destination].object_kg
            )
            docked = [burn for burn in leg.removal if burn.phase != "return"]
            towing = burnt_from(mass_kg, docked, tank.exhaust_m_s)
            alone_kg = mass_kg - removals[leg.destination].object_kg
            alone_kg -= math.fsum(burn.lost_kg for burn in towing)
            back = burnt_from(alone_kg, leg.removal[len(docked) :], tank.exhaust_m_s)
            found[leg.number] += (*towing, *back)
    return found


def burnt_from(mass_kg: float, burns: Iterable[Impulse], exhaust_m_s: float) -> tuple[Burnt, ...]:
    """Propellant of burns one after another, from a mass before the first."""
    found = []
    for burn in burns:
        found.append(Burnt(mass_kg, mass_kg * -math.expm1(-burn.size_m_s / exhaust_m_s)))
        mass_kg -= found[-1].lost_kg
    return tuple(found)


def course_of(trajectory: Trajectory, axes: Axes) -> FlightCourse:
    """Legs of a trajectory as their burns, with masses from its plan."""
    instance, plan = trajectory.instance, trajectory.plan
    numbers = [path.number for path in trajectory.legs]
    burnt: dict[int, tuple[Burnt, ...]] = {}
    for flown in routes_of(instance, plan):
        route = [CourseLeg.of(number, leg) for number, leg in flown.legs]
        if any(leg.number in numbers for leg in route):
            burnt |= burnt_of(instance, flown.chaser, route)
    return FlightCourse(
        instance,
        trajectory.chaser,
        tuple(CourseLeg.of(path.number, path.leg) for path in trajectory.legs),
        (*origin(instance, plan, axes), *who(instance, trajectory.chaser)),
        burnt,
    )
