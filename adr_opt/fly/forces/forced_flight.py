"""Result of flying a refined plan with all forces."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

from ..flight.flights import TankFlight, WithTanks, whole_sum
from .settings import Forces


@dataclass(frozen=True)
class Off:
    """Arrival at a stand-off without corrections, and what a correction takes.

    Attributes
    ----------
    radial_m, along_m, across_m : float
        Of the chaser from the stand-off: outward, ahead and along the momentum [m].
    speed_m_s : float
        Relative to it [m/s].
    correction_m_s : float or None
        ΔV of the least correction in the last revolution before; None if none is found [m/s].
    """

    radial_m: float
    along_m: float
    across_m: float
    speed_m_s: float
    correction_m_s: float | None

    @property
    def distance_m(self) -> float:
        """Distance from the stand-off [m]."""
        return math.hypot(self.radial_m, self.along_m, self.across_m)

    def to_dict(self) -> dict[str, Any]:
        """The arrival as plain data."""
        return {"distance_m": self.distance_m, **asdict(self)}


@dataclass(frozen=True)
class ForcedLeg:
    """Flight of one leg.

    Attributes
    ----------
    leg : int
        Number of the leg, from 1.
    origin, destination : str
    kind : str
    flown_delta_v_m_s : float
        Of its burns and arcs [m/s].
    planned_body : Off or None
        From the stand-off where the refined plan has its body; None where the leg does not last.
    flown_body : Off or None
        From that of the body under the same forces since the departure of the leg.
    lost : str or None
        Why the leg does not last to its stand-off: mostly, that drag lets it fall.
    """

    leg: int
    origin: str
    destination: str
    kind: str
    flown_delta_v_m_s: float
    planned_body: Off | None
    flown_body: Off | None
    lost: str | None = None

    @property
    def is_corrected(self) -> bool:
        """Whether the flight lasts, and a correction to the planned body is found."""
        return self.planned_body is not None and self.planned_body.correction_m_s is not None

    def to_dict(self) -> dict[str, Any]:
        """The flight as plain data; ``lost`` only where it is."""
        content = asdict(self)
        if self.lost is None:
            del content["lost"]
        for name in ("planned_body", "flown_body"):
            off: Off | None = getattr(self, name)
            content[name] = None if off is None else off.to_dict()
        return content


@dataclass(frozen=True)
class ForcedFlight(WithTanks):
    """Result of flying a refined plan with all forces.

    Attributes
    ----------
    forces : Forces
    gravity : {"two-body", "j2", "j3", "j4"}
        Field of the refined plan.
    legs : tuple of ForcedLeg
    tanks : tuple of TankFlight
        Of the burns and the corrections to the planned bodies.
    missing : tuple of int
        Numbers of the legs that were not refined.
    """

    forces: Forces
    gravity: str
    legs: tuple[ForcedLeg, ...]
    tanks: tuple[TankFlight, ...]
    missing: tuple[int, ...] = ()

    @property
    def flown_delta_v_m_s(self) -> float:
        """ΔV of the burns of the legs [m/s]."""
        return math.fsum(leg.flown_delta_v_m_s for leg in self.legs)

    @property
    def correction_m_s(self) -> float | None:
        """ΔV of corrections to the planned bodies; None if one is unknown [m/s]."""
        return total(leg.planned_body for leg in self.legs)

    @property
    def body_correction_m_s(self) -> float | None:
        """ΔV of corrections to the bodies under the same forces; None if one is unknown [m/s]."""
        return total(leg.flown_body for leg in self.legs)

    @property
    def worst_off_m(self) -> float:
        """Largest distance from a stand-off of a planned body; 0 without legs that last [m]."""
        return _farthest(leg.planned_body for leg in self.legs)

    @property
    def worst_body_off_m(self) -> float:
        """Largest distance from a stand-off of a body under the same forces [m]."""
        return _farthest(leg.flown_body for leg in self.legs)

    @property
    def uncorrected(self) -> tuple[ForcedLeg, ...]:
        """Legs that do not last, or for which no correction to the planned body is found."""
        return tuple(leg for leg in self.legs if not leg.is_corrected)

    @property
    def holds(self) -> bool:
        """Whether all legs are present and corrected, and tanks suffice."""
        return not (self.missing or self.uncorrected or self.broken_tanks)

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data: the output of ``fly --forces full --json``."""
        return {
            **({"chasers": [chaser.to_dict() for chaser in self.chasers]} if self.chasers else {}),
            "forces": self.forces.to_dict(),
            "gravity": self.gravity,
            "worst_off_m": self.worst_off_m,
            "worst_body_off_m": self.worst_body_off_m,
            "flown_delta_v_m_s": self.flown_delta_v_m_s,
            "correction_m_s": self.correction_m_s,
            "body_correction_m_s": self.body_correction_m_s,
            "holds": self.holds,
            "missing": list(self.missing),
            "tanks": [tank.to_dict() for tank in self.tanks],
            "legs": [leg.to_dict() for leg in self.legs],
        }


def total(arrivals: Iterable[Off | None]) -> float | None:
    """Sum of corrections; None if one is unknown [m/s]."""
    return whole_sum(None if one is None else one.correction_m_s for one in arrivals)


def _farthest(arrivals: Iterable[Off | None]) -> float:
    return max((one.distance_m for one in arrivals if one is not None), default=0.0)
