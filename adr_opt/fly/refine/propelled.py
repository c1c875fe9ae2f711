"""Chasers with low thrust at the beginnings of their legs."""

from __future__ import annotations

from dataclasses import dataclass

from ...kernels.orbits.thrusting import Push
from ...plan.plan import Plan
from ...plan.routes import routes_of
from ...problem.drives import Drive, drive_of, since_j2000_s
from ...problem.instance import Instance


@dataclass(frozen=True)
class Propelled:
    """A chaser with low thrust at the beginning of a leg.

    Attributes
    ----------
    drive : Drive
    mass_kg : float
    since_j2000_s : float
        The epoch of the mission.
    """

    drive: Drive
    mass_kg: float
    since_j2000_s: float

    def pushes(self) -> tuple[Push, ...]:
        """Its thrust: with the acceleration of the heaviest chaser, as planned, or all of it."""
        drive = self.drive
        shares = dict.fromkeys((min(1.0, self.mass_kg / drive.heaviest_kg), 1.0))
        return tuple(
            Push(share * drive.thrust_n, drive.exhaust_m_s, self.mass_kg, self.since_j2000_s)
            for share in shares
        )


def propelled_by_leg(instance: Instance, plan: Plan) -> dict[int, Propelled]:
    """The chaser of each leg of low thrust, by number of the leg, as heavy as planned."""
    since, found = since_j2000_s(instance.epoch), {}
    for flown in routes_of(instance, plan):
        drive = drive_of(flown.chaser, instance.targets)
        if drive is None:
            continue
        for (number, _), aboard in zip(flown.legs, flown.aboard(instance), strict=False):
            mass = drive.lightest_kg if aboard.mass_kg is None else aboard.mass_kg
            found[number] = Propelled(drive, max(mass, drive.lightest_kg), since)
    return found
