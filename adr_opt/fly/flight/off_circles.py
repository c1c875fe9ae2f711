"""How far true orbits are from the circles that plans are made between."""

from __future__ import annotations

from typing import NamedTuple

from ...plan.plan import Plan
from ...problem.instance import Instance

TOLD_M = 1e3
"""Distance from which it is told."""


class OffCircles(NamedTuple):
    """Legs of a plan on eccentric orbits.

    Attributes
    ----------
    legs : int
    eccentricity : float
        The largest.
    distance_m : float
        The largest distance of a true position from that on the circle.
    """

    legs: int
    eccentricity: float
    distance_m: float

    def __str__(self) -> str:
        one = self.legs == 1
        return (
            f"{self.legs} leg{' is' if one else 's are'} on eccentric orbits, up to "
            f"{self.eccentricity:.2g}, and planned between circles, from which bodies are up to "
            f"{self.distance_m / 1e3:.3g} km away: as they are, burns miss by kilometres; "
            "'refine' aims them"
        )


def off_circles(instance: Instance, plan: Plan) -> OffCircles | None:
    """The legs of a plan on eccentric orbits; None if none is away from circles by kilometres.

    At the same mean anomaly a body is away from its circle by at most 2 a e, to first order.
    """
    orbits = dict(zip(instance.names, instance.known_orbits, strict=True))
    legs, eccentricity, distance_m = 0, 0.0, 0.0
    for leg in plan.legs:
        ends = [orbits.get(name) for name in (leg.origin, leg.destination)]
        if not leg.traits.has_burns or all(not end or not end.eccentricity for end in ends):
            continue
        legs += 1
        for end in ends:
            if end is not None:
                eccentricity = max(eccentricity, end.eccentricity)
                distance_m = max(distance_m, 2.0 * end.semi_major_axis_m * end.eccentricity)
    return OffCircles(legs, eccentricity, distance_m) if distance_m >= TOLD_M else None
