"""Altitudes of a chaser beside bodies, on their orbits as they have decayed by then.

Burns of plans lead from circle to circle, whose limits :mod:`.leg` checks. Where a chaser is docked
it goes as low as the body: to the perigee of the true orbit, which sinks with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...common.constants import DAY_S, EARTH_RADIUS_M
from ...plan.plan import Leg
from ...problem.instance import Instance
from .violation import ALTITUDE_TOLERANCE_M, Violation


class Heights:
    """Lowest altitudes of bodies, and the limits on them.

    Parameters
    ----------
    instance : Instance
    """

    def __init__(self, instance: Instance) -> None:
        self._least_m = instance.transfer.min_altitude_m
        self._orbits = dict(zip(instance.names, instance.known_orbits, strict=True))
        self._decays = dict(zip(instance.names, instance.decays_m_per_day, strict=True))
        self._offsets = {
            target.name: math.hypot(*target.fit.eccentricity_offset)
            for target in instance.targets
            if target.fit is not None
        }

    def perigee_m(self, name: str, time_s: float) -> float:
        """Altitude of the perigee of a body at a time [m]."""
        orbit = self._orbits[name]
        assert orbit is not None  # legs between bodies without one are given
        axis = orbit.semi_major_axis_m - self._decays[name] * time_s / DAY_S
        eccentricity = orbit.eccentricity + self._offsets.get(name, 0.0)
        return axis * (1.0 - eccentricity) - EARTH_RADIUS_M

    def least_m(self, name: str) -> float:
        """Least altitude beside a body: the limit, or its circle, if that begins below [m]."""
        orbit = self._orbits[name]
        assert orbit is not None
        return min(self._least_m, orbit.semi_major_axis_m - EARTH_RADIUS_M)

    def check(
        self, number: int, leg: Leg, arrival_s: float, until_s: float, *, led: bool
    ) -> Iterator[Violation]:
        """Check the altitudes beside both bodies of a leg.

        Parameters
        ----------
        arrival_s, until_s : float
            The stay at the destination, up to the end of the service or the beginning of a tow [s].
        led : bool
            Whether the chaser comes from a disposal orbit or from nowhere, not from the origin.
        """
        found = [(leg.destination, time_s) for time_s in (arrival_s, until_s)]
        if not led:
            found.insert(0, (leg.origin, leg.leaves_s))
        for name, time_s in found:
            low_m, least_m = self.perigee_m(name, time_s), self.least_m(name)
            if low_m < least_m - ALTITUDE_TOLERANCE_M:
                yield Violation(
                    number,
                    "altitude",
                    f"{name!r} comes down to {low_m / 1e3:.1f} km at {time_s:.0f} s, below "
                    f"the limit of {least_m / 1e3:g} km",
                )
                return
