"""Size of the plane drift under J2 that a two-body instance neglects."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..common.constants import DAY_S, EARTH_RADIUS_M, J2, MU_M3_S2
from ..kernels.orbits import elements
from ..kernels.orbits.ephemeris import EPOCH_S
from ..problem.instance import Instance
from .plan import Plan

LEAST_DEG = 0.1
LEAST_SHARE = 0.01
"""Thresholds of a warning: drift of the planes, and its share of a plan's ΔV."""

MOST_RATES = 1000
"""Largest number of bodies whose pairs are all compared; of more, an evenly spread sample."""


def node_rates(instance: Instance) -> npt.NDArray[np.float64]:
    """Secular rates of the nodes under J2, −(3/2) J2 n (R/p)² cos i, shape (bodies,) [rad/s]."""
    orbits = instance.body_orbits
    axes = np.array([orbit.semi_major_axis_m for orbit in orbits])
    parameters = axes * (1.0 - np.array([orbit.eccentricity for orbit in orbits]) ** 2)
    cosines = np.cos(np.radians([orbit.inclination_deg for orbit in orbits]))
    motions = np.sqrt(MU_M3_S2 / axes**3)
    rates: npt.NDArray[np.float64] = (
        -1.5 * J2 * motions * (EARTH_RADIUS_M / parameters) ** 2 * cosines
    )
    return rates


def drift_warning(instance: Instance, plan: Plan | None = None) -> str | None:
    """A sentence about the drift of the nodes, or None if it is negligible.

    None also under J2, where the model includes it, and where costs are given.

    Parameters
    ----------
    instance : Instance
        Without a plan all pairs of its bodies are examined, over the whole mission.
    plan : Plan, optional
        The origin and the destination of each leg are examined, from the epoch to the departure.
        Its destinations must be bodies of the instance.
    """
    if instance.dynamics == "j2" or instance.transfer.given is not None:
        return None
    rates = node_rates(instance)
    turn_m_s = _turn_m_s(instance)
    if plan is None:
        return _of_all_pairs(rates, turn_m_s, instance.mission.duration_s)
    index = {name: number for number, name in enumerate(instance.names)}
    ends = np.array([(index[leg.origin], index[leg.destination]) for leg in plan.legs], dtype=int)
    if not ends.size:
        return None
    times = np.array([leg.departure_s for leg in plan.legs])
    apart = np.abs(rates[ends[:, 1]] - rates[ends[:, 0]]) * times
    worth = float(np.sum(apart * turn_m_s[ends].mean(axis=1)))
    most_deg = float(np.degrees(apart.max()))
    if most_deg < LEAST_DEG and worth < LEAST_SHARE * plan.delta_v_m_s:
        return None
    return (
        "nodes drift under J2, which the model neglects: when this plan flies its legs, their "
        f"planes have moved by up to {most_deg:.2g}° against each other, which may change up to "
        f"{worth:.0f} of its {plan.delta_v_m_s:.0f} m/s"
    )


def _of_all_pairs(
    rates: npt.NDArray[np.float64], turn_m_s: npt.NDArray[np.float64], duration_s: float
) -> str | None:
    some = np.sort(rates)[np.linspace(0, rates.size - 1, min(rates.size, MOST_RATES)).astype(int)]
    first, second = np.triu_indices(some.size, 1)
    if not first.size:
        return None
    middle, high = np.quantile(some[second] - some[first], [0.5, 0.9]) * duration_s
    if np.degrees(high) < LEAST_DEG:
        return None
    return (
        "nodes drift under J2, which the model neglects: in the "
        f"{duration_s / DAY_S:.3g} days of the mission those of two bodies move by "
        f"{np.degrees(middle):.2g}° against each other in the median and by "
        f"{np.degrees(high):.2g}° or more for a tenth of the pairs, which is worth "
        f"{middle * np.median(turn_m_s):.0f} and {high * np.median(turn_m_s):.0f} m/s a leg"
    )


def _turn_m_s(instance: Instance) -> npt.NDArray[np.float64]:
    """ΔV per radian of node at each body, V sin i, shape (bodies,) [m/s]."""
    orbits = instance.orbits()
    speed = np.sqrt(MU_M3_S2 / elements.radii(orbits, EPOCH_S))
    worth: npt.NDArray[np.float64] = speed * np.sin(elements.inclinations(orbits, EPOCH_S))
    return worth
