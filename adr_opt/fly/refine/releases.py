"""Spirals of a refined plan that release their objects off the disposal orbit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from ...common.constants import EARTH_RADIUS_M
from ...kernels.orbits.gravity import FIELDS
from ...plan.refined_plan import RefinedPlan, RefinedTow
from ...problem.instance import Instance
from ..flight.refined_result import MOST_RELEASE_ECCENTRICITY, MOST_RELEASE_OFF_M
from .near_circle import near_circle
from .states import state_of


class Strayed(NamedTuple):
    """A release off the disposal orbit.

    Attributes
    ----------
    leg : int
        Number of the leg that counts the tow.
    name : str
        Of the object.
    off_m, eccentricity : float
        Mean altitude above that of disposal [m], and mean eccentricity.
    """

    leg: int
    name: str
    off_m: float
    eccentricity: float

    def __str__(self) -> str:
        return (
            f"leg {self.leg}: {self.name} is released {self.off_m:.3g} m off the disposal orbit, "
            f"with an eccentricity of {self.eccentricity:.2g}"
        )


def strayed(instance: Instance, refined: RefinedPlan) -> Iterator[Strayed]:
    """Releases by spirals that ``fly`` does not let hold."""
    for leg in refined.legs:
        tows: list[tuple[str, RefinedTow | None]] = [(leg.destination, leg.tow)]
        if leg.after_launch:
            tows.insert(0, (leg.origin, leg.tow_before))
        for name, tow in tows:
            if tow is None or tow.thrust is None:
                continue
            mean = near_circle(state_of(tow.released), FIELDS[refined.gravity])
            disposal_m = EARTH_RADIUS_M + (instance.mission.disposal_altitude_m or 0.0)
            off_m, eccentricity = float(mean[0]) - disposal_m, math.hypot(mean[1], mean[2])
            if abs(off_m) > MOST_RELEASE_OFF_M or eccentricity > MOST_RELEASE_ECCENTRICITY:
                yield Strayed(leg.leg, name, off_m, eccentricity)
