"""Rows of choices: the features of :mod:`.choices`, computed for episodes and rehearsals alike."""

import math

import numpy as np

from ..core.compile import inlined, kernel
from ..core.memory import borrowed
from ..orbits.ephemeris import inclination_at, latitude_at, node_at, radius_at
from .choices import (
    ANGLE_FROM_CHASER,
    BACK,
    BACK_TIME,
    BUDGET,
    CHANCE,
    CHASER_INCLINATION,
    CHASER_RAAN,
    CHASER_RADIUS,
    COST,
    DEGREES,
    DEVIATION,
    DOCKED,
    DURATION,
    EARNED,
    GONE_CHANCE,
    HOLDS,
    HOME_REACHABLE,
    INCLINATION_FROM_CHASER,
    INCLINATION_FROM_HOME,
    IS_GONE,
    IS_OPEN,
    IS_STATION,
    LATE_TRY,
    LATE_TRY_S,
    LEAST,
    LEFT,
    LEFT_AFTER,
    LEFT_AFTER_BACK,
    LEFT_OF_BUDGET,
    LEGAL,
    LEGAL_SHARE,
    LIMIT,
    LOOKED_AHEAD,
    M_S_PER_HOUR,
    MEAN_STAY,
    MEAN_TRY,
    MOST,
    NEAR_OPEN,
    NEEDED,
    NEEDED_OF_LEFT,
    NEXT_COST,
    NEXT_NEEDED,
    NEXT_TAKEN,
    ONWARD,
    OPEN_TARGETS,
    PER_50_KM,
    PER_HOUR,
    PER_KM_S,
    PER_TEN_HOURS,
    PHASE,
    PRIZE,
    RAAN_FROM_CHASER,
    RAAN_FROM_HOME,
    RADIUS_FROM_CHASER,
    RADIUS_FROM_HOME,
    SAFE,
    SECOND_COST,
    SIGMA,
    SPREAD_NEEDED,
    STAY_S,
    SUCCEEDS,
    SUCCESS,
    TAKEN,
    TAKEN_OF_LEFT,
    TIME,
    TIME_AFTER,
    TIME_OF_DURATION,
    TIME_PER_TARGET,
    TRY_S,
    WEEK_S,
    WORTH,
)


@inlined
def clip(value, low, high):
    """A value clipped to its limits; NaN becomes the upper limit, so that no network sees it."""
    if value <= low:
        return low
    if value <= high:
        return value
    return high


@inlined
def turned(angle):
    """An angle reduced to [−π, π)."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) * (0.5 / math.pi))


@inlined
def move_cost(seconds, delta_v):
    """Cost of a move [h]."""
    return seconds * PER_HOUR + delta_v * (1.0 / M_S_PER_HOUR)


@kernel
def look_ahead(choices, near, is_open, now, count, there):
    """Select the moves to look beyond and the destinations after them; count open moves.

    Parameters
    ----------
    choices : Choices
        ``near_open`` is written.
    near : (choices, nearest) int
        Nearest targets of each choice's body, the nearest first; −1 where there are no more.
    is_open : (bodies,) bool
    now : float
        [s].
    count : int
        Choices.
    there : (LOOKED_AHEAD, 1 + ONWARD) int64
        Written: a choice and the bodies onward; −1 for none.
    """
    costs, nearest = np.empty(LOOKED_AHEAD), near.shape[1]
    kept = 0
    for place in range(LOOKED_AHEAD):
        for column in range(there.shape[1]):
            there[place, column] = -1
    for at in range(count):
        among, known = 0, 0
        for rank in range(nearest):
            k = near[at, rank]
            known += k >= 0
            among += k >= 0 and is_open[k]
        choices.near_open[at] = among / max(known, 1)
        if choices.legal[at] and not choices.station[at]:
            cost = move_cost(choices.end[at] - now, choices.needed[at])
            place = kept
            if kept == LOOKED_AHEAD:
                if cost >= costs[kept - 1]:
                    continue
                place -= 1
            else:
                kept += 1
            while place > 0 and costs[place - 1] > cost:
                costs[place], there[place, 0] = costs[place - 1], there[place - 1, 0]
                place -= 1
            costs[place], there[place, 0] = cost, at
    for place in range(kept):
        at, found = there[place, 0], 0
        for rank in range(nearest):
            k = near[at, rank]
            if found < ONWARD and k >= 0 and is_open[k] and k != choices.bodies[at]:
                found += 1
                there[place, found] = k


@inlined
def note_onward(choices, at, seconds, delta_v, end):
    """Record a move after a choice, if it fits the tank and the mission."""
    if not (delta_v <= choices.left[at] and choices.end[at] + seconds <= end):
        return
    best, cost = choices.onward[at], move_cost(seconds, delta_v)
    if cost < best[2]:
        best[0], best[1], best[2], best[3] = delta_v, seconds, cost, best[2]
    elif cost < best[3]:
        best[3] = cost


@kernel
def note_all_onward(choices, there, delta_v, end, duration):
    """Record the moves after choices that :func:`look_ahead` selected.

    Parameters
    ----------
    choices : Choices
    there : (LOOKED_AHEAD, 1 + ONWARD) int64
    delta_v, end : (LOOKED_AHEAD, ONWARD) float64
        Of these moves [m/s], with service [s].
    duration : float
        [s].
    """
    for row in range(there.shape[0]):
        at = there[row, 0]
        for column in range(there.shape[1] - 1):
            if at >= 0 and there[row, 1 + column] >= 0:
                seconds = end[row, column] - choices.end[at]
                note_onward(choices, at, seconds, delta_v[row, column], duration)


@inlined
def _chance_within(factor, spread):
    """Chance that a lognormal factor is at most a number."""
    if factor >= spread[MOST] or spread[SIGMA] == 0.0:
        return 1.0
    if factor < spread[LEAST]:
        return 0.0
    return 0.5 * math.erfc(-math.log(factor) / (spread[SIGMA] * math.sqrt(2.0)))


@kernel
def write_rows(standing, choices, count, orbits, places, rows, mission):
    """Write the rows of choices, and the numbers of the mission.

    Parameters
    ----------
    standing : Standing
    choices : Choices
    count : int
        Of them.
    orbits : (bodies, columns) float64
    places : (choices,) int64
        Row of each.
    rows : (rows, len(CHOICE_FIELDS)) float32
        Written.
    mission : (len(MISSION_FIELDS),) float32
        Written.
    """
    choices = borrowed(choices)
    now, end, left, full, since, docked, orbit, home = standing
    remaining = end - now
    # A budget or a time of zero must not divide.
    per_left, per_time = 1.0 / max(left, 1.0), 1.0 / max(remaining, 1.0)
    radius, inclination = radius_at(orbit, now), inclination_at(orbit, now)
    raan = node_at(orbit, now)
    home_radius, home_inclination = radius_at(home, now), inclination_at(home, now)
    home_raan = node_at(home, now)
    node_scale = DEGREES * math.sin(home_inclination)
    cosine = math.cos(home_inclination)
    phase = latitude_at(orbit, now) + cosine * raan
    legal, open_targets, reachable = 0, 0, docked
    for at in range(count):
        row, j = rows[places[at]], choices.bodies[at]
        is_legal, is_station = choices.legal[at], choices.station[at]
        needed, then, after = choices.needed[at], choices.end[at], choices.left[at]
        legal += is_legal
        open_targets += not is_station
        reachable = reachable or (is_station and is_legal)
        row[LEGAL] = 1.0 if is_legal else 0.0
        row[IS_STATION] = 1.0 if is_station else 0.0
        row[IS_OPEN] = 1.0 if choices.open[at] else 0.0
        row[NEEDED] = clip(needed * PER_KM_S, 0.0, LIMIT)
        row[NEEDED_OF_LEFT] = clip(needed * per_left, 0.0, LIMIT)
        row[TAKEN] = clip((then - now) * PER_TEN_HOURS, 0.0, LIMIT)
        row[TAKEN_OF_LEFT] = clip((then - now) * per_time, 0.0, LIMIT)
        row[COST] = clip(0.1 * move_cost(then - now, needed), 0.0, LIMIT)
        row[LEFT_AFTER] = clip(after * PER_KM_S, -LIMIT, LIMIT)
        row[TIME_AFTER] = clip((end - then) * PER_TEN_HOURS, -LIMIT, LIMIT)
        back, back_end = choices.back[at], choices.back_end[at]
        row[BACK] = clip(back * PER_KM_S, 0.0, LIMIT)
        row[LEFT_AFTER_BACK] = clip((after - back) * PER_KM_S, -LIMIT, LIMIT)
        row[SAFE] = 1.0 if back <= after and back_end <= end else 0.0
        row[BACK_TIME] = clip((back_end - then) * PER_TEN_HOURS, 0.0, LIMIT)
        onward = choices.onward[at]
        row[NEXT_NEEDED] = clip(onward[0] * PER_KM_S, 0.0, LIMIT)
        row[NEXT_TAKEN] = clip(onward[1] * PER_TEN_HOURS, 0.0, LIMIT)
        row[NEXT_COST] = clip(0.1 * onward[2], 0.0, LIMIT)
        row[SECOND_COST] = clip(0.1 * onward[3], 0.0, LIMIT)
        row[NEAR_OPEN] = choices.near_open[at]
        there = orbits[j]
        r, i, o = radius_at(there, now), inclination_at(there, now), node_at(there, now)
        tilt, turn = (i - inclination) * DEGREES, turned(o - raan) * node_scale
        row[RADIUS_FROM_CHASER] = clip((r - radius) * PER_50_KM, -LIMIT, LIMIT)
        row[INCLINATION_FROM_CHASER] = clip(tilt, -LIMIT, LIMIT)
        row[RAAN_FROM_CHASER] = clip(turn, -LIMIT, LIMIT)
        row[ANGLE_FROM_CHASER] = clip(math.sqrt(tilt * tilt + turn * turn), 0.0, LIMIT)
        row[RADIUS_FROM_HOME] = clip((r - home_radius) * PER_50_KM, -LIMIT, LIMIT)
        row[INCLINATION_FROM_HOME] = clip((i - home_inclination) * DEGREES, -LIMIT, LIMIT)
        row[RAAN_FROM_HOME] = clip(turned(o - home_raan) * node_scale, -LIMIT, LIMIT)
        row[PHASE] = turned(latitude_at(there, now) + cosine * o - phase) * (1.0 / math.pi)
        stay, spread, worth = choices.stay[at], choices.factor[at], choices.worth[at]
        row[PRIZE] = clip(worth, 0.0, LIMIT)
        row[WORTH] = clip(worth * stay[CHANCE], 0.0, LIMIT)
        row[IS_GONE], row[SUCCEEDS] = stay[GONE_CHANCE], stay[SUCCESS]
        row[SPREAD_NEEDED] = clip(needed * spread[DEVIATION] * PER_KM_S, 0.0, LIMIT)
        row[HOLDS] = 0.0
        if is_legal:
            row[HOLDS] = _chance_within(left / needed, spread) if needed > 0.0 else 1.0
        row[MEAN_TRY] = clip(stay[TRY_S] * PER_TEN_HOURS, 0.0, LIMIT)
        row[LATE_TRY] = clip(stay[LATE_TRY_S] * PER_TEN_HOURS, 0.0, LIMIT)
        row[MEAN_STAY] = clip(stay[STAY_S] * PER_TEN_HOURS, 0.0, LIMIT)
    mission[LEFT] = clip(left * PER_KM_S, 0.0, LIMIT)
    mission[LEFT_OF_BUDGET] = clip(left / max(full, 1.0), 0.0, LIMIT)
    mission[BUDGET] = clip(full * PER_KM_S, 0.0, LIMIT)
    mission[TIME] = clip(remaining / WEEK_S, 0.0, LIMIT)
    mission[TIME_OF_DURATION] = clip(remaining / max(end, 1.0), 0.0, LIMIT)
    mission[DURATION] = clip(end / WEEK_S, 0.0, LIMIT)
    mission[OPEN_TARGETS] = clip(open_targets / 50.0, 0.0, LIMIT)
    mission[LEGAL_SHARE] = legal / max(count, 1)
    mission[DOCKED] = 1.0 if docked else 0.0
    mission[EARNED] = 1.0 if since > 0 else 0.0
    mission[CHASER_RADIUS] = clip((radius - home_radius) * PER_50_KM, -LIMIT, LIMIT)
    mission[CHASER_INCLINATION] = clip((inclination - home_inclination) * DEGREES, -LIMIT, LIMIT)
    mission[CHASER_RAAN] = clip(turned(raan - home_raan) * node_scale, -LIMIT, LIMIT)
    mission[HOME_REACHABLE] = 1.0 if reachable else 0.0
    hours = remaining * PER_TEN_HOURS / max(open_targets, 1)
    mission[TIME_PER_TARGET] = clip(hours, 0.0, LIMIT)
