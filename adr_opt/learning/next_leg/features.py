"""What a learned policy sees of a decision: numbers for each leg, and of the mission.

All of it follows from the connections of one body at one time, the tank, the clock, and distances
between orbits; nothing needs a timetable. Numbers are scaled so that most lie within ±2, and
clipped at ±5. See docs/rehearsing.md.
"""

from __future__ import annotations

import numpy as np

from ...common.constants import DAY_S, HOUR_S
from .choices import M_S_PER_HOUR, BoolArray, Choices, FloatArray, IntArray, Standing
from .near_orbits import OrbitPlaces
from .onward import OnwardLegs

TEN_HOURS_S = 10.0 * HOUR_S
RATES_M_S = (120.0, 1500.0)
"""Other values of an hour, for missions that are short of ΔV, or of time [m/s]."""

DENSITIES_M_S = (60.0, 150.0, 400.0)
"""Lengths over which targets near a body count less and less [m/s]."""

PLANNED_DECAY = 0.7
"""Share that a planned leg counts of the planned leg before it."""

CLIP = 5.0

LEG_FEATURES = 38
"""Numbers for each leg."""

MISSION_FEATURES = 15
"""Numbers of the mission."""


def features(
    standing: Standing, choices: Choices, onward: OnwardLegs, places: OrbitPlaces,
    worths: FloatArray, required: BoolArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """What the policy sees.

    Parameters
    ----------
    standing : Standing
    choices : Choices
    onward : OnwardLegs
    places : OrbitPlaces
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
    for column, rate in enumerate(RATES_M_S, start=31):
        priced = took / HOUR_S + delta_v / rate
        legs[:, column] = (priced - (priced[targets].min() if targets.any() else 0.0)) / 10.0
    known = onward.known
    both = cost + onward.cost
    legs[:, 33] = known
    legs[:, 34] = onward.cost / 10.0
    legs[:, 35] = np.where(known, both - (both[known].min() if known.any() else 0.0), 0.0) / 10.0
    legs[:, 36] = onward.delta_v / 300.0
    legs[:, 37] = onward.next_cost / 10.0
    np.clip(legs, -CLIP, CLIP, out=legs)
    tank, clock = standing.tank_ahead, standing.time_ahead
    mission = np.array(
        [
            standing.left / full, left_s / max(standing.end, 1.0), left_s / (7.0 * DAY_S),
            full / 1000.0,
            np.log10(1.0 + np.count_nonzero(worths)) / 2.0, standing.stations > 0,
            standing.since > 0, tank is not None,
            0.0 if tank is None else 10.0 * tank / full,
            0.0 if clock is None else clock / TEN_HOURS_S,
            standing.chasers > 1, mean_cost / 5.0, np.count_nonzero(targets) / max(1, at.size),
            _mean_delta_v(delta_v[targets]) / 200.0, standing.left / 1000.0,
        ]
    )  # fmt: skip
    return legs, np.clip(mission, -CLIP, CLIP)


def _way_back(places: OrbitPlaces, at: IntArray, stations: int) -> FloatArray:
    """Distance from some bodies to the nearest station [m/s]; 0 without one."""
    found = np.zeros(at.size)
    for number in range(stations):
        away = places.distances(number, at)
        found = away if number == 0 else np.minimum(found, away)
    return found


def _mean_delta_v(delta_v: FloatArray) -> float:
    """Mean of the five cheapest [m/s]; 0 for none."""
    return float(np.sort(delta_v)[:5].mean()) if delta_v.size else 0.0
