"""How long released objects stay in orbit, by the decay model of :mod:`adr_opt.problem.air`.

Released are objects that are towed, and those that a kit with an orbit of disposal of its own
brings down after the chaser has left: what it does is stated and not flown (docs/model.md section
5.4).
"""

from __future__ import annotations

import numpy as np

from ..common.constants import EARTH_RADIUS_M
from ..problem.air import lifetimes
from ..problem.bodies import Target
from ..problem.disposal import DisposalCircle, comes_down_at_once
from ..problem.drives import Drive
from ..problem.instance import Instance
from .tows import removals_of

ASSUMED_AREA_TO_MASS_M2_KG = 0.01
"""Area-to-mass ratio of an object whose file states none [m²/kg]."""

ACTIVITY, MOST_YEARS = "mean", 1000.0
"""Solar activity, and the lifetime at which longer ones are cut off [years]."""


def apsides_of(target: Target) -> tuple[float, float]:
    """Radii of perigee and apogee that the kit of a target leads to [m]."""
    orbit, disposal = target.orbit, target.disposal
    assert orbit is not None
    if isinstance(disposal, DisposalCircle):
        return (EARTH_RADIUS_M + disposal.circle_m,) * 2
    low = orbit.semi_major_axis_m * (1.0 - orbit.eccentricity)
    if disposal is not None:
        low = min(low, EARTH_RADIUS_M + disposal.perigee_m)
    return low, orbit.semi_major_axis_m * (1.0 + orbit.eccentricity)


def shells_of(instance: Instance, drive: Drive | None) -> dict[int, tuple[float, float]]:
    """Radii of perigee and apogee on which objects are released, by number of the body [m].

    Parameters
    ----------
    instance : Instance
    drive : Drive or None
        Of the chasers, which all release objects on the same orbits.
    """
    shells = {body: tow.released_m for body, tow in removals_of(instance, drive).items()}
    for body, target in enumerate(instance.targets, start=instance.first_target):
        if target.service.takes_kit and target.disposal is not None and target.orbit is not None:
            shells[body] = apsides_of(target)
    return shells


def lifetimes_years(
    instance: Instance, drive: Drive | None, activity: str = ACTIVITY
) -> dict[int, float]:
    """Lifetimes of released objects, by number of the body [years]; at most :data:`MOST_YEARS`."""
    shells = shells_of(instance, drive)
    areas = [instance.targets[body - instance.first_target].area_to_mass_m2_kg for body in shells]
    years = lifetimes(
        np.array(list(shells.values())).reshape(-1, 2),
        np.array([ASSUMED_AREA_TO_MASS_M2_KG if area is None else area for area in areas]),
        activity,
        MOST_YEARS,
    )
    return dict(zip(shells, years.tolist(), strict=True))


def unreleasable(instance: Instance, drive: Drive | None) -> frozenset[int]:
    """Bodies that must not be released, as they would stay too long or re-enter uncontrolled.

    They would stay in orbit longer than the mission allows, or are heavier than what may re-enter
    without control, as those of unknown mass are, and would not come down at once.
    """
    years, kg = instance.mission.max_lifetime_years, instance.mission.max_uncontrolled_kg
    found = set[int]()
    if years is not None:
        found |= {body for body, each in lifetimes_years(instance, drive).items() if each > years}
    if kg is not None:
        for body, (perigee_m, _) in shells_of(instance, drive).items():
            mass_kg = instance.targets[body - instance.first_target].mass_kg
            if (mass_kg is None or mass_kg > kg) and not comes_down_at_once(perigee_m):
                found.add(body)
    return frozenset(found)
