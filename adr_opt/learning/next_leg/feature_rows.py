"""The arithmetic of what a learned policy sees, compiled (:mod:`.features` says what for)."""

from __future__ import annotations

import math

import numpy as np

from ...common.constants import DAY_S, HOUR_S
from ...kernels.core.compile import kernel
from ...kernels.episodes.outlook import M_S_PER_HOUR

TEN_HOURS_S = 10.0 * HOUR_S

RATE_1_M_S, RATE_2_M_S = 120.0, 1500.0
"""Other values of an hour, for missions that are short of ΔV, or of time [m/s]."""

PLANNED_DECAY = 0.7
"""Share that a planned leg counts of the planned leg before it."""

NEAREST = 5
"""Number of open targets near a body whose mean distance is seen."""

FAR_M_S = 5000.0
"""Distance that stands for a neighbour that is not open any more [m/s]."""

CLIP = 5.0


@kernel
def _apart(points, i, j):
    """Distance of two orbits [m/s]."""
    total = 0.0
    for axis in range(points.shape[1]):
        away = points[j, axis] - points[i, axis]
        total += away * away
    return math.sqrt(total)


@kernel
def _least(values, count, wanted):
    """Mean of the least of some values; 0 for none."""
    if count == 0:
        return 0.0
    few = np.sort(values[:count])[:wanted]
    return few.mean()


@kernel
def write_features(standing, choices, onward, places, worths, required, legs, mission):
    """Write what the policy sees of each leg, and of the mission.

    Parameters
    ----------
    standing : tuple
        Body, time, end [s], ΔV left and in a full tank [m/s], targets since the last refuelling,
        number of stations and of chasers, whether there is a plan, and by how much the tank [m/s]
        and the clock [s] are ahead of it.
    choices : Choices
    onward : OnwardLegs
    places : tuple
        Points of orbits, (bodies, 7), and of each leg's destination its neighbours:
        :meth:`.near_orbits.OrbitPlaces.neighbours_of`.
    worths : (bodies,) float64
    required : (bodies,) bool
    legs : (legs, LEG_FEATURES) float64
        Written; zeros before.
    mission : (MISSION_FEATURES,) float64
        Written.
    """
    body, time, end, own, full, since, stations, chasers, has_plan, tank, clock = standing
    points, near, apart, counts = places
    count, neighbours = choices.bodies.size, near.shape[1]
    full, left_s = max(full, 1e-6), max(end - time, 1.0)
    cost, ratio = np.empty(count), np.empty(count)
    priced_1, priced_2 = np.empty(count), np.empty(count)
    paid, hours, number = np.empty(count), np.empty(count), 0
    cheapest, best_ratio, least_1, least_2 = math.inf, -math.inf, math.inf, math.inf
    both = math.inf
    for leg in range(count):
        delta_v = min(choices.delta_v[leg], 1e5)
        took = min(choices.free[leg] - time, 1e7)
        j = choices.bodies[leg]
        cost[leg] = took / HOUR_S + delta_v / M_S_PER_HOUR
        priced_1[leg] = took / HOUR_S + delta_v / RATE_1_M_S
        priced_2[leg] = took / HOUR_S + delta_v / RATE_2_M_S
        ratio[leg] = math.log((worths[j] + 0.01) / (cost[leg] + 0.5))
        if onward.known[leg]:
            both = min(both, cost[leg] + onward.cost[leg])
        if choices.legal[leg] and j >= stations:
            hours[number], paid[number] = cost[leg], delta_v
            number += 1
            cheapest, best_ratio = min(cheapest, cost[leg]), max(best_ratio, ratio[leg])
            least_1, least_2 = min(least_1, priced_1[leg]), min(least_2, priced_2[leg])
    if number == 0:
        cheapest = best_ratio = least_1 = least_2 = 0.0
    mean_cost = _least(hours, number, NEAREST)
    keys = np.full(count, math.inf)
    for leg in range(count):
        if choices.legal[leg] and choices.bodies[leg] >= stations:
            keys[leg] = cost[leg]
    order = np.argsort(keys, kind="mergesort")
    for place in range(count):
        legs[order[place], 29] = min(place, 20) / 10.0
    for leg in range(count):
        j, row = choices.bodies[leg], legs[leg]
        station = j < stations
        delta_v = min(choices.delta_v[leg], 1e5)
        took = min(choices.free[leg] - time, 1e7)
        home = 0.0
        for each in range(stations):
            away = _apart(points, each, j)
            home = away if each == 0 else min(home, away)
        dense_1, dense_2, dense_3 = 0.0, 0.0, 0.0
        few, nearest, total = 0, FAR_M_S, 0.0
        for place in range(neighbours):  # the nearest first
            worth, away = worths[near[leg, place]], min(apart[leg, place], FAR_M_S)
            if worth > 0.0:
                dense_1 += worth * counts[leg, place, 0]
                dense_2 += worth * counts[leg, place, 1]
                dense_3 += worth * counts[leg, place, 2]
                if few == 0:
                    nearest = away
                if few < NEAREST:
                    total += away
                    few += 1
        direct = _apart(points, body, j)
        row[0] = station
        row[1] = delta_v / 1000.0
        row[2] = delta_v / max(own, 1.0)
        row[3] = took / TEN_HOURS_S
        row[4] = took / left_s
        row[5] = cost[leg] / 10.0
        row[6] = (cost[leg] - cheapest) / 10.0
        row[7] = worths[j]
        row[8] = ratio[leg] - best_ratio
        row[9] = choices.left[leg] / full
        row[10] = (end - choices.free[leg]) / left_s
        row[11] = home / 1000.0
        row[12] = (choices.left[leg] - home) / full
        row[13] = 0.5 * math.log1p(dense_1)
        row[14] = 0.5 * math.log1p(dense_2)
        row[15] = 0.5 * math.log1p(dense_3)
        if neighbours:
            wanted = min(NEAREST, neighbours)
            row[16] = nearest / 300.0
            row[17] = (total + (wanted - few) * FAR_M_S) / wanted / 500.0
        row[18] = required[j]
        row[19] = min((choices.closes[leg] - choices.free[leg]) / left_s, 1.0)
        row[20] = choices.waits[leg] / TEN_HOURS_S
        rank = choices.ranks[leg]
        row[21] = rank == 0
        row[22] = PLANNED_DECAY**rank if rank >= 0 else 0.0
        row[23] = choices.planned_by_others[leg]
        beside = choices.others_apart[leg]
        row[24] = max(-1.0, min(1.0, (beside - direct) / 1000.0))
        row[25] = beside < math.inf
        row[26] = 0.0 if station else (own - delta_v - choices.left[leg]) / full
        row[27] = (delta_v - direct) / 500.0
        row[28] = (cost[leg] - mean_cost) / 5.0
        row[30] = choices.left[leg] - home < 0.0 and not station
        row[31] = (priced_1[leg] - least_1) / 10.0
        row[32] = (priced_2[leg] - least_2) / 10.0
        row[33] = onward.known[leg]
        row[34] = onward.cost[leg] / 10.0
        row[35] = (cost[leg] + onward.cost[leg] - both) / 10.0 if onward.known[leg] else 0.0
        row[36] = onward.delta_v[leg] / 300.0
        row[37] = onward.next_cost[leg] / 10.0
        for column in range(row.size):
            row[column] = max(-CLIP, min(CLIP, row[column]))
    worthy = 0
    for j in range(worths.size):
        worthy += worths[j] != 0.0
    mission[0] = own / full
    mission[1] = left_s / max(end, 1.0)
    mission[2] = left_s / (7.0 * DAY_S)
    mission[3] = full / 1000.0
    mission[4] = math.log10(1.0 + worthy) / 2.0
    mission[5] = stations > 0
    mission[6] = since > 0
    mission[7] = has_plan
    mission[8] = 10.0 * tank / full
    mission[9] = clock / TEN_HOURS_S
    mission[10] = chasers > 1
    mission[11] = mean_cost / 5.0
    mission[12] = number / max(1, count)
    mission[13] = _least(paid, number, NEAREST) / 200.0
    mission[14] = own / 1000.0
    for column in range(mission.size):
        mission[column] = max(-CLIP, min(CLIP, mission[column]))
