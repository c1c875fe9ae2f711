"""Result of flying a plan."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any, Literal

from ...judge.check.violation import DELTA_V_TOLERANCE_M_S, Violation
from ...plan.leg_kinds import leg_kind


@dataclass(frozen=True)
class LegFlight:
    """Flight of one leg's burns.

    Attributes
    ----------
    leg : int
        Number of the leg, from 1.
    origin, destination : str
    kind : str
        As of :class:`.Leg`.
    planned_delta_v_m_s : float
        As the plan states it; of a drift that of its closed form [m/s].
    burns_delta_v_m_s : float
        Sum of the burns that are flown [m/s].
    miss_m : float
        Distance from the stand-off point, the point L behind the destination on its orbit, when
        the approach begins, on the circles that are planned with [m].
    relative_speed_m_s : float
        Speed relative to that point, before the first impulse of the approach [m/s].
    arrival_miss_m : float
        Distance from the destination at the end of the approach [m]. Some centimetres at
        L = 1 km: the approach is a solution of the Clohessy–Wiltshire equations, which are linear
        in the distance, so this miss grows with L². Under J2 decimetres where orbits are eccentric,
        whose latitudes do not advance quite as those of circles.
    on_true_orbits : bool
        Whether an orbit is eccentric, so that the leg was flown on the true ones as well.
    true_delta_v_m_s : float or None
        What its burns take there, aimed anew; None where they do not arrive, or there was no such
        flight [m/s].
    """

    leg: int
    origin: str
    destination: str
    kind: str
    planned_delta_v_m_s: float = 0.0
    burns_delta_v_m_s: float = 0.0
    miss_m: float = 0.0
    relative_speed_m_s: float = 0.0
    arrival_miss_m: float = 0.0
    on_true_orbits: bool = False
    true_delta_v_m_s: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """The flight as plain data."""
        told = asdict(self)
        if not told.pop("on_true_orbits"):
            del told["true_delta_v_m_s"]
        return told


@dataclass(frozen=True)
class TankFlight:
    """Use of one tank: the legs from one refuelling to the next, the latter included.

    Attributes
    ----------
    tank : int
        Number of the tank, from 1, of its chaser.
    first_leg, last_leg : int
        Numbers of its legs, from 1.
    budget_m_s : float
        ΔV of a full tank [m/s].
    planned_delta_v_m_s : float
        What the plan states for these legs [m/s].
    flown_delta_v_m_s : float or None
        What they cost when flown: of legs that drift the burns; on the true orbits, where some are
        eccentric, those that are aimed anew; None if a leg does not arrive [m/s].
    chaser : str or None
        Whose tank it is; None where there is one chaser.
    """

    tank: int
    first_leg: int
    last_leg: int
    budget_m_s: float
    planned_delta_v_m_s: float
    flown_delta_v_m_s: float | None
    chaser: str | None = None

    @property
    def over_m_s(self) -> float | None:
        """ΔV missing from the tank, negative if some is left; None if unknown [m/s]."""
        flown = self.flown_delta_v_m_s
        return None if flown is None else flown - self.budget_m_s

    @property
    def holds(self) -> bool:
        """Whether the tank is known to suffice."""
        return self.over_m_s is not None and self.over_m_s <= DELTA_V_TOLERANCE_M_S

    def to_dict(self) -> dict[str, Any]:
        """The tank as plain data, with the chaser if there are several."""
        told = asdict(self) | {"over_m_s": self.over_m_s, "holds": self.holds}
        return of_chaser(told)

    def __str__(self) -> str:
        legs = legs_named(self.first_leg, self.last_leg)
        tank = tank_name(self.tank, self.chaser)
        if self.over_m_s is None:
            return f"{tank} ({legs}) has a leg that was not guided to its target"
        budget = f"{self.budget_m_s:g} m/s"
        if self.holds:
            return f"{tank} ({legs}) is left with {-self.over_m_s:.1f} of {budget}"
        return f"{tank} ({legs}) of {budget} is over by {self.over_m_s:.1f} m/s"


def whole_sum(values: Iterable[float | None]) -> float | None:
    """Sum of values; None if one is unknown."""
    listed = list(values)
    known = [value for value in listed if value is not None]
    return math.fsum(known) if len(known) == len(listed) else None


def legs_named(first: int, last: int) -> str:
    """The name of consecutive legs."""
    return f"legs {first} to {last}" if last > first else f"leg {first}"


def tank_name(number: int, chaser: str | None) -> str:
    """The name of a tank."""
    return f"tank {number}" if chaser is None else f"tank {number} of {chaser!r}"


def of_chaser(told: dict[str, Any]) -> dict[str, Any]:
    """Plain data with the chaser first, or without it if there is only one."""
    chaser = told.pop("chaser")
    return told if chaser is None else {"chaser": chaser, **told}


@dataclass(frozen=True)
class ChaserFlight:
    """Totals of one of several chasers.

    Attributes
    ----------
    chaser : str
    first_leg, last_leg : int
        Numbers of its legs.
    planned_delta_v_m_s : float
        As the plan states it [m/s].
    flown_delta_v_m_s : float or None
        What its tanks gave; None if that is unknown of one [m/s].
    holds : bool
        Whether all its tanks do.
    """

    chaser: str
    first_leg: int
    last_leg: int
    planned_delta_v_m_s: float
    flown_delta_v_m_s: float | None
    holds: bool

    def to_dict(self) -> dict[str, Any]:
        """The totals as plain data."""
        return asdict(self)

    def __str__(self) -> str:
        legs = legs_named(self.first_leg, self.last_leg)
        flown = self.flown_delta_v_m_s
        told = "unknown" if flown is None else f"{flown:.1f}"
        return (
            f"{self.chaser} ({legs}): planned with {self.planned_delta_v_m_s:.1f} m/s, flown with "
            f"{told} m/s: {'every tank holds' if self.holds else 'a tank is not enough'}"
        )


def chasers_of(tanks: Iterable[TankFlight]) -> tuple[ChaserFlight, ...]:
    """Chasers of some tanks, without those that fly no legs; empty if there is only one."""
    found: dict[str, list[TankFlight]] = {}
    for tank in tanks:
        if tank.chaser is not None:
            found.setdefault(tank.chaser, []).append(tank)
    told = []
    for chaser, its in found.items():
        told.append(
            ChaserFlight(
                chaser,
                its[0].first_leg,
                its[-1].last_leg,
                math.fsum(tank.planned_delta_v_m_s for tank in its),
                whole_sum(tank.flown_delta_v_m_s for tank in its),
                all(tank.holds for tank in its),
            )
        )
    return tuple(told)


class WithTanks:
    """Properties of a flight that follow from its ``tanks``."""

    tanks: tuple[TankFlight, ...]

    @property
    def broken_tanks(self) -> tuple[TankFlight, ...]:
        """Tanks that do not suffice."""
        return tuple(tank for tank in self.tanks if not tank.holds)

    @property
    def chasers(self) -> tuple[ChaserFlight, ...]:
        """Totals by chaser; empty if there is only one."""
        return chasers_of(self.tanks)


@dataclass(frozen=True)
class Flight(WithTanks):
    """Result of flying a plan.

    Attributes
    ----------
    worst_miss_m : float
        Largest stand-off miss of all legs; 0 for a plan without legs [m].
    legs : tuple of LegFlight
    tanks : tuple of TankFlight
    dynamics : {"two-body", "j2"}
        In which the legs were flown.
    violations : tuple of Violation
        That `check` found in the plan, where it was asked.
    """

    worst_miss_m: float
    legs: tuple[LegFlight, ...]
    tanks: tuple[TankFlight, ...] = ()
    dynamics: Literal["two-body", "j2"] = "two-body"
    violations: tuple[Violation, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether all tanks suffice, and `check` found nothing."""
        return not (self.broken_tanks or self.violations)

    @property
    def drifts(self) -> tuple[LegFlight, ...]:
        """The drift legs."""
        return tuple(leg for leg in self.legs if leg_kind(leg.kind).on_time_grid)

    @property
    def true_legs(self) -> tuple[LegFlight, ...]:
        """Legs that were also flown on true orbits."""
        return tuple(leg for leg in self.legs if leg.on_true_orbits)

    @property
    def true_delta_v_m_s(self) -> float | None:
        """ΔV of :attr:`true_legs` on true orbits; None if any does not arrive [m/s]."""
        return whole_sum(leg.true_delta_v_m_s for leg in self.true_legs)

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data: the output of ``fly --json``."""
        told: dict[str, Any] = {"dynamics": self.dynamics, "worst_miss_m": self.worst_miss_m}
        if self.dynamics == "j2":
            # Former versions flew legs of eccentric orbits between circles alone.
            told["between_circles"] = False
        if self.true_legs:
            told["true_delta_v_m_s"] = self.true_delta_v_m_s
        if self.chasers:
            told["chasers"] = [chaser.to_dict() for chaser in self.chasers]
        return told | {
            "holds": self.holds,
            "tanks": [tank.to_dict() for tank in self.tanks],
            "legs": [leg.to_dict() for leg in self.legs],
        }
