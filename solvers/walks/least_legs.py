"""Least times and least ΔV of legs, by destination, from orbits alone."""

from __future__ import annotations

import math

import numpy as np

from adr_opt.common.constants import MU_M3_S2, SLACK_S
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import co_elliptic
from adr_opt.kernels.legs.fixed_points import BAND_S
from adr_opt.kernels.orbits import elements
from adr_opt.kernels.orbits.ephemeris import EPOCH_S, inclination_at, planes_drift, radius_at
from adr_opt.legs.families.registry import registered_of
from adr_opt.mission.mission import Mission
from adr_opt.problem.instance import Instance

GUARD = 1e-9
"""Relative reduction of floors for rounding."""

ROUNDING = 1e-12
"""Increase of a turn's cosine for rounding: near 1 the guard does not cover it."""


def floors(mission: Mission) -> tuple[np.ndarray, np.ndarray]:
    """Least time from a departure to the end of service, and least ΔV, by destination.

    Returns
    -------
    least_s, least_m_s : (bodies,) float64
        [s], +inf where nothing leads; [m/s].
    """
    instance, rules = mission.instance, mission.rules
    if instance.given is not None:
        least_s, least_m_s = _of_given(instance, rules.windows.opening, rules.service)
    else:
        least_s, least_m_s = _of_model(mission)
        for family in registered_of(instance):
            of_family_s, of_family_m_s = family.least(instance)
            least_s = np.minimum(least_s, of_family_s + rules.service)
            least_m_s = np.minimum(least_m_s, of_family_m_s)
    if mission.connecting.corrections:
        least_m_s = np.zeros_like(least_m_s)  # costs are others
    return (
        np.maximum(0.0, (1.0 - GUARD) * least_s - 2.0 * SLACK_S),
        np.maximum(0.0, (1.0 - GUARD) * least_m_s),
    )


def _of_given(
    instance: Instance, opens: np.ndarray, service: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Minima over all given connections."""
    given = instance.given
    assert given is not None
    least_s, least_m_s = np.full((2, len(instance.names)), math.inf)
    number = {name: body for body, name in enumerate(instance.names)}
    of = np.array([number.get(name, -1) for name in given.names], dtype=np.int64)
    if of.size and given.destination.size:
        body = of[given.destination]
        known = (body >= 0) & (of[given.origin] >= 0)
        body = body[known]
        end = np.maximum(given.arrival[known], opens[body]) + service[body]
        np.minimum.at(least_s, body, end - given.departure[known])
        np.minimum.at(least_m_s, body, given.cost[known])
    if instance.launches:
        # To be launched onto a target takes its service alone, and may be the only way there.
        launched = slice(instance.first_target, None)
        least_s[launched] = np.minimum(least_s[launched], service[launched])
        least_m_s[launched] = 0.0
    return least_s, least_m_s


def _of_model(mission: Mission) -> tuple[np.ndarray, np.ndarray]:
    """Minima of flights at the least radius from the lowest body, and turns from the nearest plane.

    A flight takes the longer the higher it begins and ends and the larger the phasing radius, and
    where the origin's latitude runs faster it takes less time (:func:`transfer.flight_time`). No
    turn costs less than :func:`transfer.prepare` says; where planes drift none is certain, and a
    long transfer takes a step of its grid at least.
    """
    leaving, arriving, _, rule = mission.transfer_inputs
    settings, service = mission.instance.transfer, mission.rules.service
    drifts = planes_drift(rule.oblateness)
    strength = 1.5 * rule.oblateness
    widening = strength * (4.0 * np.cos(elements.inclinations(leaving, EPOCH_S)) ** 2 - 1.0)
    radii = elements.radii(leaving, EPOCH_S)
    flown = _flights(
        float(radii.min()),
        float(widening.max()),
        arriving,
        strength,
        rule.first_leg_fraction,
        rule.min_radius,
    )
    laps = 2.0 * math.pi / elements.latitude_rates(arriving, EPOCH_S)
    flown += rule.approach_revolutions * laps - SLACK_S - drifts * BAND_S
    if drifts:
        if settings.max_drift_s > 0.0:
            flown = np.minimum(flown, settings.drift_step_s)
        return flown + service, _climbs(mission)
    cubes = elements.radii(arriving, EPOCH_S) ** 3
    approach = rule.approach_length * np.sqrt(MU_M3_S2 / cubes)
    slowest = np.sqrt(2.0 * MU_M3_S2 * radii / (rule.max_radius * (rule.max_radius + radii)))
    return flown + service, approach + _turns(_normals(leaving), _normals(arriving), slowest)


def _climbs(mission: Mission) -> np.ndarray:
    """Least ΔV from the nearest altitude where planes drift, shape (bodies,) [m/s].

    Arcs of thrust and drifts are priced by the difference of circular speeds or more, sequences by
    what two burns take between both circles or more.
    """
    leaving, arriving = mission.transfer_inputs[:2]
    if mission.instance.transfer.burns != "sequence":
        return np.zeros(len(arriving))
    r, q = np.meshgrid(elements.radii(leaving, EPOCH_S), elements.radii(arriving, EPOCH_S))
    climb = np.abs(np.sqrt(MU_M3_S2 / r) - np.sqrt(MU_M3_S2 / q))
    if mission.chaser.thrust_n is None:
        half = np.sqrt(2.0 / (r + q))
        burns = [
            np.abs(np.sqrt(MU_M3_S2 / a) * (half * np.sqrt(b) - 1.0)) for a, b in ((r, q), (q, r))
        ]
        climb = np.minimum(climb, burns[0] + burns[1])
    np.fill_diagonal(climb, math.inf)
    others = np.arange(len(mission.instance.stations), mission.instance.first_target)
    if not mission.chaser.is_launched:
        others = others[others != mission.rules.start]
    climb[:, others] = math.inf  # nobody leaves from there
    least: np.ndarray = climb.min(axis=1, initial=math.inf)
    return np.where(np.isfinite(least), least, 0.0)


def _normals(bodies: np.ndarray) -> np.ndarray:
    """Unit normals of the planes of bodies, shape (bodies, 3)."""
    inclination, node = elements.inclinations(bodies, EPOCH_S), elements.nodes(bodies, EPOCH_S)
    return np.stack(
        [
            np.sin(inclination) * np.sin(node),
            -np.sin(inclination) * np.cos(node),
            np.cos(inclination),
        ],
        axis=1,
    )


@kernel
def _flights(radius_i, widening_i, arriving, strength, fraction, least):
    """Least flight times to each body, without the approach [s]."""
    flown = np.empty(arriving.shape[0])
    for j in range(flown.size):
        body = arriving[j]
        cosine = math.cos(inclination_at(body, EPOCH_S))
        widening_j = strength * (4.0 * cosine * cosine - 1.0)
        flown[j] = co_elliptic.flight_time(
            radius_i, radius_at(body, EPOCH_S), widening_i, widening_j, fraction, least
        )[0]
    return flown


@kernel
def _turns(leaving, arriving, slowest):
    """Least cost of the turn into each body's plane, from any other one [m/s].

    Parameters
    ----------
    leaving, arriving : (bodies, 3) float64
        Normals of the planes.
    slowest : (bodies,) float64
        Least speed at the turn, by origin [m/s].
    """
    bodies = arriving.shape[0]
    least = np.empty(bodies)
    for j in range(bodies):
        least[j] = math.inf
        for i in range(bodies):
            if i == j:
                continue
            cosine = ROUNDING
            for axis in range(3):
                cosine += leaving[i, axis] * arriving[j, axis]
            turn = math.sqrt(max(0.0, 1.0 - cosine * cosine)) if cosine > 0.0 else 1.0
            least[j] = min(least[j], slowest[i] * turn)
    return least
