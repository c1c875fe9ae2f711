"""What the learned policy sees, worked out once more in NumPy, a column at a time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import DAY_S, HOUR_S
from adr_opt.learning.next_leg.choices import Choices, Standing
from adr_opt.learning.next_leg.features import LEG_FEATURES
from adr_opt.learning.next_leg.near_orbits import OrbitPlaces
from adr_opt.learning.next_leg.onward import Connecting, OnwardLegs, unknown

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

M_S_PER_HOUR = 450.0
NEAREST, FAR_M_S, CLIP = 5, 5000.0, 5.0


def seen(
    standing: Standing,
    choices: Choices,
    onward: OnwardLegs,
    places: OrbitPlaces,
    worths: FloatArray,
    required: BoolArray,
) -> tuple[FloatArray, FloatArray]:
    """Numbers of the legs and of the mission, see :func:`adr_opt.learning.next_leg.features`."""
    at, full = choices.bodies, max(standing.full, 1e-6)
    left_s = max(standing.end - standing.time, 1.0)
    station = at < standing.stations
    targets = choices.legal & ~station
    delta_v = np.minimum(choices.delta_v, 1e5)
    took = np.minimum(choices.free - standing.time, 1e7)
    cost = took / HOUR_S + delta_v / M_S_PER_HOUR
    few = np.sort(cost[targets])[:NEAREST]
    mean_cost = few.mean() if few.size else 0.0
    ratio = np.log((worths[at] + 0.01) / (cost + 0.5))
    around, apart, _ = places.neighbours_of(at)
    near = worths[around]
    direct = np.linalg.norm(places.points[at] - places.points[standing.body], axis=1)
    home = np.zeros(at.size)
    if standing.stations:
        ways = places.points[at][:, None] - places.points[None, : standing.stations]
        home = np.linalg.norm(ways, axis=2).min(axis=1)
    order = np.empty(at.size)
    order[np.argsort(np.where(targets, cost, np.inf), kind="stable")] = np.arange(at.size)
    both = np.where(onward.known, cost + onward.cost, np.inf)
    ranks = choices.ranks
    legs = np.zeros((at.size, LEG_FEATURES))
    columns = {
        0: station,
        1: delta_v / 1000.0,
        2: delta_v / max(standing.left, 1.0),
        3: took / (10.0 * HOUR_S),
        4: took / left_s,
        5: cost / 10.0,
        6: (cost - _least(cost, targets)) / 10.0,
        7: worths[at],
        8: ratio + _least(-ratio, targets),
        9: choices.left / full,
        10: (standing.end - choices.free) / left_s,
        11: home / 1000.0,
        12: (choices.left - home) / full,
        18: required[at],
        19: np.minimum((choices.closes - choices.free) / left_s, 1.0),
        20: choices.waits / (10.0 * HOUR_S),
        21: ranks == 0,
        22: np.where(ranks >= 0, 0.7 ** np.maximum(ranks, 0), 0.0),
        23: choices.planned_by_others,
        24: np.clip((choices.others_apart - direct) / 1000.0, -1.0, 1.0),
        25: np.isfinite(choices.others_apart),
        26: (standing.left - delta_v - choices.left) / full * ~station,
        27: (delta_v - direct) / 500.0,
        28: (cost - mean_cost) / 5.0,
        29: np.minimum(order, 20.0) / 10.0,
        30: (choices.left < home) & ~station,
        33: onward.known,
        34: onward.cost / 10.0,
        35: np.where(onward.known, both - both.min(initial=np.inf), 0.0) / 10.0,
        36: onward.delta_v / 300.0,
        37: onward.next_cost / 10.0,
    }
    for column, length in ((13, 60.0), (14, 150.0), (15, 400.0)):
        columns[column] = 0.5 * np.log1p((near * np.exp(-apart / length)).sum(axis=1))
    for column, rate in ((31, 120.0), (32, 1500.0)):
        priced = took / HOUR_S + delta_v / rate
        columns[column] = (priced - _least(priced, targets)) / 10.0
    if near.shape[1]:
        open_near = np.sort(np.where(near > 0.0, np.minimum(apart, FAR_M_S), FAR_M_S), axis=1)
        columns[16] = open_near[:, 0] / 300.0
        columns[17] = open_near[:, :NEAREST].mean(axis=1) / 500.0
    for column, values in columns.items():
        legs[:, column] = values
    paid = np.sort(delta_v[targets])[:NEAREST]
    tank, clock = standing.tank_ahead, standing.time_ahead
    mission = np.array(
        [
            standing.left / full,
            left_s / max(standing.end, 1.0),
            left_s / (7.0 * DAY_S),
            full / 1000.0,
            np.log10(1.0 + np.count_nonzero(worths)) / 2.0,
            standing.stations > 0,
            standing.since > 0,
            tank is not None,
            0.0 if tank is None else 10.0 * tank / full,
            0.0 if clock is None else clock / (10.0 * HOUR_S),
            standing.chasers > 1,
            mean_cost / 5.0,
            targets.sum() / max(1, at.size),
            paid.mean() / 200.0 if paid.size else 0.0,
            standing.left / 1000.0,
        ]
    )
    return np.clip(legs, -CLIP, CLIP), np.clip(mission, -CLIP, CLIP)


def _least(values: FloatArray, where: BoolArray) -> float:
    return float(values[where].min()) if where.any() else 0.0


def onward_legs(
    choices: Choices,
    places: OrbitPlaces,
    worths: FloatArray,
    end_s: float,
    stations: int,
    connecting: Connecting,
) -> OnwardLegs:
    """The two cheapest legs after each of the ten cheapest, to six targets near its end."""
    found = unknown(choices.bodies.size)
    cost = choices.free / HOUR_S + choices.delta_v / M_S_PER_HOUR
    cost = np.where(choices.bodies >= stations, cost, np.inf)
    cost = np.where(choices.ranks == 0, np.minimum(cost, 0.0), cost)
    cost = np.where(choices.legal, cost, np.inf)
    for leg in [at for at in np.argsort(cost, kind="stable")[:10] if np.isfinite(cost[at])]:
        near = places.neighbours_of(choices.bodies[leg : leg + 1])[0][0]
        if near.size < 2:
            continue
        there = np.array(sorted(near.tolist(), key=lambda j: worths[j] <= 0.0)[:6])
        origins, ready = np.full(there.size, choices.bodies[leg]), choices.free[leg]
        delta_v, arrival = connecting(origins, np.full(there.size, ready), there)
        fits = (worths[there] > 0.0) & (delta_v <= choices.left[leg]) & (arrival <= end_s)
        taken = (arrival - ready) / HOUR_S + delta_v / M_S_PER_HOUR
        taken = np.where(fits, np.minimum(taken, 50.0), 50.0)
        order = np.argsort(taken, kind="stable")
        found.known[leg] = True
        found.cost[leg], found.next_cost[leg] = taken[order[0]], taken[order[1]]
        found.delta_v[leg] = delta_v[order[0]] if fits[order[0]] and taken[order[0]] < 50.0 else 0.0
    return found
