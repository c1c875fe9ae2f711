"""Drives of chasers with low thrust: what their legs depend on (docs/model.md section 11)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import NamedTuple

from .bodies import Target
from .chasers import Chaser, TankByMass

CLASS_WIDTH = 0.035
"""Width of a class of masses, as a share, where a mission states none."""

J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)


class Drive(NamedTuple):
    """The drive of a chaser with low thrust, and between which masses it works.

    Attributes
    ----------
    thrust_n : float
        Mean over the duty cycle [N].
    exhaust_m_s : float
        g₀ Isp [m/s].
    lightest_kg, heaviest_kg : float
        With an empty tank and no kits, and with a full one and as many kits as the mission has use
        for [kg].
    """

    thrust_n: float
    exhaust_m_s: float
    lightest_kg: float
    heaviest_kg: float

    @property
    def least_acceleration(self) -> float:
        """Acceleration of the heaviest chaser [m/s²]."""
        return self.thrust_n / self.heaviest_kg

    @property
    def largest_acceleration(self) -> float:
        """Acceleration of the lightest chaser [m/s²]."""
        return self.thrust_n / self.lightest_kg

    def classes_kg(self, width: float | None = None) -> tuple[float, ...]:
        """Largest mass of each class of masses, the heaviest first [kg].

        The classes share the range of masses evenly, and none is wider than a share ``width``,
        :data:`CLASS_WIDTH` by default.
        """
        ratio = self.heaviest_kg / self.lightest_kg
        width = CLASS_WIDTH if width is None else width
        count = max(1, math.ceil(math.log(ratio) / math.log1p(width)))
        return tuple(self.heaviest_kg * ratio ** (-at / count) for at in range(count))


def drive_of(chaser: Chaser, targets: Sequence[Target]) -> Drive | None:
    """Drive of a chaser; None if its burns are impulses.

    Parameters
    ----------
    chaser : Chaser
    targets : sequence of Target
        Of its mission, some of which may take kits.
    """
    if chaser.thrust_n is None:
        return None
    tank = chaser.usable
    assert isinstance(tank, TankByMass)
    kits = sum(target.service.takes_kit for target in targets)
    kits = kits if chaser.kits is None else min(kits, chaser.kits)
    if chaser.max_targets is not None:
        kits = min(kits, chaser.max_targets)
    heaviest = tank.dry_mass_kg + tank.propellant_kg + kits * chaser.kit_mass_kg
    duty = 1.0 if chaser.duty_cycle is None else chaser.duty_cycle
    return Drive(duty * chaser.thrust_n, tank.exhaust_m_s, tank.dry_mass_kg, heaviest)


def since_j2000_s(epoch: datetime) -> float:
    """Time from J2000 to an epoch, leap seconds left out [s]."""
    return (epoch.astimezone(UTC) - J2000).total_seconds()
