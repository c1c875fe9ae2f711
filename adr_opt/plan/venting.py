"""Propellant that chasers with low thrust vent, or do not load (docs/model.md section 11.4).

A leg of a class of masses can be flown by a chaser that is no heavier at its departure. One that
would be vents propellant at the start of that tank: then it is lighter, and no worse off, on all
legs before as well.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from ..problem.chasers import Chaser, TankByMass
from ..problem.drives import drive_of
from ..problem.instance import Instance
from .cargo import followed
from .plan import Leg
from .tows import removals_by_name

LEAST_KG = 1e-9
"""Amount of propellant below which nothing is vented: it is due to rounding [kg]."""


def vented(instance: Instance, chaser: Chaser, legs: Iterable[Leg]) -> Iterator[Leg]:
    """Legs of a chaser with vented propellant, so that each is flown with a mass of its class.

    Parameters
    ----------
    instance : Instance
    chaser : Chaser
    legs : iterable of Leg
        Whose tank suffices for their classes.
    """
    legs, tank = tuple(legs), chaser.usable
    if not isinstance(tank, TankByMass) or all(leg.mass_class_kg is None for leg in legs):
        yield from legs
        return
    most_kg = _most_kg(instance, chaser, tank, legs)
    # The mass at the start of a tank does not depend on what is vented before it.
    stages = followed(instance, chaser, [(leg.destination, leg.delta_v_m_s) for leg in legs])
    starts = True
    for leg, stage, most in zip(legs, stages, most_kg, strict=False):
        excess = (stage.mass_kg or 0.0) - most if starts else 0.0
        yield leg.replace(vented_kg=excess) if excess > LEAST_KG else leg
        starts = leg.destination in instance.station_names


def _most_kg(
    instance: Instance, chaser: Chaser, tank: TankByMass, legs: Sequence[Leg]
) -> list[float]:
    """Largest mass before each leg with which it and the later legs of the tank can be flown."""
    takers = {target.name for target in instance.targets if target.service.takes_kit}
    tows, exhaust = removals_by_name(instance, drive_of(chaser, instance.targets)), tank.exhaust_m_s
    after, found = math.inf, []
    for leg in reversed(legs):
        if leg.destination in instance.station_names:
            after = math.inf
        elif leg.destination in takers:
            after += chaser.kit_mass_kg
        elif leg.destination in tows:
            after = tows[leg.destination].needed_kg(after, exhaust)
        class_kg = math.inf if leg.mass_class_kg is None else leg.mass_class_kg
        after = min(class_kg, after * math.exp(leg.delta_v_m_s / exhaust))
        found.append(after)
    return found[::-1]
