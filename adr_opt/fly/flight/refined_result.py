"""Result of flying a refined plan."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from ...judge.check.violation import Violation
from ...judge.refined.holding import LEAST_SHARE, SPARE_M_S
from ...judge.refined.thrust import MOST_SHADOW_S
from .flights import TankFlight, WithTanks

MOST_MISS_M, MOST_MISS_M_S = 1.0, 1e-3
"""Largest miss of a stand-off or target at arrival, in position [m] and velocity [m/s]."""

ONTO_MISS_M, ONTO_MISS_M_S = 10.0, 1e-2
"""Largest miss of a plan refined onto ephemerides, at departures as well."""

MOST_RELEASE_OFF_M, MOST_RELEASE_ECCENTRICITY = 1e3, 1e-3
"""Largest difference between the mean altitude at the release of a spiral and that of disposal [m],
and largest mean eccentricity there."""

SPIRAL = ("tow_propellant_kg", "tow_shadow_s", "release_off_m", "release_eccentricity")
"""Fields of legs with a spiral only."""


@dataclass(frozen=True)
class RefinedLegFlight:
    """Flight of one refined leg's burns.

    Attributes
    ----------
    leg : int
        Number of the leg, from 1.
    origin, destination : str
    kind : str
        As of :class:`.Leg`.
    planned_delta_v_m_s, flown_delta_v_m_s : float
        As the plan states it, and the sum of the burns [m/s].
    departure_miss_m : float
        How far the stated state of the departure is from the origin as propagated here, or from
        where the tow of the origin leads [m].
    standoff_miss_m, standoff_miss_m_s : float
        Distance from the stand-off when the approach begins [m], and speed relative to it [m/s].
    arrival_miss_m, arrival_miss_m_s : float
        The same from the target, when the chaser docks.
    tow_miss_m : float or None
        How far the object is released from where that is stated; None if it is not towed [m].
    towing_m_s : float
        What towing it takes, and after a launch what towing the origin took; 0 if neither is
        towed [m/s].
    planned_towing_m_s : float
        The same as planned; burns of a tow are as large as there [m/s].
    planned_propellant_kg, flown_propellant_kg, shadow_s : float or None
        Of a leg of low thrust: what its planned ΔV would take, what it took, and how long thrust
        was on in the Earth's shadow; None of any other.
    tow_propellant_kg, tow_shadow_s, release_off_m, release_eccentricity : float or None
        Of a tow by a spiral: what it took, how long thrust was on in the shadow, the mean altitude
        at its release less that of disposal, and the mean eccentricity there; None of any other.
    departure_miss_m_s : float or None
        Speed of the stated departure relative to the origin, where the plan was refined onto
        ephemerides; else None [m/s].
    holding_delta_v_m_s, holding_found_m_s : float or None
        ΔV of holding beside bodies there, as the plan states it and as it is found here [m/s].
    """

    leg: int
    origin: str
    destination: str
    kind: str
    planned_delta_v_m_s: float
    flown_delta_v_m_s: float
    departure_miss_m: float
    standoff_miss_m: float
    standoff_miss_m_s: float
    arrival_miss_m: float
    arrival_miss_m_s: float
    tow_miss_m: float | None = None
    towing_m_s: float = 0.0
    planned_towing_m_s: float = 0.0
    planned_propellant_kg: float | None = None
    flown_propellant_kg: float | None = None
    shadow_s: float | None = None
    tow_propellant_kg: float | None = None
    tow_shadow_s: float | None = None
    release_off_m: float | None = None
    release_eccentricity: float | None = None
    departure_miss_m_s: float | None = None
    holding_delta_v_m_s: float | None = None
    holding_found_m_s: float | None = None

    @property
    def arrives(self) -> bool:
        """Whether the leg hits its stand-off, its target and, with a tow, the release point.

        Between ephemerides, whether it begins at its origin, too.
        """
        far = max(self.standoff_miss_m, self.arrival_miss_m, self.tow_miss_m or 0.0)
        fast = max(self.standoff_miss_m_s, self.arrival_miss_m_s)
        if self.departure_miss_m_s is None:
            return far <= MOST_MISS_M and fast <= MOST_MISS_M_S
        return (
            max(far, self.departure_miss_m) <= ONTO_MISS_M
            and max(fast, self.departure_miss_m_s) <= ONTO_MISS_M_S
        )

    @property
    def understates_holding(self) -> bool:
        """Whether holding takes more than the plan states."""
        needed = LEAST_SHARE * (self.holding_found_m_s or 0.0) - SPARE_M_S
        return (self.holding_delta_v_m_s or 0.0) < needed

    @property
    def is_in_shadow(self) -> bool:
        """Whether low thrust is on in the Earth's shadow."""
        return max(self.shadow_s or 0.0, self.tow_shadow_s or 0.0) > MOST_SHADOW_S

    @property
    def is_off_disposal(self) -> bool:
        """Whether a spiral ends on another orbit than the circle of disposal."""
        return (
            abs(self.release_off_m or 0.0) > MOST_RELEASE_OFF_M
            or (self.release_eccentricity or 0.0) > MOST_RELEASE_ECCENTRICITY
        )

    def to_dict(self) -> dict[str, Any]:
        """The flight as plain data, with its tow if there is one."""
        content = asdict(self) | {"arrives": self.arrives}
        if self.tow_miss_m is None:
            del content["tow_miss_m"]
        if self.departure_miss_m_s is None:
            for name in ("departure_miss_m_s", "holding_delta_v_m_s", "holding_found_m_s"):
                del content[name]
        if not self.towing_m_s:
            del content["towing_m_s"]
        if self.shadow_s is None:
            for name in ("planned_propellant_kg", "flown_propellant_kg", "shadow_s"):
                del content[name]
        if self.planned_towing_m_s == self.towing_m_s:
            del content["planned_towing_m_s"]
        if self.release_off_m is None:
            for name in SPIRAL:
                del content[name]
        return content


@dataclass(frozen=True)
class RefinedFlight(WithTanks):
    """Result of flying a refined plan.

    Attributes
    ----------
    gravity : {"two-body", "j2", "j3", "j4"}
    legs : tuple of RefinedLegFlight
    tanks : tuple of TankFlight
        Of the legs that were refined.
    missing : tuple of int
        Numbers of the legs that were not.
    violations : tuple of Violation
        That the judge found in the refined plan, where it was asked.
    """

    gravity: str
    legs: tuple[RefinedLegFlight, ...]
    tanks: tuple[TankFlight, ...]
    missing: tuple[int, ...] = ()
    violations: tuple[Violation, ...] = ()

    @property
    def onto_ephemerides(self) -> bool:
        """Whether the states of bodies come from ephemerides."""
        return any(leg.departure_miss_m_s is not None for leg in self.legs)

    @property
    def holding_m_s(self) -> float:
        """Estimated ΔV of holding beside bodies; 0 without ephemerides [m/s]."""
        return sum(leg.holding_delta_v_m_s or 0.0 for leg in self.legs)

    @property
    def limits(self) -> str:
        """Largest tolerated miss, in words."""
        return "10 m or 1 cm/s" if self.onto_ephemerides else "1 m or 1 mm/s"

    @property
    def worst_miss_m(self) -> float:
        """Largest position miss of stand-offs and arrivals; 0 without legs [m]."""
        return max((max(leg.standoff_miss_m, leg.arrival_miss_m) for leg in self.legs), default=0.0)

    @property
    def worst_miss_m_s(self) -> float:
        """Largest velocity miss of stand-offs and arrivals; 0 without legs [m/s]."""
        return max(
            (max(leg.standoff_miss_m_s, leg.arrival_miss_m_s) for leg in self.legs), default=0.0
        )

    @property
    def strayed(self) -> tuple[RefinedLegFlight, ...]:
        """Legs that miss."""
        return tuple(leg for leg in self.legs if not leg.arrives)

    @property
    def in_shadow(self) -> tuple[RefinedLegFlight, ...]:
        """Legs with low thrust in the Earth's shadow."""
        return tuple(leg for leg in self.legs if leg.is_in_shadow)

    @property
    def understated(self) -> tuple[RefinedLegFlight, ...]:
        """Legs that state too little ΔV for holding."""
        return tuple(leg for leg in self.legs if leg.understates_holding)

    @property
    def off_disposal(self) -> tuple[RefinedLegFlight, ...]:
        """Legs whose spirals end on another orbit than the circle of disposal."""
        return tuple(leg for leg in self.legs if leg.is_off_disposal)

    @property
    def holds(self) -> bool:
        """Whether all legs are present and arrive, none thrusts in shadow, and tanks suffice.

        And whether spirals end on the circle of disposal, legs state the ΔV of holding, and the
        judge found nothing.
        """
        wrong = self.missing or self.strayed or self.in_shadow or self.off_disposal
        return not (wrong or self.understated or self.violations or self.broken_tanks)

    @property
    def planned_delta_v_m_s(self) -> float:
        """Planned ΔV of legs and tows [m/s]."""
        return sum(leg.planned_delta_v_m_s + leg.planned_towing_m_s for leg in self.legs)

    @property
    def flown_delta_v_m_s(self) -> float:
        """Flown ΔV of legs and tows [m/s]."""
        return sum(leg.flown_delta_v_m_s + leg.towing_m_s for leg in self.legs)

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data: the output of ``fly --json``."""
        return {
            **({"chasers": [chaser.to_dict() for chaser in self.chasers]} if self.chasers else {}),
            "gravity": self.gravity,
            "worst_miss_m": self.worst_miss_m,
            "worst_miss_m_s": self.worst_miss_m_s,
            "planned_delta_v_m_s": self.planned_delta_v_m_s,
            "flown_delta_v_m_s": self.flown_delta_v_m_s,
            **({"holding_delta_v_m_s": self.holding_m_s} if self.onto_ephemerides else {}),
            "holds": self.holds,
            "missing": list(self.missing),
            "tanks": [tank.to_dict() for tank in self.tanks],
            "legs": [leg.to_dict() for leg in self.legs],
        }
