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
    class_kg : float
        Largest mass of its class, by which the leg is planned.
    """

    drive: Drive
    mass_kg: float
    since_j2000_s: float
    class_kg: float

    def towing(self, object_kg: float) -> Push:
        """All of its thrust, with an object attached."""
        drive = self.drive
        both = self.mass_kg + object_kg
        return Push(drive.thrust_n, drive.exhaust_m_s, both, self.since_j2000_s)

    def pushes(self) -> tuple[Push, ...]:
        """Its thrust: with the acceleration of its class, as planned, or all of it."""
        drive = self.drive
        shares = dict.fromkeys((min(1.0, self.mass_kg / self.class_kg), 1.0))
        return tuple(
            Push(share * drive.thrust_n, drive.exhaust_m_s, self.mass_kg, self.since_j2000_s)
            for share in shares
        )


def propelled_by_leg(instance: Instance, plan: Plan) -> dict[int, Propelled]:
    """The chaser of each leg of low thrust, by number of the leg, as heavy as planned."""
    return {number: before for number, (before, _) in _propelled(instance, plan).items()}


def towing_by_leg(instance: Instance, plan: Plan) -> dict[int, Propelled]:
    """The same after the service of the leg, and before a tow that follows."""
    return {number: after for number, (_, after) in _propelled(instance, plan).items()}


def _propelled(instance: Instance, plan: Plan) -> dict[int, tuple[Propelled, Propelled]]:
    since, found = since_j2000_s(instance.epoch), {}
    for flown in routes_of(instance, plan):
        drive = drive_of(flown.chaser, instance.targets)
        if drive is None:
            continue

        def of(mass: float, class_kg: float | None, drive: Drive = drive) -> Propelled:
            most = drive.heaviest_kg if class_kg is None else class_kg
            return Propelled(drive, max(mass, drive.lightest_kg), since, most)

        stages = flown.aboard(instance)[1:]
        for (number, leg), begins_kg, after in zip(
            flown.legs, flown.departing_kg(instance), stages, strict=False
        ):
            ends_kg = (after.mass_kg or 0.0) + after.removal_kg
            found[number] = of(begins_kg, leg.mass_class_kg), of(ends_kg, None)
    return found
