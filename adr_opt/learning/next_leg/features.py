"""What a learned policy sees of a decision: numbers for each leg, and of the mission.

All of it follows from the connections of one body at one time, the tank, the clock, and distances
between orbits; nothing needs a timetable. Numbers are scaled so that most lie within ±2, and
clipped at ±5. See docs/rehearsing.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S, HOUR_S
from .surroundings import Places

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

TEN_HOURS_S = 10.0 * HOUR_S
M_S_PER_HOUR = 450.0
"""ΔV that counts as an hour in the cost of a leg, as in the observations of the environment."""

DENSITIES_M_S = (60.0, 150.0, 400.0)
"""Lengths over which targets near a body count less and less [m/s]."""

PLANNED_DECAY = 0.7
"""Share that a planned leg counts of the planned leg before it."""

CLIP = 5.0

LEG_FEATURES = 31
"""Numbers for each leg."""

MISSION_FEATURES = 15
"""Numbers of the mission."""


class Standing(NamedTuple):
    """A chaser that decides, and its mission.

    Attributes
    ----------
    body : int
    time, end : float
        Now, and the end of the mission or of the chaser's availability [s].
    left, full : float
        ΔV in the tank, and in a full one [m/s].
    since : int
        Targets serviced since the last refuelling.
    stations : int
        Bodies with smaller numbers are stations.
    chasers : int
    tank_ahead, time_ahead : float or None
        By how much the tank and the clock are better than planned before the next planned leg
        [m/s], [s]; None without a plan.
    """

    body: int
    time: float
    end: float
    left: float
    full: float
    since: int
    stations: int
    chasers: int
    tank_ahead: float | None
    time_ahead: float | None


class Choices(NamedTuple):
    """Legs from which a chaser may choose.

    Attributes
    ----------
    bodies : (legs,) int64
        Where they lead.
    delta_v : (legs,) float64
        Of the legs [m/s].
    arrival, free : (legs,) float64
        Arrival, and when the chaser is free again [s].
    left : (legs,) float64
        ΔV left then, after tows, kits and refuelling [m/s].
    closes : (legs,) float64
        When a service there has to be over [s].
    waits : (legs,) float64
        Between arrival and the opening of the window [s].
    legal : (legs,) bool
    ranks : (legs,) int64
        Place among the planned legs that are left, from 0; −1 for none.
    planned_elsewhere : (legs,) bool
        Whether another chaser plans to go there.
    others_apart : (legs,) float64
        Distance of the nearest other chaser [m/s]; +inf without one.
    """

    bodies: IntArray
    delta_v: FloatArray
    arrival: FloatArray
    free: FloatArray
    left: FloatArray
    closes: FloatArray
    waits: FloatArray
    legal: BoolArray
    ranks: IntArray
    planned_elsewhere: BoolArray
    others_apart: FloatArray


def features(
    standing: Standing, choices: Choices, places: Places, worths: FloatArray, required: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """What the policy sees.

    Parameters
    ----------
    standing : Standing
    choices : Choices
    places : Places
    worths : (bodies,) float64
        Of targets that are open, over the mean of all targets with a prize; 0 of all others.
    required : (bodies,) bool

    Returns
    -------
    legs : (legs, LEG_FEATURES) float64
    mission : (MISSION_FEATURES,) float64
    """
    at, full, left_s = choices.bodies, max(standing.full, 1e-6), standing.end - standing.time
    left_s = max(left_s, 1.0)
    station, legal = at < standing.stations, choices.legal
    targets = legal & ~station
    legs = np.zeros((at.size, LEG_FEATURES))
    delta_v = np.minimum(choices.delta_v, 1e5)
    took = np.minimum(choices.free - standing.time, 1e7)
    cost = took / HOUR_S + delta_v / M_S_PER_HOUR
    cheapest = cost[targets].min() if targets.any() else 0.0
    few = np.sort(cost[targets])[:5]
    mean_cost = float(few.mean()) if few.size else 0.0
    worth = worths[at]
    ratio = np.log((worth + 0.01) / (cost + 0.5))
    home = _way_back(places, at, standing.stations)
    near = worths[places.near[at]]
    apart = places.apart[at]
    direct = places.distances(standing.body, at)
    legs[:, 0] = station
    legs[:, 1] = delta_v / 1000.0
    legs[:, 2] = delta_v / max(standing.left, 1.0)
    legs[:, 3] = took / TEN_HOURS_S
    legs[:, 4] = took / left_s
    legs[:, 5] = cost / 10.0
    legs[:, 6] = (cost - cheapest) / 10.0
    legs[:, 7] = worth
    legs[:, 8] = ratio - (ratio[targets].max() if targets.any() else 0.0)
    legs[:, 9] = choices.left / full
    legs[:, 10] = (standing.end - choices.free) / left_s
    legs[:, 11] = home / 1000.0
    legs[:, 12] = (choices.left - home) / full
    for column, length in enumerate(DENSITIES_M_S, start=13):
        legs[:, column] = 0.5 * np.log1p((near * np.exp(-apart / length)).sum(axis=1))
    open_near = np.where(near > 0.0, apart, 5000.0)
    if open_near.shape[1] >= 5:
        open_near = np.partition(open_near, 4, axis=1)[:, :5]
    if open_near.shape[1]:
        legs[:, 16] = open_near.min(axis=1) / 300.0
        legs[:, 17] = open_near.mean(axis=1) / 500.0
    legs[:, 18] = required[at]
    legs[:, 19] = np.minimum((choices.closes - choices.free) / left_s, 1.0)
    legs[:, 20] = choices.waits / TEN_HOURS_S
    legs[:, 21] = choices.ranks == 0
    legs[:, 22] = np.where(choices.ranks >= 0, PLANNED_DECAY ** np.maximum(choices.ranks, 0), 0.0)
    legs[:, 23] = choices.planned_elsewhere
    legs[:, 24] = np.clip((choices.others_apart - direct) / 1000.0, -1.0, 1.0)
    legs[:, 25] = np.isfinite(choices.others_apart)
    legs[:, 26] = (standing.left - delta_v - choices.left) / full * ~station
    legs[:, 27] = (delta_v - direct) / 500.0
    legs[:, 28] = (cost - mean_cost) / 5.0
    order = np.empty(at.size)
    order[np.argsort(np.where(targets, cost, np.inf), kind="stable")] = np.arange(at.size)
    legs[:, 29] = np.minimum(order, 20.0) / 10.0
    legs[:, 30] = (choices.left - home < 0.0) & ~station
    np.clip(legs, -CLIP, CLIP, out=legs)
    tank, clock = standing.tank_ahead, standing.time_ahead
    mission = np.array(
        [
            standing.left / full, left_s / max(standing.end, 1.0), left_s / (7.0 * DAY_S), full / 1000.0,
            np.log10(1.0 + np.count_nonzero(worths)) / 2.0, standing.stations > 0,
            standing.since > 0, tank is not None,
            0.0 if tank is None else 10.0 * tank / full,
            0.0 if clock is None else clock / TEN_HOURS_S,
            standing.chasers > 1, mean_cost / 5.0, np.count_nonzero(targets) / max(1, at.size),
            _mean_delta_v(delta_v[targets]) / 200.0, standing.left / 1000.0,
        ]
    )  # fmt: skip
    return legs, np.clip(mission, -CLIP, CLIP)


def _way_back(places: Places, at: IntArray, stations: int) -> FloatArray:
    """Distance from some bodies to the nearest station [m/s]; 0 without one."""
    found = np.zeros(at.size)
    for number in range(stations):
        away = places.distances(number, at)
        found = away if number == 0 else np.minimum(found, away)
    return found


def _mean_delta_v(delta_v: FloatArray) -> float:
    """Mean of the five cheapest [m/s]; 0 for none."""
    return float(np.sort(delta_v)[:5].mean()) if delta_v.size else 0.0
