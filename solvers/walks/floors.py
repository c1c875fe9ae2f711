"""A quick bound at any size: every service takes its least time and its least ΔV.

A plan's legs follow one another, and so do their services. Hence with t_j the least time from a
departure to the end of the service of j, and c_j the least ΔV to come to j, from wherever it may
be, the targets x_j that a plan services and its r refuellings keep to

    Σ t_j x_j + t_s r ≤ T ,      Σ c_j x_j ≤ B + b r

where B is what there is at first and b = B a full tank. Of several chasers the sums hold with the
times and the tanks of all of them together, the least t_j and c_j of any, and the largest b. The
most that x_j between 0 and 1 and r ≥ 0 can be worth is bounded by any prices τ, λ ≥ 0 of time and
of ΔV with τ t_s ≥ λ b,

    Σ prize_j x_j ≤ τ T + λ B + Σ max(0, prize_j − τ t_j − λ c_j) ,

and the best τ for a λ is where a knapsack filled in order of worth per time is full. No table of
pairs is looked at, but for costs that are given.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from adr_opt.common.constants import MU_M3_S2, SLACK_S
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import co_elliptic
from adr_opt.kernels.legs.fixed_points import BAND_S
from adr_opt.kernels.orbits import elements
from adr_opt.kernels.orbits.ephemeris import EPOCH_S, inclination_at, planes_drift, radius_at
from adr_opt.legs.families.registry import registered_of
from adr_opt.mission.evidence import Evidence, Floors
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.problem.instance import Instance

PRICES = 200
"""Number of prices of ΔV tried."""

SLOT_M_S = 20.0
"""Slot of ΔV stated in certificates that do not use it [m/s]."""

GUARD = 1e-9
"""Relative reduction of floors for rounding."""

ROUNDING = 1e-12
"""Increase of a turn's cosine for rounding: near 1 the guard does not cover it."""


class Priced(NamedTuple):
    """A bound, with the prices of time [worth per s] and ΔV [worth per m/s] that prove it."""

    most: float
    per_s: float
    per_m_s: float


class Sack(NamedTuple):
    """Knapsack of time and ΔV: capacities, and worth and least use of each target.

    Attributes
    ----------
    prize, took, cost : (bodies,) float64
        Worths, 0 where a body cannot be serviced; least times [s] and least ΔV [m/s], +inf there.
    time_s : float
        Of the mission [s].
    budget, tank : float
        ΔV at first, and of a full tank [m/s].
    stop_s : float
        What a refuelling takes at least, +inf where there is none [s].
    """

    prize: np.ndarray
    took: np.ndarray
    cost: np.ndarray
    time_s: float
    budget: float
    tank: float
    stop_s: float


def floor_bound(problem: Problem) -> float:
    """Upper bound on plans of a mission or a campaign.

    Returns
    -------
    float
        In worths, as :attr:`adr_opt.kernels.rules.rules.Rules.prize` has them.
    """
    return _priced(problem.missions).most


def floor_evidence(mission: Mission) -> tuple[float, Evidence]:
    """Upper bound of a mission, with its evidence."""
    most, per_s, per_m_s = _priced((mission,))
    bodies = len(mission.names)
    return most, Evidence(np.zeros(bodies), (), SLOT_M_S, Floors(per_s, per_m_s, most))


def _priced(missions: Sequence[Mission]) -> Priced:
    distinct = {id(mission): mission for mission in missions}
    sacks = {key: sack_of(mission) for key, mission in distinct.items()}
    every = [sacks[id(mission)] for mission in missions]
    return knapsack(
        Sack(
            prize=np.max([sack.prize for sack in every], axis=0),
            took=np.min([sack.took for sack in every], axis=0),
            cost=np.min([sack.cost for sack in every], axis=0),
            time_s=math.fsum(sack.time_s for sack in every),
            budget=math.fsum(sack.budget for sack in every),
            tank=max(sack.tank for sack in every),
            stop_s=min(sack.stop_s for sack in every),
        )
    )


def sack_of(mission: Mission) -> Sack:
    """Knapsack of one chaser."""
    rules = mission.rules
    least_s, least_m_s = floors(mission)
    possible = (rules.windows.opening <= rules.windows.closing) & np.isfinite(least_s)
    possible &= least_m_s <= rules.budget
    possible[: rules.first_target] = False
    took, cost = (np.where(possible, least, math.inf) for least in (least_s, least_m_s))
    # A ready chaser takes departures a slack before, once a leg.
    time_s, budget = max(0.0, rules.duration - rules.ready), rules.budget
    if rules.start in mission.instance.launches:
        # A launch takes no time and no ΔV.
        time_s += float(took[possible].max(initial=0.0))
        budget += float(cost[possible].max(initial=0.0))
    stop_s = float(least_s[: rules.stations].min(initial=math.inf))
    prize = np.where(possible, rules.prize, 0.0)
    return Sack(prize, took, cost, time_s, budget, rules.budget, stop_s)


def knapsack(sack: Sack) -> Priced:
    """Least bound over the prices tried."""
    some = sack.prize > 0.0
    prize, took, cost = sack.prize[some], sack.took[some], sack.cost[some]
    if not prize.size:
        return Priced(0.0, 0.0, 0.0)
    dear = cost > 0.0
    highest = float((prize[dear] / cost[dear]).max(initial=0.0))
    prices = highest * np.append(0.0, np.geomspace(1e-4, 1.0, PRICES)) if highest else np.zeros(1)
    took = np.maximum(took, GUARD)
    least = Priced(math.inf, 0.0, 0.0)
    for price in prices:
        rest = np.maximum(0.0, prize - price * cost)
        order = np.argsort(-rest / took)
        filled = np.cumsum(took[order])
        full = int(np.searchsorted(filled, sack.time_s, side="right"))
        per_s = float((rest / took)[order[full]]) if full < order.size else 0.0
        if math.isfinite(sack.stop_s):
            per_s = max(per_s, price * sack.tank / max(sack.stop_s, GUARD))
        value = per_s * sack.time_s + price * sack.budget
        value += float(np.maximum(0.0, rest - per_s * took).sum())
        least = min(least, Priced(value * (1.0 + GUARD), per_s, float(price)))
    return least


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
    if rules.loads is not None or mission.connecting.corrections:
        least_m_s = np.zeros_like(least_m_s)  # a service changes what is left, or costs are others
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
        return flown + service, np.zeros_like(flown)
    cubes = elements.radii(arriving, EPOCH_S) ** 3
    approach = rule.approach_length * np.sqrt(MU_M3_S2 / cubes)
    slowest = np.sqrt(2.0 * MU_M3_S2 * radii / (rule.max_radius * (rule.max_radius + radii)))
    return flown + service, approach + _turns(_normals(leaving), _normals(arriving), slowest)


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
