"""Legs of a plan by chaser and by tank."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol, TypeVar

from ..common.errors import InputError
from ..problem.chasers import Chaser, TankByMass
from ..problem.instance import Instance
from .cargo import Aboard, Carried, carried, followed, tank_worths
from .plan import Leg, Plan


class _Arriving(Protocol):
    @property
    def destination(self) -> str: ...


Arriving = TypeVar("Arriving", bound=_Arriving)


@dataclass(frozen=True)
class Flown:
    """The flight of one chaser.

    Attributes
    ----------
    chaser : Chaser
    legs : tuple of (int, Leg)
        In order, each after its number: legs are counted from 1 through all routes.
    """

    chaser: Chaser
    legs: tuple[tuple[int, Leg], ...]

    @property
    def end_s(self) -> float:
        """End of its last service or tow; 0 without legs [s]."""
        return self.legs[-1][1].done_s if self.legs else 0.0

    @property
    def delta_v_m_s(self) -> float:
        """ΔV of all its legs and tows [m/s]."""
        return sum(leg.spent_m_s for _, leg in self.legs)

    @property
    def spent(self) -> list[tuple[str, float]]:
        """Destination and ΔV [m/s] of each leg."""
        return [(leg.destination, leg.delta_v_m_s) for _, leg in self.legs]

    @property
    def vented_kg(self) -> list[float]:
        """Propellant vented before each leg [kg]."""
        return [leg.vented_kg or 0.0 for _, leg in self.legs]

    def aboard(self, instance: Instance) -> tuple[Aboard, ...]:
        """Cargo at the start and after each leg."""
        return followed(instance, self.chaser, self.spent, vented_kg=self.vented_kg)

    def departing_kg(self, instance: Instance) -> list[float]:
        """Mass at the departure of each leg; 0 where it is not known."""
        vented = [0.0, *self.vented_kg[1:]]  # the first is not loaded
        stages = self.aboard(instance)
        return [(stage.mass_kg or 0.0) - lost for stage, lost in zip(stages, vented, strict=False)]

    def carried(self, instance: Instance) -> Carried:
        """Cargo along the route and at its end."""
        return carried(instance, self.chaser, self.spent, self.vented_kg)

    def tank_worths(self, instance: Instance) -> tuple[float, ...]:
        """ΔV of each of its tanks over the legs flown from it [m/s]."""
        return tank_worths(instance, self.chaser, self.spent, vented_kg=self.vented_kg)

    def refuellings(self, instance: Instance) -> int:
        """Number of refuellings."""
        return sum(leg.destination in instance.station_names for _, leg in self.legs)


def weighed(instance: Instance, chaser: Chaser, legs: Iterable[Leg]) -> tuple[Leg, ...]:
    """Legs of a chaser with its mass after each, if its tank is one by mass."""
    legs = tuple(legs)
    if not isinstance(chaser.tank, TankByMass):
        return legs
    spent = [(leg.destination, leg.delta_v_m_s) for leg in legs]
    vented_kg = [leg.vented_kg or 0.0 for leg in legs]
    stages = followed(instance, chaser, spent, vented_kg=vented_kg)[1:]
    return tuple(
        leg.replace(delta_v_left_m_s=stage.left_m_s, mass_kg=stage.mass_kg)
        for leg, stage in zip(legs, stages, strict=True)
    )


def several(instance: Instance) -> bool:
    """Whether there are several chasers, so that legs must name theirs."""
    return len(instance.chasers) > 1


def routes_of(instance: Instance, plan: Plan) -> tuple[Flown, ...]:
    """Flight of each chaser, in the order of the plan; chasers without a route come last.

    Where there is one chaser, all legs are its own.

    Raises
    ------
    InputError
        There are several chasers, and a route is of none of them or the second of one.
    """
    numbered = tuple(enumerate(plan.legs, start=1))
    if not several(instance):
        return (Flown(instance.chasers[0], numbered),)
    waiting = {chaser.name: chaser for chaser in instance.chasers}
    found, at = [], 0
    for number, route in enumerate(plan.routes):
        if route.chaser not in waiting:
            raise InputError(
                f"routes[{number}].chaser = {route.chaser!r}: "
                + refused_chaser(instance, route.chaser, "it already has a route; join the two")
            )
        found.append(Flown(waiting.pop(route.chaser), numbered[at : at + len(route.legs)]))
        at += len(route.legs)
    return (*found, *(Flown(chaser, ()) for chaser in waiting.values()))


def refused_chaser(instance: Instance, name: str, otherwise: str) -> str:
    """Reason for refusing a name: no such chaser, or another reason."""
    names = [chaser.name for chaser in instance.chasers]
    if name in names:
        return otherwise
    return f"not a chaser of the instance; its chasers are {', '.join(map(repr, names))}"


def chaser_wanted(
    instance: Instance, whose: Mapping[int, str], chaser: str | None, leg: int | None
) -> str | None:
    """The chaser selected by an optional chaser or leg; None if there is only one chaser.

    Parameters
    ----------
    instance : Instance
    whose : mapping of int to str
        The chaser of each leg, by its number; nothing is asked of it where there is one.
    chaser : str, optional
    leg : int, optional
        Says whose it is where no chaser is named.

    Raises
    ------
    InputError
        No chaser has the name, the leg is another one's, or there are several and nothing says
        which.
    """
    names = ", ".join(repr(each.name) for each in instance.chasers)
    if chaser is not None and all(each.name != chaser for each in instance.chasers):
        raise InputError(f"chaser = {chaser!r}: not a chaser of the instance, which has {names}")
    if not several(instance):
        return None
    if leg is not None and leg in whose:
        if chaser not in (None, whose[leg]):
            raise InputError(f"leg = {leg}: it belongs to {whose[leg]!r}, not to {chaser!r}")
        return whose[leg]
    if chaser is None and leg is None:
        raise InputError(f"there are several chasers; name one (--chaser): {names}")
    return chaser


def owners(instance: Instance, plan: Plan) -> dict[int, str]:
    """Name of the chaser of each leg, by leg number; empty if there is only one."""
    if not several(instance):
        return {}
    return {
        number: flown.chaser.name for flown in routes_of(instance, plan) for number, _ in flown.legs
    }


def by_tank(legs: Iterable[Arriving], stations: Collection[str]) -> list[list[Arriving]]:
    """Legs of one chaser by tank; a tank ends with the leg to a station."""
    tanks: list[list[Arriving]] = [[]]
    for leg in legs:
        tanks[-1].append(leg)
        if leg.destination in stations:
            tanks.append([])
    return [of_tank for of_tank in tanks if of_tank]
