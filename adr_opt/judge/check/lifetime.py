"""How long released objects stay in orbit, restated: drag integrated over steps of the perigee.

King-Hele's mean rates of semi-major axis and eccentricity, as integrals over the true anomaly where
:mod:`adr_opt.kernels.orbits.decay` has them over the eccentric one, and steps of second order.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...plan.lifetimes import ASSUMED_AREA_TO_MASS_M2_KG, apsides_of
from ...problem.air import DRAG_COEFFICIENT, YEAR_S, table
from ...problem.bodies import Target
from ...problem.instance import Instance
from .towed import Towed
from .violation import Violation

ANOMALIES = (np.arange(256) + 0.5) * (math.pi / 256)
"""True anomalies of half a revolution."""

STEP, MOST_STEPS = 0.05, 20_000
"""Fall of the perigee in a step, in scale heights of the air, and the number of steps."""

CONTROLLED_M, AIMED_M = 60e3, 1.0
"""Highest perigee from which an object re-enters at once, and its tolerance for rounding [m]."""

BEYOND, NEAR = 1.01, 0.95
"""Shares of the longest lifetime: above the first, an object stays too long; below the second,
planners, whose closed form is up to a few per cent high, do not reject it either."""


def check_lifetime(
    instance: Instance, number: int, target: Target | None, towed: Towed | None
) -> Iterator[Violation]:
    """Check that an object which is released at the end of a leg does not stay too long.

    And that one which is too heavy for that does not come down anywhere.

    Parameters
    ----------
    target : Target or None
        The destination of the leg, if it is one.
    towed : Towed or None
        The destination, where it is towed.
    """
    if target is not None and outstays(instance, target, towed, BEYOND):
        yield Violation(
            number,
            "lifetime",
            f"{target.name!r} is released on an orbit where it stays longer than "
            f"{instance.mission.max_lifetime_years:g} years",
        )
    if target is not None and is_uncontrolled(instance, target, towed, CONTROLLED_M + AIMED_M):
        yield Violation(
            number,
            "uncontrolled",
            f"{target.name!r} has more than {instance.mission.max_uncontrolled_kg:g} kg, or an "
            f"unknown mass, and is released with its perigee above {CONTROLLED_M / 1e3:g} km",
        )


def is_uncontrolled(instance: Instance, target: Target, towed: Towed | None, most_m: float) -> bool:
    """Whether an object too heavy for uncontrolled re-entry is released above a perigee."""
    most_kg, apsides = instance.mission.max_uncontrolled_kg, _released_m(target, towed)
    if most_kg is None or apsides is None:
        return False
    heavy = target.mass_kg is None or target.mass_kg > most_kg
    return heavy and min(apsides) > EARTH_RADIUS_M + most_m


def _released_m(target: Target, towed: Towed | None) -> tuple[float, float] | None:
    """Radii of perigee and apogee on which an object is released; None if it is not [m]."""
    if towed is not None:
        return towed.released_m
    is_stated = target.removal == "kit" and target.disposal is not None
    return apsides_of(target) if is_stated else None


def outstays(instance: Instance, target: Target, towed: Towed | None, share: float) -> bool:
    """Whether an object is released that stays longer than a share of the longest lifetime."""
    most, apsides = instance.mission.max_lifetime_years, _released_m(target, towed)
    if most is None or apsides is None:
        return False
    stated = target.area_to_mass_m2_kg
    area = ASSUMED_AREA_TO_MASS_M2_KG if stated is None else stated
    return lifetime_years(apsides, area, share * most) > share * most


def lifetime_years(apsides_m: tuple[float, float], area_to_mass: float, most: float) -> float:
    """Lifetime of an object by drag; anything above ``most`` for longer ones [years].

    Parameters
    ----------
    apsides_m : (float, float)
        Radii of perigee and apogee [m].
    area_to_mass : float
        [m²/kg].
    most : float
        [years].
    """
    altitudes, logs = table("mean")
    state, years = np.array(apsides_m), 0.0
    ballistic = DRAG_COEFFICIENT * area_to_mass

    def rates(state: np.ndarray) -> np.ndarray:
        """Rates of both radii [m/s]."""
        axis, e = 0.5 * (state[0] + state[1]), (state[1] - state[0]) / (state[0] + state[1])
        cosine = np.cos(ANOMALIES)
        radius = axis * (1.0 - e * e) / (1.0 + e * cosine)
        density = np.exp(_log_density(radius - EARTH_RADIUS_M, altitudes, logs))
        speed = np.sqrt(MU_M3_S2 * (2.0 / radius - 1.0 / axis))
        # Of the time of a revolution that at an anomaly goes with the square of the radius.
        share = radius**2 / np.sum(radius**2)
        slower = ballistic * density * speed * share
        axis_rate = -float(np.sum(slower * speed * speed)) * axis * axis / MU_M3_S2
        e_rate = -float(np.sum(slower * (e + cosine)))
        return np.array(
            [axis_rate * (1.0 - e) - axis * e_rate, axis_rate * (1.0 + e) + axis * e_rate]
        )

    for _ in range(MOST_STEPS):
        height = state[0] - EARTH_RADIUS_M
        if height <= altitudes[0] or years > most:
            return years
        falls = rates(state)
        at = min(int(np.searchsorted(altitudes, height, "right")), altitudes.size - 1)
        scale = -(altitudes[at] - altitudes[at - 1]) / (logs[at] - logs[at - 1])
        wide = max(state[1] - state[0], scale)
        step = STEP * min(scale / -falls[0], wide / max(-falls[1], 1e-300))
        halfway = np.sort(state + 0.5 * step * falls)
        state = np.sort(state + step * rates(halfway))
        years += step / YEAR_S
    return math.inf


def _log_density(altitude: np.ndarray, altitudes: np.ndarray, logs: np.ndarray) -> np.ndarray:
    """Logarithms of densities [ln kg/m³], continued beyond the table as by its last two rows."""
    found: np.ndarray = np.interp(altitude, altitudes, logs)
    for end, inner in ((0, 1), (-1, -2)):
        slope = (logs[end] - logs[inner]) / (altitudes[end] - altitudes[inner])
        beyond = altitude < altitudes[0] if end == 0 else altitude > altitudes[-1]
        found = np.where(beyond, logs[end] + slope * (altitude - altitudes[end]), found)
    return found
